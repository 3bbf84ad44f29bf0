"""Detections of a wall as a function of the bearing determine headings much better than ranges do."""

from dataclasses import replace

import numpy as np
import pytest

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import FloatArray
from echoplan.joint.optimisation.edge_diffraction import edges_of
from echoplan.joint.optimisation.heading_factors import heading_factor, heading_measurements_of
from echoplan.joint.optimisation.layout import SONAR_UNKNOWNS
from echoplan.joint.optimisation.manhattan import ManhattanPrior
from echoplan.joint.optimisation.optimiser import OptimiserSettings, Priors, heading_factors, optimise
from echoplan.joint.optimisation.pose_factors import (
    PosePrior,
    PoseSettings,
    at_poses,
    odometry_prior,
    waypoint_prior,
)
from echoplan.joint.optimisation.range_factors import Features
from echoplan.joint.optimisation.values import Values
from echoplan.preprocessing.measurements import Measurements
from echoplan.preprocessing.servo import ServoError, turned_by
from helpers.expectations import REACH, ROOM, SONAR, cylinder, listening, pings_of

PLACES = ((-0.3, 0.1), (0.2, -0.2))
EASTWARD = ROOM[:1]
BEAM_SIGMA = np.radians(6.0)
AXES = ManhattanPrior(np.ones(len(ROOM), dtype=bool), np.radians(1.0), along_axes=True)


def features(reflectors: FloatArray, *, unheard_from: int | None = None) -> Features:
    attenuations = np.zeros((len(reflectors), len(PLACES)))
    if unheard_from is not None:
        attenuations[:, unheard_from] = np.inf
    extents = np.tile([-REACH, REACH], (len(reflectors), 1))
    return Features(reflectors, extents, attenuations, np.zeros(attenuations.shape), edges_of(reflectors, extents))


def at(heading: float) -> FloatArray:
    """Return both poses with the same heading."""
    return np.column_stack([PLACES, np.full(len(PLACES), heading)])


def detected(reflectors: FloatArray, *, recorded_heading: float = 0.0) -> Measurements:
    """Return readings of two stations that face east, rounded to centimetres, from poses with another heading."""
    pings = pings_of(listening(PLACES, step=np.radians(2.0)), reflectors)
    rounded = pings._replace(readings=0.01 * np.round(pings.readings / 0.01))
    return at_poses(rounded, at(0.0), at(recorded_heading))


@pytest.mark.parametrize("off", [-8.0, -3.0, 0.0, 5.0])
def test_detections_of_a_wall_determine_the_heading(off: float) -> None:
    mistaken = detected(EASTWARD, recorded_heading=np.radians(off))
    found = heading_measurements_of(mistaken, SONAR.tabulated(), features(EASTWARD), at(np.radians(off))[:, 2])
    assert np.degrees(found.headings) == pytest.approx([0.0, 0.0], abs=1.0)
    assert np.sqrt(found.variances) == pytest.approx([BEAM_SIGMA] * 2, rel=0.1)


def test_masked_pings_give_no_heading() -> None:
    pings = detected(EASTWARD)
    masked = pings._replace(readings=np.where(pings.stations == 1, 0.3, pings.readings))
    found = heading_measurements_of(masked, SONAR.tabulated(), features(EASTWARD), np.zeros(2))
    assert found.stations.tolist() == [0]


def test_stations_that_do_not_detect_a_wall_give_no_heading() -> None:
    found = heading_measurements_of(
        detected(EASTWARD), SONAR.tabulated(), features(EASTWARD, unheard_from=0), np.zeros(2)
    )
    assert found.stations.tolist() == [1]


def test_only_walls_determine_headings() -> None:
    post = cylinder(1.0, 0.0, 0.1)[None]
    assert len(heading_measurements_of(detected(post), SONAR.tabulated(), features(post), np.zeros(2)).walls) == 0


def state(landmarks: Features, poses: FloatArray) -> Values:
    return Values(features=landmarks, model=SONAR, poses=poses)


