from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from echoplan.acoustics.predicted_echo import EchoModel
from echoplan.joint.estimate import Estimate
from echoplan.joint.initial_estimate import initial_estimate
from echoplan.joint.mapper import JointSettings
from echoplan.joint.optimisation.figure_of_merit import fit_figure_of_merit
from echoplan.joint.pose_model_selection import estimate_map
from echoplan.joint.settings import PoseMode
from echoplan.preprocessing.measurements import Measurements, join_measurements, measurements_of
from echoplan.sources import open_source
from helpers.expectations import REACH, ROOM, SONAR, cylinder, expected, feature, listening

COLUMN = cylinder(0.2, 0.9, 0.1)
LOUD = [feature(each, extent=(-REACH, REACH), llr_by_station=[20.0] * 4) for each in (*ROOM, COLUMN)]
# Scale of the logistic detection probability of all surfaces together [dB].
FADING = 1.56


def detected(sonar: EchoModel, *, seed: int = 0) -> Measurements:
    """Return pings that read the nearest landmark among those that are randomly detected."""
    measurements, rng = listening(step=np.radians(2.0)), np.random.default_rng(seed)
    nearest = measurements.readings
    for each in LOUD:
        excesses, readings = expected(measurements, each.reflector, sonar)
        chances = 1.0 / (1.0 + np.exp(-np.clip(excesses / FADING, -30.0, 30.0)))
        nearest = np.minimum(nearest, np.where(rng.random(len(nearest)) < chances, readings, np.inf))
    return measurements._replace(readings=nearest)


@pytest.mark.parametrize(("merit", "ka"), [(SONAR.figure_of_merit + 2.0, 4.0), (SONAR.figure_of_merit - 2.0, 5.5)])
def test_figure_of_merit_and_beam_are_estimated_from_detections(merit: float, ka: float) -> None:
    true = replace(SONAR, figure_of_merit=merit, ka=ka)
    found = fit_figure_of_merit(detected(true), SONAR, LOUD, prior_mean=SONAR.figure_of_merit)
    assert found.figure_of_merit == pytest.approx(merit, abs=1.0)
    assert found.ka == pytest.approx(ka, abs=0.2)


def test_only_figure_of_merit_and_beam_are_changed() -> None:
    learned = replace(SONAR, range_offset=0.001, walk_gain=0.02, range_scale=0.01)
    found = fit_figure_of_merit(detected(SONAR), learned, LOUD, prior_mean=SONAR.figure_of_merit)
    same = replace(found, figure_of_merit=learned.figure_of_merit, ka=learned.ka)
    assert (same.range_offset, same.walk_gain, same.range_scale) == (0.001, 0.02, 0.01)
    assert same.absorption == learned.absorption
    assert found.ka != learned.ka


def test_the_range_scale_does_not_change_detections() -> None:
    measurements = detected(SONAR)
    cold = measurements._replace(readings=measurements.readings / 1.05)
    plain = fit_figure_of_merit(measurements, SONAR, LOUD, prior_mean=SONAR.figure_of_merit)
    stretched = fit_figure_of_merit(cold, replace(SONAR, range_scale=0.05), LOUD, prior_mean=SONAR.figure_of_merit)
    assert (stretched.figure_of_merit, stretched.ka) == pytest.approx((plain.figure_of_merit, plain.ka), abs=0.05)


def test_masked_pings_do_not_change_the_figure_of_merit() -> None:
    measurements = detected(SONAR)
    facing_east = (measurements.ux > 0.9) & (measurements.stations < 2)
    masked = measurements._replace(readings=np.where(facing_east, 0.4, measurements.readings))
    deaf = measurements._replace(readings=np.where(facing_east, np.inf, measurements.readings))
    plain, behind, missed = (
        fit_figure_of_merit(each, SONAR, LOUD, prior_mean=SONAR.figure_of_merit)
        for each in (measurements, masked, deaf)
    )
    assert behind.figure_of_merit == pytest.approx(plain.figure_of_merit, abs=0.5)
    assert missed.figure_of_merit < plain.figure_of_merit - 1.0


