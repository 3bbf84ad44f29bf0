from dataclasses import replace

import numpy as np
import pytest
from pydantic import ValidationError

from echoplan.acoustics import speed_of_sound
from echoplan.acoustics.predicted_echo import EchoModel
from echoplan.acoustics.range_walk_model import WalkCurve
from echoplan.arrays import FloatArray
from echoplan.joint.optimisation.edge_diffraction import edges_of
from echoplan.joint.optimisation.optimiser import OptimiserSettings, Priors, optimise
from echoplan.joint.optimisation.range_factors import Features
from echoplan.joint.optimisation.solution import Solution
from echoplan.joint.optimisation.sonar_model import expected_sonar, half_aperture_of, walking
from echoplan.joint.optimisation.values import Values
from echoplan.joint.settings import EstimateSettings
from echoplan.sources import find_rig
from helpers.expectations import NOISE, REACH, ROOM, SONAR, listening, pings_of

RIG = find_rig("rotary-array")
assert RIG.transducer
SOUND = EchoModel.of(RIG.transducer)
SILENT = listening()


def oblique_readings() -> FloatArray:
    """Return the readings of a ray cone that sees a wall at 1 m obliquely."""
    return np.where(np.abs(SILENT.bearings) < 1.2, 1.0 / np.cos(SILENT.bearings), np.inf)


def test_recordings_without_echoes_are_taken_for_sound() -> None:
    sonar = expected_sonar(RIG, SILENT)
    assert (sonar.cone, sonar.ka, sonar.figure_of_merit) == (0.0, SOUND.ka, SOUND.figure_of_merit)


def test_ray_cones_are_recognised_by_their_readings() -> None:
    seeing = expected_sonar(RIG, SILENT._replace(readings=oblique_readings()))
    assert seeing.cone == half_aperture_of(RIG) == pytest.approx(RIG.sensors[0].half_aperture)


@pytest.mark.parametrize("rays", [False, True])
def test_the_rig_overrides_the_recognition_of_rays(*, rays: bool) -> None:
    readings = np.full(len(SILENT.readings), np.inf) if rays else oblique_readings()
    assert (expected_sonar(replace(RIG, rays=rays), SILENT._replace(readings=readings)).cone > 0) == rays


def test_the_previous_sonar_model_is_kept() -> None:
    learned = expected_sonar(replace(RIG, rays=True), SILENT)
    assert expected_sonar(RIG, SILENT, learned).cone == learned.cone
    assert expected_sonar(RIG, SILENT._replace(readings=oblique_readings()), SOUND).cone == 0.0


def test_the_temperature_sets_the_range_scale() -> None:
    warm = expected_sonar(RIG, SILENT._replace(temperature=30.0))
    assert warm.range_scale == pytest.approx(float(speed_of_sound(30.0) / speed_of_sound(20.0)) - 1.0, abs=1e-4)


# A detector that reads 1.5 mm long per decibel below 20, unlike any resonator.
LATE = ((0.0, 0.03), (20.0, 0.0))


def test_a_table_gives_the_range_walk_in_metres() -> None:
    sonar = expected_sonar(RIG, SILENT, walk=LATE)
    assert sonar.walk_gain * sonar.walk([0.0, 10.0, 30.0]) == pytest.approx([0.03, 0.015, 0.0])


def test_a_fitted_range_walk_is_kept() -> None:
    learned = expected_sonar(RIG, SILENT, walk=LATE)
    kept, usual = (expected_sonar(RIG, SILENT, learned, walk=walk) for walk in ("fitted", "physical"))
    assert (kept.walk, kept.walk_gain) == (learned.walk, learned.walk_gain)
    assert usual.walk_gain == SOUND.walk_gain


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (((0.0, 0.03),), "two rows at least"),
        (((0.0, 0.0), (20.0, 0.03)), "falling values"),
        (((0.0, 0.03), (10.0, 0.04), (20.0, 0.0)), "must not rise"),
        ("strange", "physical or fitted or a table"),
    ],
)
def test_an_invalid_range_walk_is_an_error(table: object, message: str) -> None:
    with pytest.raises(ValidationError, match=message):
        EstimateSettings.model_validate({"walk": table})


def solution_of_room(sonar: EchoModel, *, stations: int = 9) -> Solution:
    """Return the solution of a room that a sonar recorded, starting from the default model."""
    places = [(x, y) for x in (-1.2, 0.0, 1.3) for y in (-0.9, 0.1, 0.8)]
    measurements = pings_of(listening(places[:stations]), ROOM, sonar=sonar, noise=0.001, rng=np.random.default_rng(8))
    extents = np.tile([-REACH, REACH], (len(ROOM), 1))
    none = np.zeros((len(ROOM), stations))
    features = Features(
        reflectors=ROOM, extents=extents, attenuations=none, bias_variances=none, ends=edges_of(ROOM, extents)
    )
    start = Values(features=features, model=SONAR)
    priors = Priors(noise=NOISE, offset_sigma=0.0015, walk_gain=SONAR.walk_gain, has_servo=False, scale_sigma=0.003)
    return optimise(measurements, start, priors, OptimiserSettings())


def test_the_range_walk_is_fitted_to_a_recording() -> None:
    strange = replace(SONAR, walk=WalkCurve.from_table(*zip(*LATE, strict=True)), walk_gain=0.03)
    found = solution_of_room(strange)
    fitted = walking(found.model, found, NOISE)
    excess = np.linspace(3.0, 20.0, 18)
    # A common delay of all readings is part of the range offset.
    wrong, right = (
        np.std(each.walk_gain * each.walk(excess) - strange.walk_gain * strange.walk(excess))
        for each in (found.model, fitted)
    )
    assert right < 0.001
    assert wrong > 2.0 * right


def test_fitting_the_physical_range_walk_does_not_change_it() -> None:
    found = solution_of_room(SONAR)
    fitted, excess = walking(found.model, found, NOISE), np.linspace(3.0, 20.0, 18)
    changed = fitted.walk_gain * fitted.walk(excess) - SONAR.walk_gain * SONAR.walk(excess)
    assert np.std(changed) < 0.0006


def test_without_echoes_or_with_rays_no_range_walk_is_fitted() -> None:
    found = solution_of_room(SONAR, stations=1)
    rays = SONAR.as_ray_cone(0.3)
    assert walking(rays, found, NOISE) is rays
    assert walking(SONAR, None, NOISE) is SONAR
    mute = replace(found, owners=np.full_like(found.owners, -1))
    assert walking(SONAR, mute, NOISE) is SONAR
