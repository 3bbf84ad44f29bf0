import numpy as np
import pytest

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import FloatArray
from echoplan.joint.search.acceptance import AcceptanceSettings, AcceptanceTest
from echoplan.joint.search.multipath_walls import without_multipath_walls
from echoplan.joint.search.refinement import approach
from helpers.expectations import NOISE, SONAR, feature, likelihood, listening, pings_of, rescored, returning, wall
from helpers.single_ping import PLAIN

# A passage with a wall across its far end, which only one station detects.
SIDES = (wall(np.pi / 2, 0.6), wall(-np.pi / 2, 0.6))
END = wall(0.0, 2.0)
STATIONS = ((-0.4, 0.1), (0.0, -0.1), (0.5, 0.0))


def kept_walls(*, span: float, volleys: bool = True, end: float = 2.0) -> list[float]:
    """Return the normal angles of the walls that are kept if one station detects the end over an angle [deg]."""
    silent, rng, beyond = listening(STATIONS), np.random.default_rng(2), wall(0.0, end)
    sides, far = (pings_of(silent, each, noise=NOISE, rng=rng).readings for each in (SIDES, [beyond]))
    detected = (silent.stations == 1) & (np.abs(silent.bearings) < np.radians(span / 2))
    measurements = silent._replace(readings=np.minimum(sides, np.where(detected, far, np.inf)))
    if volleys:
        measurements = measurements._replace(crosstalk_sources=np.arange(len(measurements.readings))[:, None] - 1)
    estimate = likelihood(measurements)
    acceptance = AcceptanceTest(measurements, half_aperture=0.61, settings=AcceptanceSettings())
    features = rescored(estimate, [*SIDES, beyond])
    assert all(acceptance.is_accepted(each, estimate.log_densities([])) for each in features)
    kept = without_multipath_walls(estimate, features, acceptance)
    return [round(float(each.line[0]), 3) for each in kept if each.kind is Kind.WALL]


BESIDES = [round(np.pi / 2, 3), -round(np.pi / 2, 3)]


def test_a_far_wall_detected_in_part_by_one_station_is_removed_as_crosstalk() -> None:
    assert kept_walls(span=48.0) == BESIDES


def test_a_far_wall_detected_over_the_whole_beam_is_kept() -> None:
    assert kept_walls(span=180.0) == [*BESIDES, 0.0]


def test_a_wall_too_near_for_crosstalk_is_kept() -> None:
    # A path over two walls would be longer.
    assert kept_walls(span=66.0, end=0.8) == [*BESIDES, 0.0]


def test_without_simultaneous_firing_a_far_wall_is_kept() -> None:
    assert kept_walls(span=48.0, volleys=False) == [*BESIDES, 0.0]


def test_without_other_walls_a_wall_is_kept() -> None:
    measurements = listening(STATIONS)
    estimate = likelihood(
        measurements._replace(crosstalk_sources=np.zeros((len(measurements.readings), 1), dtype=np.int64))
    )
    acceptance = AcceptanceTest(measurements, half_aperture=0.61, settings=AcceptanceSettings())
    end = feature(END, llr_by_station=(0.0, 20.0, 0.0))
    assert without_multipath_walls(estimate, [], acceptance) == []
    assert without_multipath_walls(estimate, [end], acceptance) == [end]


@pytest.mark.parametrize(("known", "stays"), [(wall(np.pi / 2, 1.5), 0), (wall(np.pi / 2, 4.5), 1)])
def test_a_wall_is_removed_if_a_latent_wall_explains_it_as_well(known: FloatArray, stays: int) -> None:
    measurements = returning(listening(((-0.4, -0.3), (0.3, -0.1), (3.0, -9.0))), (1.2, 1.5), 78.0)
    estimate = likelihood(measurements, sonar=PLAIN)
    ahead, schedule = np.flatnonzero(np.isfinite(measurements.readings)), [(0.02, 0.2, 20), (0.003, 0.03, 20)]
    across = approach(measurements, PLAIN.tabulated(), wall(0.9, 1.85), ahead, schedule)
    strong, (seeming,) = (
        feature(known, extent=(-0.8, 0.9), llr_by_station=(200.0, 200.0, 0.0)),
        rescored(estimate, [across]),
    )
    acceptance = AcceptanceTest(measurements, half_aperture=0.61, settings=AcceptanceSettings())
    assert acceptance.is_accepted(seeming, estimate.log_densities([strong]))
    assert without_multipath_walls(estimate, [seeming, strong], acceptance) == [seeming, strong][1 - stays :]


def test_with_rays_a_wall_of_one_station_is_removed() -> None:
    measurements, seeing = listening(STATIONS), SONAR.as_ray_cone(0.26)
    acceptance = AcceptanceTest(measurements, half_aperture=0.26, settings=AcceptanceSettings())
    lone, plain = feature(END, llr_by_station=(0.0, 40.0, 0.0)), feature(SIDES[0], llr_by_station=(20.0, 30.0, 20.0))
    assert without_multipath_walls(likelihood(measurements, sonar=seeing), [lone, plain], acceptance) == [plain]
    assert without_multipath_walls(likelihood(measurements), [lone, plain], acceptance) == [lone, plain]
