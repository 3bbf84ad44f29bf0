import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from echoplan.acoustics.predicted_echo import EchoModel, Kind
from echoplan.arrays import FloatArray
from echoplan.geometry import intersections
from echoplan.joint.optimisation.edge_diffraction import edges_of
from echoplan.joint.optimisation.layout import SONAR_UNKNOWNS
from echoplan.joint.optimisation.optimiser import (
    Features,
    OptimiserSettings,
    Priors,
    optimise,
    range_factors,
)
from echoplan.joint.optimisation.pose_factors import PosePrior, at_poses
from echoplan.joint.optimisation.solution import Solution
from echoplan.joint.optimisation.values import Values
from echoplan.preprocessing.measurements import Measurements, select_measurements
from echoplan.preprocessing.servo import ServoError, apply_servo_latency, turned_by
from helpers.constants import settings_with
from helpers.expectations import NOISE, REACH, ROOM, SONAR, corner, cylinder, edge, expected, listening, pings_of, wall

COLUMN = cylinder(0.2, 0.9, 0.1)
CORNERS = [corner(x, y) for x in (2.0, -2.0) for y in (1.5, -1.5)]
PRIORS = Priors(noise=NOISE, offset_sigma=0.0015, walk_gain=SONAR.walk_gain, has_servo=False, scale_sigma=0.03)


def features(reflectors: Sequence[FloatArray] | FloatArray, stations: int = 4) -> Features:
    """Return landmarks that all stations detect, walls over their whole length."""
    rows, count = np.array(reflectors).reshape(-1, 4), len(reflectors)
    extents, none = np.tile([-REACH, REACH], (count, 1)), np.zeros((count, stations))
    return Features(
        reflectors=rows, extents=extents, attenuations=none, bias_variances=none, ends=edges_of(rows, extents)
    )


def solution(
    measurements: Measurements,
    reflectors: Sequence[FloatArray] | FloatArray,
    *,
    sonar: EchoModel = SONAR,
    priors: Priors = PRIORS,
    **settings: float,
) -> Solution:
    start = Values(features=features(reflectors, len(measurements.centers)), model=sonar)
    return optimise(measurements, start, priors, settings_with(OptimiserSettings, **settings))


def displaced(reflectors: Sequence[FloatArray] | FloatArray, *, seed: int = 0, size: float = 0.01) -> FloatArray:
    """Return the landmarks displaced by about a centimetre."""
    rng = np.random.default_rng(seed)
    moved = np.array(reflectors) + size * np.pad(rng.uniform(-1, 1, (len(reflectors), 3)), ((0, 0), (1, 0)))
    moved[:, 3] *= moved[:, 0] == Kind.CYLINDER
    return moved


def sigmas(found: Solution) -> FloatArray:
    deviations: FloatArray = np.sqrt(np.diag(found.covariance))
    return deviations


def test_walls_and_cylinders_converge_to_their_true_places() -> None:
    truth = [*ROOM, COLUMN]
    found = solution(pings_of(listening(), truth), displaced(truth))
    assert found.reflectors == pytest.approx(np.array(truth), abs=0.0005)


def test_the_residuals_of_noisy_readings_have_the_scatter_of_the_noise() -> None:
    truth = [*ROOM, COLUMN]
    measurements = pings_of(listening(), truth, noise=NOISE, rng=np.random.default_rng(1))
    found = solution(measurements, displaced(truth))
    assert found.robust_sigma == pytest.approx(NOISE, rel=0.2)
    assert ((found.owners >= 0) == np.isfinite(measurements.readings)).mean() > 0.99


