import numpy as np
import pytest

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import FloatArray
from echoplan.joint.search.refinement import refine
from echoplan.preprocessing.measurements import Measurements
from helpers.expectations import NOISE, SONAR, STATIONS, corner, cylinder, edge, listening, pings_of, wall

STRETCHED = (4 * NOISE, 0.08)
NARROW = (NOISE, 0.03)


def refined(
    measurements: Measurements, start: FloatArray, *, scales: tuple[float, float] = STRETCHED, rounds: int = 12
) -> FloatArray:
    pings = np.arange(len(measurements.readings))
    return refine(measurements, SONAR.tabulated(), start, pings, scales, rounds)


@pytest.mark.parametrize(
    ("truth", "error"),
    [
        (wall(0.4, 1.8), [0.04, -0.03, 0.0]),
        (wall(-2.8, 1.6), [-0.05, 0.03, 0.0]),
        (cylinder(0.3, 1.1, 0.1), [0.02, -0.03, 0.03]),
        (corner(1.4, 1.0), [-0.03, 0.03, 0.0]),
    ],
)
def test_a_slightly_wrong_landmark_converges_to_its_true_place(truth: FloatArray, error: list[float]) -> None:
    measurements = pings_of(listening(), [truth])
    found = refined(measurements, truth + np.array([0.0, *error]))
    assert found[0] == truth[0]
    assert found[1:] == pytest.approx(truth[1:], abs=0.0005)


def test_an_edge_is_found_from_near_stations() -> None:
    truth = edge(0.2, -0.1)
    measurements = pings_of(listening([(0.0, 0.0), (0.4, 0.05), (0.25, -0.35)]), [truth])
    found = refined(measurements, edge(0.21, -0.11), scales=NARROW)
    assert found == pytest.approx(truth, abs=0.0005)


def test_one_arc_alone_gives_the_normal_of_its_wall() -> None:
    # The range walk is symmetric about the normal.
    truth = wall(0.4, 1.8)
    measurements = pings_of(listening(STATIONS[:1]), [truth])
    found = refined(measurements, wall(0.44, 1.8))
    assert found[1:3] == pytest.approx(truth[1:3], abs=0.002)


def test_noisy_readings_give_an_error_below_the_noise() -> None:
    truth = wall(0.4, 1.8)
    measurements = pings_of(listening(), [truth], noise=NOISE, rng=np.random.default_rng(1))
    error = refined(measurements, wall(0.42, 1.81), scales=NARROW) - truth
    assert 0.0 < np.abs(error).max() < NOISE


def test_stray_echoes_hardly_change_the_result() -> None:
    truth = wall(0.4, 1.8)
    measurements = pings_of(listening(), [truth])
    detected = np.flatnonzero(np.isfinite(measurements.readings))
    readings = measurements.readings.copy()
    readings[detected[::10]] += 0.02
    found = refined(measurements._replace(readings=readings), truth, scales=NARROW)
    clean = refined(measurements, truth, scales=NARROW)
    assert np.abs(found - clean).max() < 0.0005


def test_readings_outside_the_gate_do_not_count() -> None:
    truth = wall(0.4, 1.8)
    measurements = pings_of(listening(), [truth])
    readings = measurements.readings.copy()
    readings[np.flatnonzero(np.isfinite(readings))[::3]] -= 0.3
    found = refined(measurements._replace(readings=readings), truth, scales=NARROW)
    assert found == pytest.approx(truth, abs=1e-4)


@pytest.mark.parametrize("kept", [0, 1])
def test_fewer_than_two_pings_change_nothing(kept: int) -> None:
    measurements = pings_of(listening(), [wall(0.4, 1.8)])
    start = wall(0.42, 1.81)
    detected = np.flatnonzero(np.isfinite(measurements.readings))[:kept]
    assert refine(measurements, SONAR.tabulated(), start, detected, STRETCHED, 5).tolist() == start.tolist()


def test_only_the_given_pings_count() -> None:
    near, far = wall(0.4, 1.5), wall(0.4, 1.54)
    measurements = pings_of(listening(), [near])
    other = pings_of(listening(), [far])
    mixed = measurements._replace(readings=np.where(measurements.stations < 2, measurements.readings, other.readings))
    chosen = np.flatnonzero(mixed.stations >= 2)
    found = refine(mixed, SONAR.tabulated(), near, chosen, STRETCHED, 12)
    assert found == pytest.approx(far, abs=0.002)


def test_refinement_does_not_change_its_argument() -> None:
    start = wall(0.44, 1.83)
    refined(pings_of(listening(), [wall(0.4, 1.8)]), start)
    assert start.tolist() == [Kind.WALL, 0.44, 1.83, 0.0]


def test_no_step_is_longer_than_five_centimetres() -> None:
    measurements = pings_of(listening(), [wall(0.4, 1.8)])
    found = refined(measurements, wall(0.4, 1.6), scales=(0.1, 0.5), rounds=1)
    assert found[2] == pytest.approx(1.65)


@pytest.mark.parametrize(("radius", "limit"), [(0.004, 0.015), (0.7, 0.45)])
def test_radii_stay_within_their_limits(radius: float, limit: float) -> None:
    # The cylinder is detected from all sides, so that its radius is well determined.
    around = [(0.0, -1.5), (1.3, 0.75), (-1.3, 0.75)]
    measurements = pings_of(listening(around), [cylinder(0.0, 0.0, radius)])
    found = refined(measurements, cylinder(0.0, 0.0, limit), scales=(0.1, 0.4))
    assert found[3] == pytest.approx(limit, abs=1e-9)
