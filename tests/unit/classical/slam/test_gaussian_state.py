"""Gaussians over named blocks."""

import numpy as np
import pytest

from echoplan.classical.slam import Belief, Innovation
from echoplan.errors import InvalidValueError

BELIEF = Belief(
    sizes={"pose": 2, "wall": 1},
    mean=np.array([1.0, 2.0, 3.0]),
    covariance=np.array([[2.0, 0.5, 0.3], [0.5, 1.0, 0.0], [0.3, 0.0, 0.7]]),
)
SEEN = Innovation(
    blocks=("wall", "pose"),
    residual=np.array([0.4]),
    jacobian=np.array([[1.0, -1.0, 0.0]]),
    noise=np.array([[0.1]]),
)


def test_a_block_is_found_by_its_name() -> None:
    assert BELIEF["wall"].tolist() == [3.0]
    assert BELIEF["pose"].tolist() == [1.0, 2.0]


def test_the_marginal_keeps_means_and_covariances_in_the_order_wanted() -> None:
    both = BELIEF.of(["wall", "pose"])
    assert both.mean.tolist() == [3.0, 1.0, 2.0]
    assert both.covariance.tolist() == [[0.7, 0.3, 0.0], [0.3, 2.0, 0.5], [0.0, 0.5, 1.0]]


def test_a_copy_of_a_block_is_as_unsure_and_moves_with_it() -> None:
    grown = BELIEF.extended("copy", BELIEF["pose"], given=["pose"], jacobian=np.eye(2), noise=np.zeros((2, 2)))
    np.testing.assert_allclose(grown.of(["copy"]).covariance, BELIEF.of(["pose"]).covariance)
    np.testing.assert_allclose(grown.covariance[3:, :3], BELIEF.covariance[:2])


def test_a_correction_is_that_of_least_squares() -> None:
    jacobian = np.array([[-1.0, 0.0, 1.0]])
    information = np.linalg.inv(BELIEF.covariance) + jacobian.T @ jacobian / 0.1
    expected = BELIEF.mean + np.linalg.solve(information, jacobian[0] * 0.4 / 0.1)
    corrected = BELIEF.corrected(SEEN)
    np.testing.assert_allclose(corrected.mean, expected)
    np.testing.assert_allclose(corrected.covariance, np.linalg.inv(information))


def test_the_order_of_two_corrections_does_not_matter() -> None:
    other = Innovation(
        blocks=("pose",), residual=np.array([0.1]), jacobian=np.array([[0.0, 1.0]]), noise=np.array([[0.2]])
    )

    def late(belief: Belief, innovation: Innovation, by: Belief) -> Belief:
        moved = (by.of(innovation.blocks).mean - BELIEF.of(innovation.blocks).mean) @ innovation.jacobian.T
        return belief.corrected(
            Innovation(
                blocks=innovation.blocks,
                residual=innovation.residual - moved,
                jacobian=innovation.jacobian,
                noise=innovation.noise,
            )
        )

    first, second = BELIEF.corrected(SEEN), BELIEF.corrected(other)
    np.testing.assert_allclose(late(first, other, first).mean, late(second, SEEN, second).mean)


def test_the_squared_distance_counts_standard_deviations() -> None:
    spread = 0.7 + 2.0 - 2 * 0.3 + 0.1
    assert BELIEF.squared_distance(SEEN) == pytest.approx(0.4**2 / spread)


def test_a_vague_explanation_surprises_more_than_a_sharp_one_that_fits_as_well() -> None:
    def surprise(noise: float) -> float:
        return BELIEF.surprise(
            Innovation(blocks=("wall",), residual=np.zeros(1), jacobian=np.ones((1, 1)), noise=np.array([[noise]]))
        )

    assert surprise(1.0) > surprise(0.1)
    assert surprise(0.3) == pytest.approx(np.log(2 * np.pi * 1.0))


def test_a_noise_that_is_none_is_refused() -> None:
    with pytest.raises(InvalidValueError, match="noise must have no negative eigenvalue"):
        Innovation(blocks=("wall",), residual=np.zeros(1), jacobian=np.ones((1, 1)), noise=-np.eye(1))