@pytest.mark.parametrize("seed", range(4))
def test_a_step_never_makes_readings_fit_worse(seed: int) -> None:
    # Four fixed sensors on a straight drive: readings depend on the direction of walls ahead and behind quadratically.
    drive, rng = [(x, -0.5) for x in np.arange(-1.5, 1.46, 0.05)], np.random.default_rng(seed)
    clean = pings_of(listening(drive, step=np.pi / 2, arm=0.1), ROOM)
    readings = 0.003 * np.round((clean.readings + rng.normal(0.0, 0.001, len(clean.readings))) / 0.003)
    start = [wall(0.005, 2.0), ROOM[1], wall(np.pi - 0.005, 2.0), ROOM[3]]
    found = solution(clean._replace(readings=readings), start, priors=PRIORS._replace(noise=0.0015))
    assert (found.owners >= 0).all()
    assert found.model.range_scale == pytest.approx(0.0, abs=0.01)


def test_range_offset_scale_and_walk_are_estimated() -> None:
    truth = [*ROOM, COLUMN, *CORNERS]
    true = replace(SONAR, range_offset=0.003, walk_gain=1.1 * SONAR.walk_gain, range_scale=0.02)
    measurements = pings_of(listening(), truth, sonar=true, noise=0.001, rng=np.random.default_rng(2))
    # With a wide prior, the corners determine the range offset.
    found = solution(
        measurements,
        displaced(truth, size=0.004),
        priors=PRIORS._replace(noise=0.001, offset_sigma=0.01),
        max_iterations=20,
    )
    known = found.sonar_sigmas()
    for name, least in (("range_offset", 0.002), ("walk_gain", 0.001), ("range_scale", 0.001)):
        assert known[name] < least
        assert getattr(found.model, name) == pytest.approx(getattr(true, name), abs=4 * known[name])


@pytest.mark.parametrize("exponent", [0.85, 1.0, 1.25])
def test_the_sigma_of_the_range_scale_includes_the_walk_exponent(exponent: float) -> None:
    # The range walk differs by millimetres between near and far walls, as with another speed of sound.
    truth, errors = [*ROOM, COLUMN, *CORNERS], []
    true = replace(SONAR, walk_exponent=exponent)
    clean, rng = pings_of(listening(), truth, sonar=true), np.random.default_rng(5)
    for _ in range(12):
        readings = clean.readings + rng.normal(0.0, 0.001, len(clean.readings))
        found = solution(
            clean._replace(readings=readings), truth, priors=PRIORS._replace(noise=0.001), max_iterations=12
        )
        sigma = found.considered_sigma("range_scale", "walk_exponent", 0.2)
        errors.append(found.model.range_scale / sigma)
        assert found.model.walk_exponent == 1.0
        assert sigma > found.sonar_sigmas()["range_scale"]
    # The error of the exponent is within its prior, and so is the resulting error of the scale.
    assert abs(np.mean(errors)) < 1.5


def test_figure_of_merit_beam_and_walk_shape_are_held() -> None:
    measurements = pings_of(listening(), [*ROOM, COLUMN])
    found = solution(measurements, [*ROOM, COLUMN])
    assert (found.model.figure_of_merit, found.model.ka) == (SONAR.figure_of_merit, SONAR.ka)
    assert found.model.walk is SONAR.walk


def test_the_covariance_agrees_with_simulated_errors() -> None:
    truth = [*ROOM, COLUMN]
    silent, squares = listening(step=np.radians(4.0)), []
    clean = pings_of(silent, truth)
    rng = np.random.default_rng(3)
    for _ in range(60):
        readings = clean.readings + rng.normal(0.0, NOISE, len(clean.readings))
        # The prior of the offset is part of the covariance, so that the offset is drawn as well.
        offset = rng.normal(0.0, PRIORS.offset_sigma)
        found = solution(clean._replace(readings=readings + offset), truth)
        number = found.layout.feature(0)
        errors = found.reflectors[0, 1:3] - ROOM[0, 1:3]
        squares.append(errors @ np.linalg.solve(found.covariance[number, number], errors))
    assert 1.2 < np.mean(squares) < 2.4