def test_pings_beside_the_extent_of_a_wall_do_not_count() -> None:
    measurements, columns = detected(SONAR), [LOUD[4]] * 3
    beside = [feature(each, extent=(3.0, 3.5), llr_by_station=[20.0] * 4) for each in ROOM]
    alone, more = (
        fit_figure_of_merit(measurements, SONAR, known, prior_mean=SONAR.figure_of_merit)
        for known in (columns, columns + beside)
    )
    assert (more.figure_of_merit, more.ka) == (alone.figure_of_merit, alone.ka)


def test_with_too_few_clear_landmarks_the_sonar_is_unchanged() -> None:
    measurements = detected(replace(SONAR, figure_of_merit=SONAR.figure_of_merit + 3.0))
    faint = [replace(each, llr_by_station=np.array([20.0, 7.0, 7.0, 7.0])) for each in LOUD]
    for known in ([], LOUD[:2], faint, [*LOUD[:2], *faint]):
        assert fit_figure_of_merit(measurements, SONAR, known, prior_mean=SONAR.figure_of_merit) is SONAR


def test_landmarks_of_two_stations_are_used_only_without_better_ones() -> None:
    true = replace(SONAR, figure_of_merit=SONAR.figure_of_merit + 3.0)
    measurements, twice = (
        detected(true),
        [replace(each, llr_by_station=np.array([20.0, 20.0, 7.0, 7.0])) for each in LOUD],
    )
    few, all_, mixed = (
        fit_figure_of_merit(measurements, SONAR, known, prior_mean=SONAR.figure_of_merit)
        for known in (twice, LOUD, [*LOUD[:3], *twice[3:]])
    )
    assert few.figure_of_merit == all_.figure_of_merit
    assert (
        mixed.figure_of_merit
        == fit_figure_of_merit(measurements, SONAR, LOUD[:3], prior_mean=SONAR.figure_of_merit).figure_of_merit
    )


def test_a_weak_wide_beam_is_found_from_a_strong_narrow_start() -> None:
    true = replace(SONAR, figure_of_merit=16.0, ka=3.4)
    found = fit_figure_of_merit(detected(true), replace(SONAR, figure_of_merit=34.0, ka=7.2), LOUD, prior_mean=26.0)
    assert found.figure_of_merit == pytest.approx(16.0, abs=1.5)
    assert found.ka == pytest.approx(3.4, abs=0.3)


def test_corners_and_edges_are_not_used() -> None:
    points = [feature(np.array([kind, 2.0, 1.5, 0.0]), llr_by_station=[20.0] * 4) for kind in (2.0, 3.0)]
    assert fit_figure_of_merit(detected(SONAR), SONAR, [*LOUD[:2], *points], prior_mean=SONAR.figure_of_merit) is SONAR


@cache
def in_a_square() -> Estimate:
    """Return the estimate of a square room from fixed poses."""
    source = open_source("sim:square")
    sweeps = list(source)
    detected = join_measurements([measurements_of(sweep, source.rig) for sweep in sweeps])
    poses = np.array([sweep.map_from_base[0] for sweep in sweeps])
    return estimate_map(initial_estimate(source.rig, detected, poses, JointSettings(poses=PoseMode.TRUST)))


def test_readings_determine_figure_of_merit_and_beam_better_than_detections() -> None:
    solution = in_a_square().solution
    assert solution is not None
    sigmas = solution.sonar_sigmas()
    assert 1e-4 < sigmas["log_ka"] < 0.01
    assert 1e-3 < sigmas["figure_of_merit"] < 0.5


def test_with_drifting_poses_only_detections_determine_the_beam() -> None:
    estimate = in_a_square()
    estimate = replace(estimate, is_calibrated=False, pose_prior=estimate.odometry())
    estimate = estimate.refine_calibration()
    assert not estimate.is_calibrated
    estimate = estimate.optimise(estimate.noise, estimate.pose_prior)
    assert estimate.solution is not None
    assert estimate.solution.sonar_sigmas()["log_ka"] < 1e-6


def test_without_landmarks_there_is_no_beam_prior() -> None:
    estimate = in_a_square()
    estimate = replace(estimate, features=[], beam_prior=None)
    estimate = estimate.estimate_figure_of_merit()
    assert estimate.beam_prior is None
