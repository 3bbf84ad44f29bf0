from dataclasses import replace

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.geometry import directions
from echoplan.joint.likelihood.ping_scores import NO_ECHO
from echoplan.joint.likelihood.ray_cone_returns import flanks_of
from helpers.expectations import NOISE, SONAR, cylinder, wall
from helpers.single_ping import likeliest, one_ping

CONE = np.radians(15.0)
HEARING = replace(SONAR, walk_gain=0.0).as_ray_cone(float(CONE)).tabulated()
ENDLESS = (-50.0, 50.0)
EAST = wall(0.0, 1.0)


def cone_readings(
    bearing: float, reflector: FloatArray, extent: tuple[float, float] = ENDLESS
) -> tuple[FloatArray, float]:
    """Return the log densities of all readings of one ping from (0.2, 0.1), and the most likely reading."""
    measurements = one_ping((0.2, 0.1), float(np.radians(bearing)))
    log_densities = flanks_of(measurements, HEARING, reflector, extent, NOISE)
    return log_densities, likeliest(measurements, log_densities) if log_densities.max() > NO_ECHO else np.inf


@pytest.mark.parametrize("bearing", [25.0, 40.0, 60.0, -50.0])
def test_the_outermost_ray_reads_an_oblique_wall(bearing: float) -> None:
    _, reading = cone_readings(bearing, EAST)
    assert reading == pytest.approx(0.8 / np.cos(np.radians(abs(bearing)) - CONE), abs=2e-4)


def test_the_outermost_ray_reads_nothing_past_the_end_of_a_wall() -> None:
    # The ray of 40 - 15 degrees meets the wall at 0.1 + 0.8 tan 25 degrees; the other one far beyond.
    met = 0.1 + 0.8 * np.tan(np.radians(25.0))
    assert cone_readings(40.0, EAST, (-50.0, met + 0.01))[1] < np.inf
    assert cone_readings(40.0, EAST, (-50.0, met - 0.01))[1] == np.inf


def test_the_outermost_ray_reads_a_cylinder() -> None:
    radius, bearing = 0.3, np.radians(27.0)
    _, reading = cone_readings(27.0, cylinder(1.2, 0.1, radius))
    point = np.array([0.2, 0.1]) + reading * directions(bearing - CONE)
    assert np.hypot(*(point - (1.2, 0.1))) == pytest.approx(radius, abs=3e-4)


@pytest.mark.parametrize("reflector", [EAST, cylinder(1.2, 0.1, 0.1)])
def test_a_landmark_behind_the_sensor_is_not_read(reflector: FloatArray) -> None:
    assert cone_readings(180.0, reflector)[1] == np.inf


def test_the_density_of_cone_readings_integrates_to_one() -> None:
    measurements = one_ping((0.2, 0.1), float(np.radians(40.0)))
    log_densities = flanks_of(measurements, HEARING, EAST, ENDLESS, NOISE)
    inner = measurements.readings < 1.1
    assert np.exp(log_densities[inner]).sum() * 1e-4 == pytest.approx(1.0, abs=0.01)


def test_cone_readings_explain_no_missing_echo() -> None:
    assert cone_readings(40.0, EAST)[0][-1] == NO_ECHO