def test_the_covariance_is_the_inverse_of_the_information() -> None:
    found = solution(pings_of(listening(), ROOM), ROOM)
    assert found.covariance.shape == (found.layout.size,) * 2
    assert found.covariance == pytest.approx(found.covariance.T)
    assert np.linalg.eigvalsh(found.covariance).min() > 0.0


def test_twice_the_pings_reduce_sigmas_by_the_square_root_of_two() -> None:
    coarse, fine = (solution(pings_of(listening(step=np.radians(step)), ROOM), ROOM) for step in (8.0, 4.0))
    ratio = sigmas(coarse)[coarse.layout.feature(1)] / sigmas(fine)[fine.layout.feature(1)]
    assert ratio[0] == pytest.approx(np.sqrt(2.0), rel=0.1)
    assert ratio[1] > 1.0


def test_the_spread_of_the_range_walk_is_not_counted_twice() -> None:
    # The noise describes the scatter of all readings: a spread of the excess shifts weight from weak echoes to strong
    # ones, and does not increase the variance of a typical one.
    measurements = pings_of(listening(), ROOM)
    start = Values(features=features(ROOM, len(measurements.centers)), model=SONAR)
    models = [replace(SONAR, excess_scale=scale) for scale in (0.0, 0.3)]
    rows = [range_factors(measurements, replace(start, model=each), PRIORS, OptimiserSettings()) for each in models]
    assert np.median(rows[1].weights / rows[0].weights) == pytest.approx(1.0, abs=0.03)
    assert rows[1].weights.min() < 0.8 * rows[0].weights.min()
    assert rows[1].weights.max() > rows[0].weights.max()


def test_common_errors_of_a_station_do_not_average_out() -> None:
    measurements = pings_of(listening([(0.5, 0.3)]), ROOM[:1])
    priors = PRIORS._replace(scale_sigma=1e-6)
    alone = solution(measurements, ROOM[:1], priors=priors)
    together = solution(measurements, ROOM[:1], priors=priors._replace(bias_sigma=0.012))
    assert sigmas(alone)[1] < 0.004
    assert sigmas(together)[1] > 0.012


def test_the_error_of_attenuation_counts_unless_poses_are_absolute() -> None:
    measurements, measured_poses = pings_of(listening([(0.5, 0.3)]), ROOM[:1]), np.array([[0.5, 0.3, 0.0]])
    doubtful = features(ROOM[:1], 1)._replace(bias_variances=np.array([[0.012**2]]))
    priors = PRIORS._replace(scale_sigma=1e-6)
    absolute = PosePrior(measured_poses, np.full((1, 3), 1e-6), relative=False)
    trusted = optimise(measurements, Values(features=doubtful, model=SONAR), priors, OptimiserSettings())
    start = Values(features=doubtful, model=SONAR, poses=measured_poses)
    by_hand = optimise(measurements, start, priors._replace(poses=absolute), OptimiserSettings())
    assert sigmas(trusted)[1] > 0.012
    assert sigmas(by_hand)[1] < 0.004


def one_ping(reflector: FloatArray, *, angle: float, latency: float = 0.0) -> Measurements:
    """Return the one ping at an angle to a landmark, with a turning servo."""
    measurements = listening([(0.3, -0.2)], step=np.radians(1.0), rates=[0.7])
    excesses, _ = expected(apply_servo_latency(measurements, latency), reflector)
    loud = int(np.argmax(excesses)) + round(angle / np.radians(1.0))
    kept = select_measurements(measurements, np.arange(len(measurements.readings)) == loud)
    _, readings = expected(apply_servo_latency(kept, latency), reflector)
    return kept._replace(readings=readings + 0.002)


REFLECTORS = [wall(0.4, 1.4), cylinder(0.9, 0.6, 0.1), corner(1.2, 0.3), edge(0.5, -0.1)]


