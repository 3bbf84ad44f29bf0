"""A robot that goes round and round in a room, and forgets all but the last stations."""

import pickle
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from echoplan.acoustics.predicted_echo import Kind
from echoplan.geometry import wrap
from echoplan.joint.estimate import Account
from echoplan.joint.initial_estimate import initial_estimate
from echoplan.joint.map_extraction.map_builder import Survey
from echoplan.joint.marginal_prior import Memory
from echoplan.joint.marginalisation import leave
from echoplan.joint.marginalisation import survey as survey_along
from echoplan.joint.optimisation.factors import prior
from echoplan.joint.optimisation.manhattan import Squareness
from echoplan.joint.optimisation.pose_factors import waypoint_prior
from echoplan.joint.pose_model_selection import explained
from echoplan.joint.settings import AccountSettings, PoseMode
from echoplan.model import Odometry, Sweep
from echoplan.preprocessing.measurements import join_measurements, measurements_of
from echoplan.simulation import Simulation
from echoplan.sources import find_rig, find_route, find_world

RIG = find_rig("rotary-array")
SETTINGS = AccountSettings(poses=PoseMode.TRUST)


@cache
def sweeps() -> tuple[Sweep, ...]:
    return tuple(Simulation(world=find_world("paper-room"), rig=RIG, route=find_route("paper-room"), seed=5))


def account(first: int, last: int, memory: Memory | None = None) -> Account:
    chosen = sweeps()[first:last]
    detected = join_measurements([measurements_of(each, RIG) for each in chosen])
    given = np.array([each.station for each in chosen])
    return explained(initial_estimate(RIG, detected, given, SETTINGS, memory))


def survey(known: Account) -> Survey:
    """What is drawn after the whole way of the robot."""
    return survey_along(known, np.array([each.station[:2] for each in sweeps()]))


@cache
def halfway() -> Memory:
    """What the first four of seven stations left."""
    return leave(account(0, 7), 4)


def test_what_was_heard_by_those_that_go_is_known_and_numbered() -> None:
    memory = halfway()
    numbers = [each.history.number for each in memory.features]
    assert len(numbers) >= 4
    assert len(set(numbers)) == len(numbers)
    assert memory.issued >= max(numbers)
    assert all(each.history.total > 0 and each.history.pings > 0 for each in memory.features if each.is_wall)
    assert not any(each.is_known for each in memory.pending)


def test_those_that_hear_a_wall_are_not_counted_among_those_that_miss_it() -> None:
    for each in halfway().features:
        if each.is_wall and each.history.total > 100.0:
            assert each.history.supporting > 0
            assert each.history.missing == 0


def test_a_wall_that_most_stations_missed_is_not_drawn() -> None:
    memory, drawn = halfway(), {each.owner for each in survey(account(4, 10, halfway())).segments}
    first = next(each for each in memory.features if each.is_wall)
    missed = replace(first, history=replace(first.history, missing=99))
    rest = [each for each in memory.features if each is not first]
    without = survey(account(4, 10, replace(memory, features=[missed, *rest])))
    assert len({each.owner for each in without.segments}) == len(drawn) - 1
    assert first.history.number not in {each.history.number for each in without.features}


def test_what_most_stations_heard_through_a_wall_is_not_drawn() -> None:
    memory = halfway()
    column = next(each for each in memory.features if each.kind is Kind.CYLINDER)
    assert column.history.hidden == 0
    rest = [each for each in memory.features if each is not column]
    drawn = []
    for hidden in (1, 999):
        behind = replace(column, history=replace(column.history, hidden=hidden))
        found = survey(account(4, 10, replace(memory, features=[*rest, behind])))
        drawn.append(len(found.cylinders()))
    assert drawn == [1, 0]


def test_a_wall_through_which_others_were_heard_is_not_drawn() -> None:
    memory = halfway()
    first = next(each for each in memory.features if each.is_wall)
    assert first.history.passed == 0
    passed = replace(first, history=replace(first.history, passed=9999))
    rest = [each for each in memory.features if each is not first]
    without = survey(account(4, 10, replace(memory, features=[passed, *rest])))
    assert first.history.number not in {each.history.number for each in without.features}


@pytest.mark.parametrize(("passed", "is_drawn"), [(4, True), (5, False)])
def test_a_wall_is_drawn_if_fewer_than_half_as_many_pings_passed_as_it_reflected(
    passed: int, *, is_drawn: bool
) -> None:
    memory = halfway()
    first = next(each for each in memory.features if each.is_wall)
    rest = [each for each in memory.features if each is not first]
    # Far away, where no station at hand changes the counts.
    away = replace(first, reflector=np.add(first.reflector, [0.0, 50.0, 0.0, 0.0]))
    away = replace(away, history=replace(first.history, passed=passed, pings=10))
    drawn = survey(account(4, 10, replace(memory, features=[*rest, away])))
    assert (first.history.number in {each.history.number for each in drawn.features}) == is_drawn


