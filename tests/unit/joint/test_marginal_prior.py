from dataclasses import replace

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.track_history import TrackHistory
from echoplan.joint.marginal_prior import MarginalPrior, marginalise_poses
from echoplan.joint.optimisation.factors import InformationPrior, LinearFactor, normal_equations
from echoplan.joint.optimisation.layout import SONAR_UNKNOWNS
from echoplan.joint.optimisation.range_factors import as_arrays
from echoplan.joint.optimisation.values import Values
from echoplan.joint.search.corner_echoes import CornerEcho
from helpers.expectations import SONAR, corner, cylinder, feature, wall

EAST, COLUMN, POINT = wall(0.0, 2.0), cylinder(10.0, 1.0, 0.1), corner(0.5, 0.5)


def tracked_landmark(reflector: FloatArray, number: int, extent: tuple[float, float] = (0.0, 0.0)) -> Hypothesis:
    return replace(feature(reflector, extent=extent, llr_by_station=()), history=TrackHistory(number=number))


FEATURES = [tracked_landmark(EAST, 1, (-1.0, 1.0)), tracked_landmark(COLUMN, 2), tracked_landmark(POINT, 3)]
# Seven parameters of the landmarks, and those of the sonar.
SIZE = 2 + 3 + 2 + len(SONAR_UNKNOWNS)


def information(size: int, seed: int = 3) -> FloatArray:
    """Return an information matrix in which all variables are correlated."""
    root = np.random.default_rng(seed).normal(size=(size, size + 3))
    whole: FloatArray = root @ root.T
    return whole


def marginal_prior(rest: int = 4) -> MarginalPrior:
    size = SIZE - 4 + rest
    whole = information(size)
    return MarginalPrior(
        features=FEATURES, summary=InformationPrior(np.arange(size), whole, whole @ np.arange(1.0, size + 1))
    )


def state(features: list[Hypothesis], poses: int = 0) -> Values:
    return Values(features=as_arrays(features, 0), model=SONAR, poses=np.zeros((poses, 3)))


def test_an_initial_marginal_prior_is_empty() -> None:
    assert MarginalPrior().is_empty
    assert MarginalPrior().reordered([], state([]).layout) is None
    assert not marginal_prior().is_empty


@pytest.mark.parametrize(
    ("place", "reach", "numbers"),
    [((0.0, 0.0), 2.5, [1, 3]), ((0.0, 0.0), 0.8, [3]), ((9.0, 0.0), 2.5, [2]), ((2.0, 5.0), 3.0, [])],
)
def test_landmarks_within_range_are_kept(place: tuple[float, float], reach: float, numbers: list[int]) -> None:
    part = marginal_prior().near(np.array([place]), reach)
    assert [each.history.number for each in part.features] == numbers
    assert [each.history.number for each in marginal_prior().beyond(part)] == [n for n in (1, 2, 3) if n not in numbers]


def test_the_distance_of_a_wall_is_that_of_its_detected_extent() -> None:
    assert len(marginal_prior().near(np.array([[1.9, 1.5]]), 0.6).features) == 1
    assert len(marginal_prior().near(np.array([[1.9, 2.5]]), 0.6).features) == 0


def test_removed_landmarks_are_marginalised_and_inform_the_sonar() -> None:
    part = marginal_prior().near(np.array([[0.0, 0.0]]), 2.5)
    kept = [0, 1, *range(5, SIZE)]
    covariance = np.linalg.inv(marginal_prior().summary.information)[np.ix_(kept, kept)]
    assert np.linalg.inv(part.summary.information) == pytest.approx(covariance, rel=1e-6)


def test_the_prior_is_reordered_to_the_layout_of_an_optimisation() -> None:
    new = feature(wall(1.0, 1.0))
    features = [FEATURES[2], new, FEATURES[0]]
    summary = marginal_prior().reordered(features, state(features).layout)
    assert summary is not None
    # In the order of the prior: the wall, the point, then the sonar.
    assert summary.columns.tolist() == [4, 5, 0, 1, *range(6, 6 + len(SONAR_UNKNOWNS))]


def test_a_landmark_that_was_removed_is_marginalised() -> None:
    features = FEATURES[:2]
    summary = marginal_prior().reordered(features, state(features).layout)
    assert summary is not None
    kept = [*range(5), *range(7, SIZE)]
    covariance = np.linalg.inv(marginal_prior().summary.information)[np.ix_(kept, kept)]
    assert np.linalg.inv(summary.information) == pytest.approx(covariance, rel=1e-6)


@pytest.mark.parametrize(("poses", "columns"), [(2, SIZE + 3), (0, SIZE)])
def test_the_first_pose_has_a_prior_only_if_poses_are_variables(poses: int, columns: int) -> None:
    summary = marginal_prior(rest=7).reordered(FEATURES, state(FEATURES, poses).layout)
    assert summary is not None
    assert len(summary.columns) == columns


def test_corner_echoes_are_indexed_by_position_in_a_list() -> None:
    detected = replace(marginal_prior(), echoes={(1, 3): CornerEcho(pings=8), (2, 7): CornerEcho(pings=5)})
    echoes = detected.corner_echoes_of([FEATURES[2], FEATURES[1], FEATURES[0]])
    assert echoes.pairs == {(0, 2): CornerEcho(pings=8)}
    assert echoes.corners_xy.tolist() == [[0.5, 0.5]]


def random_factors(count: int, size: int, seed: int) -> LinearFactor:
    rng = np.random.default_rng(seed)
    columns = np.tile(np.arange(size), (count, 1))
    return LinearFactor(columns, rng.normal(size=(count, size)), rng.normal(size=count), rng.uniform(0.5, 2.0, count))


def test_marginalised_factors_give_the_same_solution_as_kept_ones() -> None:
    now = state(FEATURES)
    old, new = random_factors(30, SIZE, 1), random_factors(30, SIZE, 2)
    together, right = normal_equations([old, new], SIZE)
    summary = marginalise_poses(now, [old], None, 0)
    later, vector = normal_equations([new], SIZE)
    later += summary.information
    vector += summary.vector - summary.information @ now.values
    assert np.linalg.solve(later, vector) == pytest.approx(np.linalg.solve(together, right))


def test_marginalising_in_two_steps_equals_marginalising_at_once() -> None:
    now = state(FEATURES)
    old, new = random_factors(30, SIZE, 1), random_factors(30, SIZE, 2)
    once = marginalise_poses(now, [old, new], None, 0)
    twice = marginalise_poses(now, [new], marginalise_poses(now, [old], None, 0), 0)
    assert twice.information == pytest.approx(once.information)
    assert twice.vector == pytest.approx(once.vector)


def test_marginalised_poses_are_eliminated_and_the_next_one_is_kept() -> None:
    now = state(FEATURES, poses=3)
    rows = random_factors(60, SIZE + 9, 4)
    summary = marginalise_poses(now, [rows], None, 2)
    whole, _ = normal_equations([rows], SIZE + 9)
    kept = [*range(SIZE), SIZE + 6, SIZE + 7, SIZE + 8]
    assert len(summary.columns) == SIZE + 3
    assert np.linalg.inv(summary.information) == pytest.approx(np.linalg.inv(whole)[np.ix_(kept, kept)], rel=1e-6)
