"""Causes: a mistake in how a recording is written is found on the recording itself."""

import math
from dataclasses import replace

import numpy as np
import pytest

from echoplan.diagnosis import Cause, find_remedies
from echoplan.model import Axes, Conventions, Heading
from helpers.mistaken import RIG, sound_sweeps

pytestmark = pytest.mark.slow

NOW = Conventions()
MISTAKES = {
    "servo 180 to 0": (Cause.SERVO, Conventions(servo_sign=-1, servo_offset=math.pi / 2)),
    "compass": (Cause.HEADING, Conventions(heading=Heading.COMPASS)),
    "swapped": (Cause.AXES, Conventions(axes=Axes.YX)),
    "inches": (Cause.RANGE_UNIT, Conventions(range_unit=2.54)),
    "places in millimetres": (Cause.POSITION_UNIT, Conventions(position_unit=0.1)),
}


# Each takes ten seconds; those left out are in benchmarks/verdicts.py.
@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_found_with_its_remedy(name: str) -> None:
    cause, conventions = MISTAKES[name]
    best = find_remedies([conventions.undo(sweep) for sweep in sound_sweeps()[:4]], RIG, conventions=NOW)[0]
    assert best.cause is cause
    assert best.conventions == conventions
    assert best.share > 0.9 > best.share_before


def test_a_sensor_that_looks_backwards_is_found() -> None:
    backwards = replace(RIG, sensors=(RIG.sensors[0], replace(RIG.sensors[1], yaw=-math.pi / 2)))
    best = find_remedies(sound_sweeps()[:4], backwards, conventions=NOW)[0]
    assert (best.cause, best.sensor_id) == (Cause.SENSOR, 1)
    assert best.yaw == pytest.approx(math.pi / 2)


def test_only_the_given_mistakes_are_tested() -> None:
    clockwise = [Conventions(servo_sign=-1).undo(sweep) for sweep in sound_sweeps()[:4]]
    found = find_remedies(clockwise, RIG, conventions=NOW, causes=(Cause.SERVO,))
    assert {each.cause for each in found} == {Cause.SERVO}
    assert find_remedies(clockwise, RIG, conventions=NOW, causes=()) == ()


def test_nothing_is_found_in_a_sound_recording() -> None:
    assert find_remedies(sound_sweeps()[:4], RIG, conventions=NOW) == ()


def test_no_mistake_is_found_where_all_places_are_nearly_one() -> None:
    mirrored = [Conventions(servo_sign=-1).undo(sweep) for sweep in sound_sweeps()[:4]]
    near = [replace(sweep, map_from_base=sweep.map_from_base * np.array([0.01, 0.01, 1.0])) for sweep in mirrored]
    assert find_remedies(near, RIG, conventions=NOW) == ()


def test_a_wrong_convention_is_taken_back() -> None:
    wrong = Conventions(servo_sign=-1, range_unit=0.01)
    right = Conventions(range_unit=0.01)
    read = [wrong.apply(right.undo(sweep)) for sweep in sound_sweeps()[:4]]
    assert find_remedies(read, RIG, conventions=wrong)[0].conventions == right