@pytest.mark.parametrize("reflector", REFLECTORS)
def test_the_jacobian_of_a_range_factor_equals_finite_differences(reflector: FloatArray) -> None:
    measurements = one_ping(reflector, angle=np.radians(8.0))
    beam_prior = (SONAR.figure_of_merit, math.log(SONAR.ka))
    priors = PRIORS._replace(has_servo=True, beam_prior=beam_prior, servo=ServoError())
    found = solution(measurements, [reflector], priors=priors, max_iterations=1)
    assert found.owners.tolist() == [0]
    information = np.linalg.inv(found.covariance)
    # The derivative by the offset is one, so its row holds the derivatives by all other variables.
    offset = found.layout.sonar
    row = information[offset].copy()
    row[offset] -= priors.offset_sigma**-2
    jacobian = row / row[offset]
    assert jacobian == pytest.approx(differences(measurements, reflector, found.layout.counts[0]), rel=2e-3, abs=1e-5)


def differences(measurements: Measurements, reflector: FloatArray, count: int) -> FloatArray:
    """Return the derivatives of the predicted minus the measured range by finite differences."""

    def too_short(change: FloatArray) -> float:
        offset, gain, scale, latency, turned, askew, merit, log_ka, exponent = change[count:]
        sonar = replace(
            SONAR,
            range_offset=offset,
            walk_gain=SONAR.walk_gain + gain,
            figure_of_merit=SONAR.figure_of_merit + merit,
            ka=SONAR.ka * math.exp(log_ka),
            walk_exponent=SONAR.walk_exponent + exponent,
        )
        moved = reflector + np.pad(change[:count], (1, 3 - count))
        turned_pings = turned_by(measurements, error=ServoError(1.0 + turned, askew), before=ServoError())
        _, reading = expected(apply_servo_latency(turned_pings, latency), moved, sonar)
        return float(reading[0] - (1.0 + scale) * measurements.readings[0])

    jacobian = []
    # Steps of the excess are larger, as tables are piecewise linear.
    for column, step in enumerate([*[1e-6] * (count + 6), 0.02, 0.002, 1e-5]):
        nudge = np.zeros(count + 9)
        nudge[column] = step
        jacobian.append((too_short(nudge) - too_short(-nudge)) / (2 * step))
    return np.array(jacobian)


def with_latency(latency: float, rates: Sequence[float]) -> Measurements:
    """Return pings in a room with a servo that lags behind its recorded angles."""
    recorded = listening(rates=rates)
    detected = pings_of(apply_servo_latency(recorded, latency), ROOM, noise=0.001, rng=np.random.default_rng(4))
    return recorded._replace(readings=detected.readings)


def test_sweeps_in_both_directions_determine_the_servo_latency() -> None:
    measurements = with_latency(0.015, [0.7, -0.7, 0.7, -0.7])
    found = solution(measurements, ROOM, priors=PRIORS._replace(noise=0.001, has_servo=True), max_iterations=12)
    sigma = found.sonar_sigmas()["servo_latency"]
    assert sigma < 0.002
    assert found.latency == pytest.approx(0.015, abs=4 * sigma)
    assert found.reflectors == pytest.approx(ROOM, abs=0.002)


@pytest.mark.parametrize(
    ("latency", "noise", "expected"),
    [(0.015, 0.001, 0.015), (0.015, 0.01, 0.0), (-0.015, 0.001, 0.0)],
    ids=["clear", "hidden in noise", "a servo never leads"],
)
def test_with_drifting_poses_only_a_significant_latency_is_used(latency: float, noise: float, expected: float) -> None:
    measurements = with_latency(latency, [0.7, -0.7, 0.7, -0.7])
    known = PRIORS._replace(noise=noise, has_servo=True)
    free = solution(measurements, ROOM, priors=known, max_iterations=12)
    drifting = solution(measurements, ROOM, priors=known._replace(drifting=True), max_iterations=12)
    assert abs(free.latency) > 0.003
    assert drifting.latency == pytest.approx(expected, abs=0.003)
    # A latency that is held has the same sigma as a free one.
    sigmas = [each.sonar_sigmas()["servo_latency"] for each in (free, drifting)]
    assert sigmas[1] == pytest.approx(sigmas[0], rel=0.2)


