from dataclasses import replace

import numpy as np
import pytest

from echoplan.acoustics import speed_of_sound
from echoplan.acoustics.expectation import EchoModel
from echoplan.arrays import FloatArray
from echoplan.mapping.sonar import expected_sonar, half_aperture_of
from echoplan.sources import find_rig
from expectations import listening

RIG = find_rig("rotary-array")
assert RIG.transducer
SOUND = EchoModel.of(RIG.transducer)
SILENT = listening()


def gliding() -> FloatArray:
    """What a ray reads of a wall at 1 m, along which it glides."""
    return np.where(np.abs(SILENT.bearings) < 1.2, 1.0 / np.cos(SILENT.bearings), np.inf)


def test_what_tells_nothing_is_taken_for_sound() -> None:
    sonar = expected_sonar(RIG, SILENT)
    assert (sonar.cone, sonar.ka, sonar.figure_of_merit) == (0.0, SOUND.ka, SOUND.figure_of_merit)


def test_readings_tell_that_they_are_those_of_rays() -> None:
    seeing = expected_sonar(RIG, SILENT._replace(readings=gliding()))
    assert seeing.cone == half_aperture_of(RIG) == pytest.approx(RIG.sensors[0].half_aperture)


@pytest.mark.parametrize("rays", [False, True])
def test_the_rig_knows_better(*, rays: bool) -> None:
    readings = np.full(len(SILENT.readings), np.inf) if rays else gliding()
    assert (expected_sonar(replace(RIG, rays=rays), SILENT._replace(readings=readings)).cone > 0) == rays


def test_what_was_learned_before_stays() -> None:
    learned = expected_sonar(replace(RIG, rays=True), SILENT)
    assert expected_sonar(RIG, SILENT, learned).cone == learned.cone
    assert expected_sonar(RIG, SILENT._replace(readings=gliding()), SOUND).cone == 0.0


def test_the_thermometer_tells_the_range_scale() -> None:
    warm = expected_sonar(RIG, SILENT._replace(temperature=30.0))
    assert warm.range_scale == pytest.approx(float(speed_of_sound(30.0) / speed_of_sound(20.0)) - 1.0, abs=1e-4)