def test_what_has_no_ping_of_its_own_is_not_drawn() -> None:
    memory = halfway()
    column = next(each for each in memory.features if each.kind is Kind.CYLINDER)
    rest = [each for each in memory.features if each is not column]
    drawn = []
    for pings in (1, 0):
        # Far away, where no station at hand hears it.
        away = replace(column, reflector=np.add(column.reflector, [0.0, 50.0, 0.0, 0.0]))
        away = replace(away, history=replace(column.history, pings=pings))
        drawn.append(len(survey(account(4, 10, replace(memory, features=[*rest, away]))).features))
    assert drawn[0] == drawn[1] + 1


def test_no_ping_stays() -> None:
    assert all(len(each.evidence.pings) == len(each.llr_by_station) == 0 for each in halfway().features)


def test_the_map_of_a_part_and_a_memory_is_nearly_the_map_of_all() -> None:
    whole, parts = survey(account(0, 10)), survey(account(4, 10, halfway()))
    assert len(parts.walls([])) == len(whole.walls([])) == 8
    for one in parts.walls([]):
        other = min(whole.walls([]), key=lambda wall: float(np.abs(wall.endpoints_xy - one.endpoints_xy).max()))
        # Two millimetres: a reading at hand is weighed anew whenever something moves, and one let go is not.
        assert one.offset == pytest.approx(other.offset, abs=0.002)
        assert abs(wrap(one.normal_angle - other.normal_angle)) < 0.004
        assert one.stations >= other.stations - 1
        assert one.pings == pytest.approx(other.pings, rel=0.15)
    assert len(parts.cylinders()) == len(whole.cylinders()) == 1
    assert len(parts.corners()) == len(whole.corners())


def test_what_is_known_of_walls_that_no_station_hears_any_more_is_not_lost() -> None:
    away = account(0, 7)
    drawn = survey(away).walls([])
    memory = leave(away, 7)
    kept = survey(account(9, 10, memory)).walls([])
    assert len(kept) >= len(drawn)
    for wall in drawn:
        nearest = min(kept, key=lambda each: float(np.abs(each.endpoints_xy - wall.endpoints_xy).max()))
        assert nearest.offset == pytest.approx(wall.offset, abs=0.006)


def test_more_stations_make_walls_surer() -> None:
    def surest(memory: Memory | None) -> float:
        return min(float(each.covariance[1, 1]) for each in survey(account(7, 10, memory)).walls([]))

    assert surest(halfway()) < surest(None)


def test_memory_grows_with_the_map_and_not_with_the_way() -> None:
    sizes, memory = [], Memory()
    for _ in range(6):
        memory = leave(account(0, 6, memory), 6)
        sizes.append(len(pickle.dumps(memory)))
    # Of four rounds all stations are kept, and of later ones none on top of them.
    assert sizes[-1] < 1.01 * sizes[3]


def test_features_are_told_as_surely_as_readings_tell_them_where_poses_are_trusted() -> None:
    trusted = account(0, 4)
    adjusted = survey(trusted).adjusted
    assert adjusted.information_inflation == trusted.information_inflation() > 1.0
    features = slice(0, adjusted.layout.sonar)
    plain = np.diag(np.linalg.inv(adjusted.information))[features]
    told = replace(adjusted, offset_sigma=0.0, model_error=0.0)
    assert np.all(np.diag(told.covariance)[features] < plain)
    moved = trusted
    moved = replace(moved, pose_prior=moved.odometry())
    assert moved.information_inflation() == 1.0


def test_what_the_model_of_the_sonar_lacks_is_in_the_covariances_of_the_map() -> None:
    adjusted = survey(account(0, 4)).adjusted
    assert adjusted.sonar_sigmas()["range_offset"] >= min(adjusted.offset_sigma, 0.002) > 0.0
    for number in range(len(adjusted.reflectors)):
        place = adjusted.layout.feature(number)
        assert np.linalg.eigvalsh(adjusted.covariance[place, place]).min() > 0.0
    assert adjusted.model_error > 0.0


def test_which_way_walls_lie_from_way_points_along_the_axes_is_remembered(monkeypatch: pytest.MonkeyPatch) -> None:
    by_hand = account(0, 7)
    walls = np.array([each.is_wall for each in by_hand.features])
    by_hand = replace(by_hand.with_squareness(Squareness(walls, np.radians(1.0), along_axes=True)), asks_bearings=True)
    by_hand = replace(by_hand, pose_prior=waypoint_prior(by_hand.given, by_hand.settings.pose_errors))
    told = leave(by_hand, 7).summary.information
    monkeypatch.setattr("echoplan.joint.marginalisation.heading_factors", lambda *_: prior([], sigma=[], residual=[]))
    less = leave(by_hand, 7).summary.information
    # The angle of the first wall is the first unknown.
    assert told[0, 0] > 1.001 * less[0, 0]


def test_a_rig_that_is_not_believed_is_not_believed_by_those_who_come_later() -> None:
    first = account(0, 7)
    assert leave(first, 3).trusts_specified_odometry
    first = replace(first, trusts_specified_odometry=False)
    told = replace(RIG, odometry=Odometry(along=0.001))
    believing, doubting = Memory(), leave(first, 3)
    wheels = [
        initial_estimate(told, first.recorded, first.given, first.settings, memory).wheels
        for memory in (believing, doubting)
    ]
    assert wheels == [told.odometry, None]