def test_the_jacobian_of_heading_factors_equals_finite_differences() -> None:
    poses, landmarks = np.column_stack([PLACES, [0.1, -0.2]]), features(EASTWARD)
    now, moved = state(landmarks, poses), landmarks.reflectors.copy()
    bearings = heading_measurements_of(detected(EASTWARD), SONAR.tabulated(), landmarks, poses[:, 2])
    rows = heading_factor(bearings, now)
    servo = [now.layout.sonar + SONAR_UNKNOWNS.index(each) for each in ("servo_gain", "servo_offset")]
    assert rows.columns.tolist() == [[0, now.layout.pose + 2, *servo], [0, now.layout.pose + 5, *servo]]
    moved[:, 1] += 0.02
    later = state(landmarks._replace(reflectors=moved), poses + np.array([0.0, 0.0, 0.05]))
    later = replace(later, servo=ServoError(0.97, 0.04))
    assert heading_factor(bearings, later).residuals == pytest.approx(
        rows.residuals - rows.jacobian @ [0.02, 0.05, -0.03, 0.04]
    )


def test_with_fixed_poses_heading_factors_determine_servo_gain_and_offset() -> None:
    pings, true = detected(ROOM), ServoError(0.95, np.radians(4.0))
    # The servo turned from -pi to pi and recorded more.
    recorded = pings._replace(angles=(pings.angles - true.offset) / true.gain)
    as_recorded = turned_by(recorded, error=ServoError(), before=true)
    priors = pose_prior(waypoint_prior(at(0.0), PoseSettings()), None)._replace(poses=None, servo=ServoError())
    start = Values(features=features(ROOM), model=SONAR)
    found = optimise(as_recorded, start, priors, OptimiserSettings())
    sigmas = found.sonar_sigmas()
    assert found.servo.gain == pytest.approx(true.gain, abs=0.02)
    assert found.servo.offset == pytest.approx(true.offset, abs=np.radians(1.5))
    assert sigmas["servo_gain"] < 0.03
    assert sigmas["servo_offset"] < np.radians(3.5)
    held = optimise(as_recorded, start, priors._replace(servo=None), OptimiserSettings())
    assert held.servo == pytest.approx(ServoError(), abs=1e-6)


def pose_prior(poses: PosePrior, manhattan_prior: ManhattanPrior | None) -> Priors:
    return Priors(
        noise=0.004,
        offset_sigma=0.003,
        walk_gain=SONAR.walk_gain,
        has_servo=False,
        scale_sigma=0.002,
        poses=poses,
        bias_sigma=0.012,
        manhattan_prior=manhattan_prior,
        bearings=True,
    )


@pytest.mark.parametrize("off", [-6.0, 6.0])
def test_walls_along_the_axes_determine_the_headings_of_waypoints(off: float) -> None:
    # The prior sigma of headings is eleven degrees.
    landmarks = at(np.radians(off))
    pings, start = detected(ROOM, recorded_heading=np.radians(off)), state(features(ROOM), landmarks)
    priors = pose_prior(waypoint_prior(landmarks, PoseSettings()), AXES)
    found = optimise(pings, start, priors, OptimiserSettings())
    assert np.degrees(found.poses[:, 2]) == pytest.approx([0.0, 0.0], abs=1.5)
    assert np.sqrt(np.diag(found.covariance))[-1] < np.radians(3.5)


@pytest.mark.parametrize("manhattan_prior", [None, AXES._replace(along_axes=False)])
def test_walls_of_free_direction_give_no_heading_factors(manhattan_prior: ManhattanPrior | None) -> None:
    landmarks = at(0.0)
    priors = pose_prior(waypoint_prior(landmarks, PoseSettings()), manhattan_prior)
    assert len(heading_factors(detected(ROOM), state(features(ROOM), landmarks), priors).residuals) == 0


def test_odometry_fixed_poses_and_first_estimates_have_no_heading_factors() -> None:
    landmarks = at(0.0)
    odometry_noise = pose_prior(odometry_prior(landmarks, PoseSettings()), AXES)
    by_hand = pose_prior(waypoint_prior(landmarks, PoseSettings()), AXES)
    for priors in (odometry_noise, odometry_noise._replace(poses=None), by_hand._replace(bearings=False)):
        assert len(heading_factors(detected(ROOM), state(features(ROOM), landmarks), priors).residuals) == 0


def test_corners_and_cylinders_are_ignored() -> None:
    landmarks = features(np.concatenate([[[Kind.CORNER, 2.0, 1.5, 0.0]], ROOM]))
    found = heading_measurements_of(detected(ROOM), SONAR.tabulated(), landmarks, np.zeros(2))
    assert sorted(set(found.walls.tolist())) == [1, 2, 3, 4]