def test_without_a_servo_there_is_no_latency() -> None:
    measurements = with_latency(0.015, [0.7, -0.7, 0.7, -0.7])
    found = solution(measurements, ROOM, priors=PRIORS._replace(noise=0.001))
    assert abs(found.latency) < 1e-6
    assert found.sonar_sigmas()["servo_latency"] == pytest.approx(0.0, abs=2e-9)


def test_a_corner_converges_to_the_crossing_of_its_walls() -> None:
    measurements = pings_of(listening(), ROOM)
    found = solution(measurements, [*ROOM, corner(1.98, 1.47)])
    crossing = intersections(found.reflectors[0, 1:3], found.reflectors[1, 1:3])
    assert found.reflectors[4, 1:3] == pytest.approx(crossing, abs=0.0005)


def test_a_detected_corner_constrains_its_walls() -> None:
    # The east wall has no echoes: only those of the corner determine it.
    truth = [*ROOM[1:], *CORNERS[:2]]
    measurements = pings_of(listening(), truth)
    found = solution(measurements, [wall(0.0, 2.01), *ROOM[1:], *CORNERS[:2]])
    assert found.reflectors[0, 1:3] == pytest.approx([0.0, 2.0], abs=0.002)
    assert not (found.owners == 0).any()


@pytest.mark.parametrize("other", [corner(1.9, 1.45), edge(1.98, 1.47), cylinder(1.98, 1.47, 0.12)])
def test_other_landmarks_near_a_crossing_are_not_moved(other: FloatArray) -> None:
    found = solution(pings_of(listening(), ROOM), [*ROOM, other])
    assert found.reflectors[4] == pytest.approx(other, abs=1e-6)


def test_walls_at_oblique_angles_do_not_constrain_a_corner() -> None:
    slanted = [wall(0.0, 2.0), wall(np.radians(80), 1.5)]
    apex = intersections(slanted[0][1:3], slanted[1][1:3])
    start = corner(*(apex + 0.02))
    found = solution(pings_of(listening(), slanted), [*slanted, start])
    assert found.reflectors[2] == pytest.approx(start, abs=1e-6)


def test_an_outlier_hardly_changes_the_solution() -> None:
    measurements = pings_of(listening(), ROOM)
    clean = solution(measurements, ROOM)
    readings = measurements.readings.copy()
    outlier = int(np.flatnonzero(clean.owners == 0)[5])
    readings[outlier] += 0.02
    spoilt = solution(measurements._replace(readings=readings), ROOM)
    assert spoilt.owners[outlier] == 0
    assert spoilt.residuals[outlier] == pytest.approx(0.02, abs=0.001)
    assert np.abs(spoilt.reflectors - clean.reflectors).max() < 0.0001


def test_a_reading_far_from_all_landmarks_has_no_owner() -> None:
    measurements = pings_of(listening(), ROOM)
    strange = int(np.flatnonzero(np.isfinite(measurements.readings))[0])
    readings = measurements.readings.copy()
    readings[strange] -= 0.2
    found = solution(measurements._replace(readings=readings), ROOM)
    assert found.owners[strange] == -1
    assert found.residuals[strange] == 0.0


def test_a_reading_is_associated_with_the_nearest_landmark() -> None:
    measurements = pings_of(listening(), ROOM[:1])
    found = solution(measurements, [wall(0.0, 2.015), ROOM[0]], max_iterations=1)
    assert set(found.owners[np.isfinite(measurements.readings)]) == {1}


def test_only_detecting_stations_constrain_a_landmark() -> None:
    measurements = pings_of(listening(), ROOM[:1])
    known = features(ROOM[:1])
    known = known._replace(attenuations=np.array([[np.inf, np.inf, 0.0, 0.0]]))
    found = optimise(measurements, Values(features=known, model=SONAR), PRIORS, OptimiserSettings())
    assert set(measurements.stations[found.owners == 0]) == {2, 3}


