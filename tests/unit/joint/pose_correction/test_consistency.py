"""Poses that are right and poses that drift, told apart by whether what is heard from them fits together."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.io import builtin_rig, builtin_world
from echoplan.joint.estimate import Account
from echoplan.joint.initial_estimate import initial_estimate
from echoplan.joint.marginal_prior import Course
from echoplan.joint.pose_correction.consistency import (
    agreement,
    agrees,
    are_at_odds,
    evidence,
    has_duplicated_walls,
    is_inconsistent,
    is_scattered,
    is_strained,
)
from echoplan.joint.pose_correction.pose_tracking import track
from echoplan.joint.pose_model_selection import explained
from echoplan.joint.search.duplicates import duplicate_pairs, without_duplicates
from echoplan.joint.settings import AccountSettings, PoseMode
from echoplan.model import Odometry, Polyline, Route, World
from echoplan.preprocessing.measurements import Measurements, join_measurements, measurements_of
from echoplan.simulation import OdometryNoise, Simulation, SimulationSettings

RIG = builtin_rig("rotary-array")
WAY = np.array([[0.0, 0.0, 0.0], [0.6, 0.0, 0.4], [1.0, 0.4, 1.2], [1.1, 1.0, 1.8], [0.7, 1.5, 2.8], [0.1, 1.4, -2.2]])
LOST = OdometryNoise(along=0.03, yaw_per_metre=np.radians(3.0))


# A room with a wall that bends by five degrees: such a one could as well be torn by drifting poses.
BENT = World(
    name="bent",
    polylines=(
        Polyline(points_xy=np.array([[-1.0, -0.5], [0.8, -0.5], [2.0, -0.395], [2.0, 2.5], [-1.0, 2.5]]), closed=True),
    ),
)


@cache
def drive(*, odometry: OdometryNoise | None, bent: bool) -> tuple[Measurements, FloatArray]:
    """What is heard of the square on a way round, and the poses as recorded."""
    settings = SimulationSettings() if odometry is None else SimulationSettings(odometry=odometry)
    simulation = Simulation(
        world=BENT if bent else builtin_world("square"),
        rig=RIG,
        route=Route(map_from_base=WAY),
        settings=settings,
        seed=3,
    )
    sweeps = tuple(simulation)
    return join_measurements([measurements_of(sweep, RIG) for sweep in sweeps]), np.array(
        [each.station for each in sweeps]
    )


def account_of(odometry: OdometryNoise | None, *, bent: bool = False, **settings: object) -> Account:
    detected, given = drive(odometry=odometry, bent=bent)
    return initial_estimate(RIG, detected, given, AccountSettings.model_validate(settings))


@cache
def trusted(*, odometry: OdometryNoise | None, bent: bool = False) -> Account:
    """An account that takes poses as they are."""
    return explained(account_of(odometry, bent=bent, poses=PoseMode.TRUST))


@cache
def corrected() -> Account:
    """An account of the drifting drive with corrected poses."""
    account = account_of(LOST)
    return track(account, account.odometry())


def test_from_exact_poses_all_agrees_and_nothing_is_doubtful() -> None:
    account = trusted(odometry=None)
    assert agreement(account) > 0.97
    assert agrees(account)
    assert not has_duplicated_walls(account)
    assert not is_inconsistent(account)


def test_walls_of_one_station_each_hold_nothing_together_however_well_all_agrees() -> None:
    account = trusted(odometry=None)
    assert not is_scattered(account)
    alone = np.where(np.arange(len(WAY)) == 2, 1.0, 0.0)
    account = replace(
        account, features=[replace(each, llr_by_station=alone * each.llr_by_station) for each in account.features]
    )
    assert is_scattered(account)
    assert agrees(account)
    assert is_inconsistent(account)


def test_drifting_poses_are_doubtful_even_where_most_echoes_find_some_wall() -> None:
    account = trusted(odometry=LOST)
    assert is_inconsistent(account)
    assert agreement(account) < agreement(trusted(odometry=None))


def test_without_features_nothing_agrees_and_without_echoes_all_does() -> None:
    account = account_of(None)
    assert agreement(account) == 0.0
    silent = account.recorded._replace(readings=np.full(len(account.recorded.readings), np.inf))
    assert agreement(initial_estimate(RIG, silent, account.given, AccountSettings())) == 1.0


def test_what_scatters_more_than_usual_does_not_agree() -> None:
    account = account_of(None)
    account = replace(account, features=trusted(odometry=None).features)
    account = replace(account, noise=0.02)
    assert agreement(account) > 0.97
    assert not agrees(account)


def test_stations_contradict_each_other_where_poses_drift_and_not_where_echoes_are_of_something_else() -> None:
    assert are_at_odds(trusted(odometry=LOST))
    account = trusted(odometry=None)
    account = replace(account, settings=AccountSettings(agreement=1.0))
    assert not agrees(account)
    assert not are_at_odds(account)
    account = replace(account, adjusted=None)
    assert are_at_odds(account)


@pytest.mark.parametrize(
    ("common", "own", "odds"), [(0.0025, 0.0005, False), (0.0025, 0.004, True), (0.0013, 0.004, False)]
)
def test_readings_that_are_rounded_err_together_unless_they_scatter(common: float, own: float, *, odds: bool) -> None:
    # In steps of a centimetre all readings of a wall from one station may be 2.5 mm off, but not if they scatter by 4.
    # A little more than a millimetre may be what the model of the sonar lacks.
    account = trusted(odometry=None)
    assert account.adjusted is not None
    rng, owners = np.random.default_rng(4), account.adjusted.owners
    together = rng.standard_normal((len(account.features), len(WAY)))[owners, account.measurements.stations]
    errors = common * together + own * rng.standard_normal(len(owners))
    account = replace(account, adjusted=replace(account.adjusted, residuals=np.where(owners >= 0, errors, 0.0)))
    account = replace(account, resolution=0.01, noise=float(np.hypot(common, own)))
    assert are_at_odds(account) is odds


def test_a_wall_there_twice_tears_the_map() -> None:
    account = account_of(None)
    walls = [each for each in trusted(odometry=None).features if each.is_wall]
    moved = [replace(each, reflector=each.reflector + np.array([0.0, 0.05, 0.03, 0.0])) for each in walls]
    account = replace(account, features=[*walls, moved[0]])
    assert not has_duplicated_walls(account)
    account = replace(account, features=[*walls, *moved])
    assert has_duplicated_walls(account)


def unquestioned(account: Account) -> Account:
    """Return an account whose pings agree and leave no residuals."""
    assert account.adjusted is not None
    adjusted = replace(account.adjusted, residuals=np.zeros(len(account.adjusted.residuals)))
    return replace(account, settings=AccountSettings(agreement=0.5), adjusted=adjusted)


def test_a_wall_that_a_drive_tore_in_two_makes_poses_doubtful_and_a_bend_does_not() -> None:
    torn, bent = trusted(odometry=LOST), trusted(odometry=None, bent=True)
    assert is_inconsistent(torn)
    assert not is_inconsistent(bent)
    # That pings do not agree from the poses of the drive would be enough.
    torn, bent = unquestioned(torn), unquestioned(bent)
    for account in (torn, bent):
        assert agrees(account)
        assert duplicate_pairs(account.features, account.settings.copies)
    assert are_at_odds(torn)
    assert not are_at_odds(bent)
    torn = replace(torn, features=without_duplicates(torn.features, torn.settings.copies))
    assert not are_at_odds(torn)


def test_no_two_walls_cross_however_well_both_are_known() -> None:
    account = trusted(odometry=None, bent=True)
    (pair,) = duplicate_pairs(account.features, account.settings.copies)
    assert not are_at_odds(account)
    longer = {number: tuple(np.add(account.features[number].extent, (-0.5, 0.5))) for number in pair}
    features = [replace(each, extent=longer.get(number, each.extent)) for number, each in enumerate(account.features)]
    assert are_at_odds(replace(account, features=features))


def test_corrected_poses_have_more_evidence_than_drifting_ones() -> None:
    assert evidence(corrected()) > evidence(trusted(odometry=LOST)) + 100.0


def test_free_poses_cost_half_the_logarithm_of_their_readings_for_each_parameter() -> None:
    account = corrected()
    free = evidence(replace(account, pose_prior=None))
    # The first pose is the frame; each of the others is told by a hundred readings or more.
    cost = free - evidence(account)
    assert cost == pytest.approx(5 * 1.5 * np.log(250), rel=0.2)


def test_a_wall_there_twice_speaks_against_the_poses() -> None:
    account = account_of(None)
    account = replace(account, features=trusted(odometry=None).features)
    once = evidence(account), agreement(account)
    wall = next(each for each in account.features if each.is_wall)
    copied = replace(
        wall, reflector=wall.reflector + np.array([0.0, 0.0, 0.03, 0.0]), llr_by_station=0.5 * wall.llr_by_station
    )
    account = replace(account, features=[*account.features, copied])
    assert agreement(account) == once[1]
    assert evidence(account) < once[0] - 12.0


def test_a_wall_that_pings_look_through_speaks_against_the_poses() -> None:
    account = account_of(None)
    account = replace(account, features=trusted(odometry=None).features)
    without = evidence(account)
    wall = next(each for each in account.features if each.is_wall)
    # Too far off to be the same wall twice, and nearer, so that whoever hears the one looks through the other.
    nearer = wall.reflector - np.array([0.0, 0.0, 0.4, 0.0])
    there = replace(account.explanation.score(nearer), extent=wall.extent)
    account = replace(account, features=[*account.features, there])
    cost = account.settings.search.accept
    assert not duplicate_pairs(account.features, account.settings.copies)
    assert evidence(account) < without - cost - 12.0
    account = replace(account, features=[*account.features[:-1], replace(there, extent=(0.0, 0.0))])
    assert evidence(account) == pytest.approx(without - cost, abs=6.0)


def test_poses_that_nobody_would_believe_cost_what_makes_them_unlikely() -> None:
    account = corrected()
    likely = evidence(account)
    account = replace(account, poses=account.poses + np.outer(np.arange(len(account.poses)) >= 3, [0.5, 0.0, 0.0]))
    assert evidence(account) < likely - 50.0


def test_steps_that_lead_ten_times_farther_astray_than_was_told_are_strained() -> None:
    account = corrected()
    assert not is_strained(account)
    detected, given = drive(odometry=LOST, bent=False)
    told = Odometry(along=0.003, lateral=0.0, yaw_per_metre=np.radians(0.3), yaw_per_radian=0.0)
    sure = initial_estimate(replace(RIG, odometry=told), detected, given, AccountSettings())
    sure = replace(sure, poses=account.poses, pose_prior=sure.odometry())
    assert is_strained(sure)
    assert not is_strained(trusted(odometry=None))


def test_a_single_slip_strains_no_other_step() -> None:
    account = corrected()
    account = replace(account, poses=account.poses + np.outer(np.arange(len(account.poses)) >= 3, [0.5, 0.0, 0.0]))
    assert evidence(account) < evidence(corrected()) - 50.0
    assert not is_strained(account)


def test_drift_is_corrected_without_being_asked_and_exact_poses_are_trusted() -> None:
    lost = explained(account_of(LOST))
    assert lost.course is Course.TRACKED
    assert lost.verdict.startswith("corrected")
    right = explained(account_of(None))
    assert right.course is Course.TRUSTED
    assert right.verdict.startswith("used as recorded: ")
    assert right.poses == pytest.approx(WAY)


def test_asked_to_correct_exact_poses_it_does_no_harm() -> None:
    asked = explained(account_of(None, poses=PoseMode.CORRECT))
    assert asked.course is Course.TRUSTED
    assert asked.poses == pytest.approx(WAY)
    assert asked.verdict.startswith("no correction was needed")
    right = trusted(odometry=None)
    assert [each.key for each in asked.features] == [each.key for each in right.features]


def test_asked_to_correct_drift_it_does() -> None:
    asked = explained(account_of(LOST, poses=PoseMode.CORRECT))
    assert asked.course is Course.TRACKED
    assert asked.verdict.startswith("corrected, as asked for: ")
    assert np.hypot(*(asked.poses - WAY)[:, :2].T).max() < 0.02
