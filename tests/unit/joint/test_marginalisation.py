"""A robot drives many rounds in a room; all but the last stations are marginalised."""

import pickle
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from echoplan.acoustics.predicted_echo import Kind
from echoplan.geometry import wrap
from echoplan.joint.estimate import Estimate
from echoplan.joint.initial_estimate import initial_estimate
from echoplan.joint.map_extraction.map_builder import MapBuilder
from echoplan.joint.marginal_prior import MarginalPrior
from echoplan.joint.marginalisation import marginalise
from echoplan.joint.marginalisation import survey as survey_along
from echoplan.joint.optimisation.factors import prior
from echoplan.joint.optimisation.manhattan import ManhattanPrior
from echoplan.joint.optimisation.pose_factors import waypoint_prior
from echoplan.joint.pose_model_selection import estimate_map
from echoplan.joint.settings import EstimateSettings, PoseMode
from echoplan.model import Odometry, Sweep
from echoplan.preprocessing.measurements import join_measurements, measurements_of
from echoplan.simulation import Simulation
from echoplan.sources import find_rig, find_route, find_world

pytestmark = pytest.mark.slow

RIG = find_rig("rotary-array")
SETTINGS = EstimateSettings(poses=PoseMode.TRUST)


@cache
def sweeps() -> tuple[Sweep, ...]:
    return tuple(Simulation(world=find_world("paper-room"), rig=RIG, route=find_route("paper-room"), seed=5))


def estimate(first: int, last: int, marginal_prior: MarginalPrior | None = None) -> Estimate:
    chosen = sweeps()[first:last]
    detected = join_measurements([measurements_of(each, RIG) for each in chosen])
    measured_poses = np.array([each.station for each in chosen])
    return estimate_map(initial_estimate(RIG, detected, measured_poses, SETTINGS, marginal_prior))


def survey(known: Estimate) -> MapBuilder:
    """Return the map builder after the whole path of the robot."""
    everything = marginalise(known, len(known.measured_poses))
    return survey_along(known, everything, np.array([each.station[:2] for each in sweeps()]))


@cache
def prior_of_four_stations() -> MarginalPrior:
    """Return the marginal prior of the first four of seven stations."""
    return marginalise(estimate(0, 7), 4)


def test_landmarks_of_marginalised_stations_are_numbered() -> None:
    marginal_prior = prior_of_four_stations()
    numbers = [each.history.number for each in marginal_prior.features]
    assert len(numbers) >= 4
    assert len(set(numbers)) == len(numbers)
    assert marginal_prior.issued >= max(numbers)
    assert all(each.history.llr > 0 and each.history.pings > 0 for each in marginal_prior.features if each.is_wall)
    assert not any(each.is_known for each in marginal_prior.pending)


def test_stations_that_detect_a_wall_are_not_counted_as_missing_it() -> None:
    for each in prior_of_four_stations().features:
        if each.is_wall and each.history.llr > 100.0:
            assert each.history.supporting > 0
            assert each.history.missing == 0


def test_a_wall_that_most_stations_missed_is_not_drawn() -> None:
    marginal_prior, drawn = (
        prior_of_four_stations(),
        {each.owner for each in survey(estimate(4, 10, prior_of_four_stations())).segments},
    )
    first = next(each for each in marginal_prior.features if each.is_wall)
    missed = replace(first, history=replace(first.history, missing=99))
    rest = [each for each in marginal_prior.features if each is not first]
    without = survey(estimate(4, 10, replace(marginal_prior, features=[missed, *rest])))
    assert len({each.owner for each in without.segments}) == len(drawn) - 1
    assert first.history.number not in {each.history.number for each in without.features}


def test_a_landmark_that_most_stations_detected_through_a_wall_is_not_drawn() -> None:
    marginal_prior = prior_of_four_stations()
    column = next(each for each in marginal_prior.features if each.kind is Kind.CYLINDER)
    assert column.history.hidden == 0
    rest = [each for each in marginal_prior.features if each is not column]
    drawn = []
    for hidden in (1, 999):
        behind = replace(column, history=replace(column.history, hidden=hidden))
        found = survey(estimate(4, 10, replace(marginal_prior, features=[*rest, behind])))
        drawn.append(len(found.cylinders()))
    assert drawn == [1, 0]


def test_a_wall_through_which_other_landmarks_were_detected_is_not_drawn() -> None:
    marginal_prior = prior_of_four_stations()
    first = next(each for each in marginal_prior.features if each.is_wall)
    assert first.history.passed == 0
    passed = replace(first, history=replace(first.history, passed=9999))
    rest = [each for each in marginal_prior.features if each is not first]
    without = survey(estimate(4, 10, replace(marginal_prior, features=[passed, *rest])))
    assert first.history.number not in {each.history.number for each in without.features}


@pytest.mark.parametrize(("passed", "is_drawn"), [(4, True), (5, False)])
def test_a_wall_is_drawn_if_fewer_than_half_as_many_pings_passed_as_it_reflected(
    passed: int, *, is_drawn: bool
) -> None:
    marginal_prior = prior_of_four_stations()
    first = next(each for each in marginal_prior.features if each.is_wall)
    rest = [each for each in marginal_prior.features if each is not first]
    # Far away, where no station of the window changes the counts.
    away = replace(first, reflector=np.add(first.reflector, [0.0, 50.0, 0.0, 0.0]))
    away = replace(away, history=replace(first.history, passed=passed, pings=10))
    drawn = survey(estimate(4, 10, replace(marginal_prior, features=[*rest, away])))
    assert (first.history.number in {each.history.number for each in drawn.features}) == is_drawn


