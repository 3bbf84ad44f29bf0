import numpy as np
import pytest

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import FloatArray
from echoplan.joint.search.refinement import refine
from echoplan.preprocessing.ping_arrays import Soundings
from helpers.expectations import NOISE, SONAR, STATIONS, corner, cylinder, edge, hearing, listening, wall

STRETCHED = (4 * NOISE, 0.08)
NARROW = (NOISE, 0.03)


def refined(
    soundings: Soundings, start: FloatArray, *, scales: tuple[float, float] = STRETCHED, rounds: int = 12
) -> FloatArray:
    pings = np.arange(len(soundings.readings))
    return refine(soundings, SONAR.tabulated(), start, pings, scales, rounds)


@pytest.mark.parametrize(
    ("truth", "error"),
    [
        (wall(0.4, 1.8), [0.04, -0.03, 0.0]),
        (wall(-2.8, 1.6), [-0.05, 0.03, 0.0]),
        (cylinder(0.3, 1.1, 0.1), [0.02, -0.03, 0.03]),
        (corner(1.4, 1.0), [-0.03, 0.03, 0.0]),
    ],
)
def test_what_is_a_little_off_moves_to_where_it_is(truth: FloatArray, error: list[float]) -> None:
    soundings = hearing(listening(), [truth])
    found = refined(soundings, truth + np.array([0.0, *error]))
    assert found[0] == truth[0]
    assert found[1:] == pytest.approx(truth[1:], abs=0.0005)


def test_an_edge_is_found_from_near_by_where_alone_it_is_heard() -> None:
    truth = edge(0.2, -0.1)
    soundings = hearing(listening([(0.0, 0.0), (0.4, 0.05), (0.25, -0.35)]), [truth])
    found = refined(soundings, edge(0.21, -0.11), scales=NARROW)
    assert found == pytest.approx(truth, abs=0.0005)


def test_one_arc_alone_gives_the_normal_of_its_wall() -> None:
    # The range walk grows to both sides of the normal alike.
    truth = wall(0.4, 1.8)
    soundings = hearing(listening(STATIONS[:1]), [truth])
    found = refined(soundings, wall(0.44, 1.8))
    assert found[1:3] == pytest.approx(truth[1:3], abs=0.002)


def test_readings_with_noise_give_what_they_are_worth() -> None:
    truth = wall(0.4, 1.8)
    soundings = hearing(listening(), [truth], noise=NOISE, rng=np.random.default_rng(1))
    error = refined(soundings, wall(0.42, 1.81), scales=NARROW) - truth
    assert 0.0 < np.abs(error).max() < NOISE


def test_stray_echoes_hardly_move_anything() -> None:
    truth = wall(0.4, 1.8)
    soundings = hearing(listening(), [truth])
    heard = np.flatnonzero(np.isfinite(soundings.readings))
    readings = soundings.readings.copy()
    readings[heard[::10]] += 0.02
    found = refined(soundings._replace(readings=readings), truth, scales=NARROW)
    clean = refined(soundings, truth, scales=NARROW)
    assert np.abs(found - clean).max() < 0.0005


def test_readings_outside_the_band_do_not_count_at_all() -> None:
    truth = wall(0.4, 1.8)
    soundings = hearing(listening(), [truth])
    readings = soundings.readings.copy()
    readings[np.flatnonzero(np.isfinite(readings))[::3]] -= 0.3
    found = refined(soundings._replace(readings=readings), truth, scales=NARROW)
    assert found == pytest.approx(truth, abs=1e-4)


@pytest.mark.parametrize("kept", [0, 1])
def test_fewer_than_two_pings_move_nothing(kept: int) -> None:
    soundings = hearing(listening(), [wall(0.4, 1.8)])
    start = wall(0.42, 1.81)
    heard = np.flatnonzero(np.isfinite(soundings.readings))[:kept]
    assert refine(soundings, SONAR.tabulated(), start, heard, STRETCHED, 5).tolist() == start.tolist()


def test_only_the_named_pings_count() -> None:
    near, far = wall(0.4, 1.5), wall(0.4, 1.54)
    soundings = hearing(listening(), [near])
    other = hearing(listening(), [far])
    mixed = soundings._replace(readings=np.where(soundings.stations < 2, soundings.readings, other.readings))
    chosen = np.flatnonzero(mixed.stations >= 2)
    found = refine(mixed, SONAR.tabulated(), near, chosen, STRETCHED, 12)
    assert found == pytest.approx(far, abs=0.002)


def test_the_reflector_that_was_given_stays_as_it_was() -> None:
    start = wall(0.44, 1.83)
    refined(hearing(listening(), [wall(0.4, 1.8)]), start)
    assert start.tolist() == [Kind.WALL, 0.44, 1.83, 0.0]


def test_no_step_is_longer_than_five_centimetres() -> None:
    soundings = hearing(listening(), [wall(0.4, 1.8)])
    found = refined(soundings, wall(0.4, 1.6), scales=(0.1, 0.5), rounds=1)
    assert found[2] == pytest.approx(1.65)


@pytest.mark.parametrize(("radius", "limit"), [(0.004, 0.015), (0.7, 0.45)])
def test_radii_stay_between_a_broomstick_and_a_barrel(radius: float, limit: float) -> None:
    # A thick cylinder is heard from all sides here, so that its radius is known well.
    around = [(0.0, -1.5), (1.3, 0.75), (-1.3, 0.75)]
    soundings = hearing(listening(around), [cylinder(0.0, 0.0, radius)])
    found = refined(soundings, cylinder(0.0, 0.0, limit), scales=(0.1, 0.4))
    assert found[3] == pytest.approx(limit, abs=1e-9)
