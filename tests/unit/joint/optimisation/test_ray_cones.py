from dataclasses import replace

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.joint.optimisation.ray_cones import fit_cone
from echoplan.joint.optimisation.sonar_model import estimated_sonar
from echoplan.preprocessing.measurements import Measurements
from helpers.expectations import ROOM, SONAR, feature, listening

SEEING = SONAR.as_ray_cone(0.26)
SILENT = listening(step=np.radians(2.0))
WALLS = [feature(each, extent=(-5.0, 5.0), llr_by_station=[20.0] * 4) for each in ROOM]


def cone_readings(half_angle: float, *, noise: float = 0.002) -> Measurements:
    """Return the readings of ray cones in the room."""
    rays = SILENT.bearings[:, None] + np.linspace(-half_angle, half_angle, 61)
    nearest = np.full(rays.shape, np.inf)
    for _, normal_angle, offset, _ in ROOM:
        depths = offset - SILENT.x * np.cos(normal_angle) - SILENT.y * np.sin(normal_angle)
        cosines = np.cos(rays - normal_angle)
        nearest = np.where(cosines > 0.01, np.minimum(nearest, depths[:, None] / np.maximum(cosines, 0.01)), nearest)
    jitter: FloatArray = np.random.default_rng(3).normal(0.0, noise, len(nearest))
    return SILENT._replace(readings=nearest.min(axis=1) + jitter)


@pytest.mark.parametrize("degrees", [5.0, 12.0, 20.0])
def test_the_cone_angle_is_estimated_for_any_start(degrees: float) -> None:
    found = fit_cone(cone_readings(np.radians(degrees)), SEEING, WALLS)
    assert np.degrees(found.cone) == pytest.approx(degrees, abs=0.2)
    assert (found.range_scale, found.ka) == (SEEING.range_scale, SEEING.ka)


def test_the_range_scale_does_not_change_the_cone_angle() -> None:
    detected = cone_readings(np.radians(12.0))
    found = fit_cone(detected._replace(readings=detected.readings / 1.02), replace(SEEING, range_scale=0.02), WALLS)
    assert np.degrees(found.cone) == pytest.approx(12.0, abs=0.2)


def test_random_readings_do_not_change_the_cone_angle() -> None:
    chance = np.random.default_rng(0).uniform(0.5, 4.0, len(SILENT.readings))
    assert fit_cone(SILENT._replace(readings=chance), SEEING, WALLS) is SEEING


def test_without_walls_or_readings_the_cone_angle_is_unchanged() -> None:
    assert fit_cone(cone_readings(0.2), SEEING, []) is SEEING
    assert fit_cone(SILENT, SEEING, WALLS) is SEEING


def test_the_cone_is_estimated_for_rays_and_the_beam_for_sound() -> None:
    detected = cone_readings(np.radians(12.0))
    assert estimated_sonar(detected, SEEING, WALLS, prior_mean=30.0).cone == fit_cone(detected, SEEING, WALLS).cone
    assert estimated_sonar(detected, SONAR, WALLS, prior_mean=30.0).cone == 0.0