def test_a_landmark_that_explains_no_ping_best_is_not_drawn() -> None:
    marginal_prior = prior_of_four_stations()
    column = next(each for each in marginal_prior.features if each.kind is Kind.CYLINDER)
    rest = [each for each in marginal_prior.features if each is not column]
    drawn = []
    for pings in (1, 0):
        # Far away, out of range of the window.
        away = replace(column, reflector=np.add(column.reflector, [0.0, 50.0, 0.0, 0.0]))
        away = replace(away, history=replace(column.history, pings=pings))
        drawn.append(len(survey(estimate(4, 10, replace(marginal_prior, features=[*rest, away]))).features))
    assert drawn[0] == drawn[1] + 1


def test_no_pings_are_kept_after_marginalisation() -> None:
    assert all(
        len(each.ping_scores.pings) == len(each.llr_by_station) == 0 for each in prior_of_four_stations().features
    )


def test_a_map_from_a_marginal_prior_is_nearly_the_full_map() -> None:
    whole, parts = survey(estimate(0, 10)), survey(estimate(4, 10, prior_of_four_stations()))
    assert len(parts.walls([])) == len(whole.walls([])) == 8
    for one in parts.walls([]):
        other = min(whole.walls([]), key=lambda wall: float(np.abs(wall.endpoints_xy - one.endpoints_xy).max()))
        # Within 2 mm, since the weights of marginalised readings are not updated.
        assert one.offset == pytest.approx(other.offset, abs=0.002)
        assert abs(wrap(one.normal_angle - other.normal_angle)) < 0.004
        assert one.stations >= other.stations - 1
        assert one.pings == pytest.approx(other.pings, rel=0.15)
    assert len(parts.cylinders()) == len(whole.cylinders()) == 1
    assert len(parts.corners()) == len(whole.corners())


def test_walls_out_of_range_of_the_window_are_kept() -> None:
    away = estimate(0, 7)
    drawn = survey(away).walls([])
    marginal_prior = marginalise(away, 7)
    kept = survey(estimate(9, 10, marginal_prior)).walls([])
    assert len(kept) >= len(drawn)
    for wall in drawn:
        nearest = min(kept, key=lambda each: float(np.abs(each.endpoints_xy - wall.endpoints_xy).max()))
        assert nearest.offset == pytest.approx(wall.offset, abs=0.006)


def test_more_stations_reduce_the_variance_of_walls() -> None:
    def surest(marginal_prior: MarginalPrior | None) -> float:
        return min(float(each.covariance[1, 1]) for each in survey(estimate(7, 10, marginal_prior)).walls([]))

    assert surest(prior_of_four_stations()) < surest(None)


def test_memory_does_not_grow_when_stations_repeat() -> None:
    sizes, marginal_prior = [], MarginalPrior()
    for _ in range(6):
        marginal_prior = marginalise(estimate(0, 6, marginal_prior), 6)
        sizes.append(len(pickle.dumps(marginal_prior)))
    # Four stations are kept per cell, so that later rounds add none.
    assert sizes[-1] < 1.01 * sizes[3]


def test_with_fixed_poses_the_covariance_corrects_the_weights_of_the_readings() -> None:
    trusted = estimate(0, 4)
    solution = survey(trusted).solution
    assert solution.information_inflation == trusted.information_inflation() > 1.0
    features = slice(0, solution.layout.sonar)
    plain = np.diag(np.linalg.inv(solution.information))[features]
    without_floor = replace(solution, offset_sigma=0.0, model_error=0.0)
    assert np.all(np.diag(without_floor.covariance)[features] < plain)
    moved = trusted
    moved = replace(moved, pose_prior=moved.odometry())
    assert moved.information_inflation() == 1.0


def test_covariances_of_the_map_include_the_model_error() -> None:
    solution = survey(estimate(0, 4)).solution
    assert solution.sonar_sigmas()["range_offset"] >= min(solution.offset_sigma, 0.002) > 0.0
    for number in range(len(solution.reflectors)):
        place = solution.layout.feature(number)
        assert np.linalg.eigvalsh(solution.covariance[place, place]).min() > 0.0
    assert solution.model_error > 0.0


def test_heading_factors_are_part_of_the_marginal_prior(monkeypatch: pytest.MonkeyPatch) -> None:
    by_hand = estimate(0, 7)
    walls = np.array([each.is_wall for each in by_hand.features])
    by_hand = replace(
        by_hand.with_manhattan_prior(ManhattanPrior(walls, np.radians(1.0), along_axes=True)), has_heading_factors=True
    )
    by_hand = replace(by_hand, pose_prior=waypoint_prior(by_hand.measured_poses, by_hand.settings.pose_errors))
    information = marginalise(by_hand, 7).summary.information
    monkeypatch.setattr("echoplan.joint.marginalisation.heading_factors", lambda *_: prior([], sigma=[], residual=[]))
    less = marginalise(by_hand, 7).summary.information
    # The angle of the first wall is the first variable.
    assert information[0, 0] > 1.001 * less[0, 0]


def test_distrust_of_the_odometry_specification_is_kept() -> None:
    first = estimate(0, 7)
    assert marginalise(first, 3).trusts_specified_odometry
    first = replace(first, trusts_specified_odometry=False)
    specified = replace(RIG, odometry=Odometry(along=0.001))
    believing, doubting = MarginalPrior(), marginalise(first, 3)
    odometry_noise = [
        initial_estimate(specified, first.recorded, first.measured_poses, first.settings, marginal_prior).odometry_noise
        for marginal_prior in (believing, doubting)
    ]
    assert odometry_noise == [specified.odometry, None]
