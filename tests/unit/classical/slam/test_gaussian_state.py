"""Gaussians over named blocks."""

import numpy as np
import pytest

from echoplan.classical.slam import GaussianState, Innovation
from echoplan.errors import InvalidValueError

STATE = GaussianState(
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
    assert STATE["wall"].tolist() == [3.0]
    assert STATE["pose"].tolist() == [1.0, 2.0]


def test_the_marginal_keeps_means_and_covariances_in_the_order_wanted() -> None:
    both = STATE.marginal(["wall", "pose"])
    assert both.mean.tolist() == [3.0, 1.0, 2.0]
    assert both.covariance.tolist() == [[0.7, 0.3, 0.0], [0.3, 2.0, 0.5], [0.0, 0.5, 1.0]]


def test_a_copy_of_a_block_is_as_unsure_and_moves_with_it() -> None:
    grown = STATE.extended("copy", STATE["pose"], given=["pose"], jacobian=np.eye(2), noise=np.zeros((2, 2)))
    np.testing.assert_allclose(grown.marginal(["copy"]).covariance, STATE.marginal(["pose"]).covariance)
    np.testing.assert_allclose(grown.covariance[3:, :3], STATE.covariance[:2])


def test_a_correction_is_that_of_least_squares() -> None:
    jacobian = np.array([[-1.0, 0.0, 1.0]])
    information = np.linalg.inv(STATE.covariance) + jacobian.T @ jacobian / 0.1
    expected = STATE.mean + np.linalg.solve(information, jacobian[0] * 0.4 / 0.1)
    updated = STATE.updated(SEEN)
    np.testing.assert_allclose(updated.mean, expected)
    np.testing.assert_allclose(updated.covariance, np.linalg.inv(information))


def test_the_order_of_two_corrections_does_not_matter() -> None:
    other = Innovation(
        blocks=("pose",), residual=np.array([0.1]), jacobian=np.array([[0.0, 1.0]]), noise=np.array([[0.2]])
    )

    def late(state: GaussianState, innovation: Innovation, by: GaussianState) -> GaussianState:
        moved = (by.marginal(innovation.blocks).mean - STATE.marginal(innovation.blocks).mean) @ innovation.jacobian.T
        return state.updated(
            Innovation(
                blocks=innovation.blocks,
                residual=innovation.residual - moved,
                jacobian=innovation.jacobian,
                noise=innovation.noise,
            )
        )

    first, second = STATE.updated(SEEN), STATE.updated(other)
    np.testing.assert_allclose(late(first, other, first).mean, late(second, SEEN, second).mean)


def test_the_squared_distance_counts_standard_deviations() -> None:
    spread = 0.7 + 2.0 - 2 * 0.3 + 0.1
    assert STATE.squared_distance(SEEN) == pytest.approx(0.4**2 / spread)


def test_a_wide_prediction_has_a_greater_deviance_than_a_narrow_one_that_fits_as_well() -> None:
    def deviance(noise: float) -> float:
        return STATE.deviance(
            Innovation(blocks=("wall",), residual=np.zeros(1), jacobian=np.ones((1, 1)), noise=np.array([[noise]]))
        )

    assert deviance(1.0) > deviance(0.1)
    assert deviance(0.3) == pytest.approx(np.log(2 * np.pi * 1.0))


def test_a_noise_that_is_none_is_refused() -> None:
    with pytest.raises(InvalidValueError, match="noise must have no negative eigenvalue"):
        Innovation(blocks=("wall",), residual=np.zeros(1), jacobian=np.ones((1, 1)), noise=-np.eye(1))