def test_a_wall_explains_no_reading_beside_its_extent() -> None:
    measurements = pings_of(listening(), ROOM[:1])
    known = features(ROOM[:1])
    known.extents[0] = (0.0, 1.0)
    found = optimise(measurements, Values(features=known, model=SONAR), PRIORS, OptimiserSettings())
    assert measurements.y[found.owners == 0].min() > -0.1
    assert measurements.y[np.isfinite(measurements.readings)].min() < -0.3


def test_without_associations_the_solution_is_the_prior() -> None:
    strange = replace(SONAR, walk_gain=1.2 * SONAR.walk_gain, range_offset=0.004)
    found = solution(listening(), [wall(0.0, 2.0), cylinder(0.0, 1.0, 0.2)], sonar=strange)
    assert np.isnan(found.robust_sigma)
    assert (found.owners == -1).all()
    assert found.reflectors == pytest.approx(np.array([wall(0.0, 2.0), cylinder(0.0, 1.0, 0.12)]))
    assert (found.model.range_offset, found.model.walk_gain) == pytest.approx((0.0, SONAR.walk_gain))
    priors = OptimiserSettings()
    assert found.sonar_sigmas() == pytest.approx(
        {
            "range_offset": PRIORS.offset_sigma,
            "walk_gain": priors.walk_gain_sigma * SONAR.walk_gain,
            "range_scale": priors.scale_sigma,
            "servo_latency": 1e-9,
            "servo_gain": 1e-9,
            "servo_offset": 1e-9,
            "figure_of_merit": 1e-9,
            "log_ka": 1e-9,
            "walk_exponent": priors.walk_exponent_sigma,
        }
    )


def test_without_landmarks_the_sonar_is_still_estimated() -> None:
    found = solution(pings_of(listening(), ROOM), np.zeros((0, 4)))
    assert found.reflectors.shape == (0, 4)
    assert found.covariance.shape == (len(SONAR_UNKNOWNS), len(SONAR_UNKNOWNS))
    assert (found.owners == -1).all()


def test_the_optimiser_does_not_change_its_arguments() -> None:
    known = features(displaced(ROOM))
    before = known.reflectors.copy()
    optimise(pings_of(listening(), ROOM), Values(features=known, model=SONAR), PRIORS, OptimiserSettings())
    assert (known.reflectors == before).all()


def test_a_wrong_pose_is_corrected_by_the_walls() -> None:
    measured_poses = np.array([[-0.9, 0.1, 0.0], [-0.2, -0.5, 0.4], [0.5, 0.3, 1.0], [1.1, -0.3, -2.0]])
    truth = measured_poses + np.array([[0.0] * 3, [0.0] * 3, [0.0] * 3, [0.012, -0.008, 0.02]])
    recorded = listening()
    detected = pings_of(at_poses(recorded, measured_poses, truth), ROOM)
    sigmas = np.array([[1e-6] * 3, [1e-6] * 3, [1e-6] * 3, [0.05] * 3])
    priors = PRIORS._replace(poses=PosePrior(measured_poses, sigmas, relative=False))
    start = Values(features=features(ROOM), model=SONAR, poses=measured_poses)
    found = optimise(recorded._replace(readings=detected.readings), start, priors, OptimiserSettings(max_iterations=12))
    assert found.poses == pytest.approx(truth, abs=0.001)
    assert found.reflectors == pytest.approx(ROOM, abs=0.001)


def test_a_converged_solution_is_not_iterated_further() -> None:
    measurements = pings_of(listening(), [*ROOM, COLUMN])
    once, often = (solution(measurements, displaced([*ROOM, COLUMN]), max_iterations=rounds) for rounds in (6, 60))
    assert once.newton_decrement < 1e-4
    assert np.array_equal(once.reflectors, often.reflectors)
