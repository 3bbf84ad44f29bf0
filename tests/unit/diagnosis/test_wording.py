"""Words: each reason is a sentence, each remedy a line of rig.toml."""

import math

import pytest

from echoplan.diagnosis import Cause, Measures, Misplaced, Remedy
from echoplan.diagnosis.wording import next_step, reasons
from echoplan.model import Axes, Conventions, Heading
from echoplan.preprocessing import Faults, RecordingFault, RecordingFaultKind, SensorFault, SensorFaultKind

NOW = Conventions()


def measures(*remedies: Remedy, **changes: object) -> Measures:
    return Measures(**({"share": 0.49, "confirmed": 0.9, "features": 5, "remedies": remedies} | changes))  # type: ignore[arg-type]


def remedy(cause: Cause, conventions: Conventions = NOW, **changes: object) -> Remedy:
    return Remedy(cause=cause, conventions=conventions, share=0.97, share_before=0.49, **changes)  # type: ignore[arg-type]


REMEDIES = {
    "clockwise": (
        remedy(Cause.SERVO, Conventions(servo_sign=-1)),
        "The servo seems to turn clockwise",
        "Set servo_sign = -1 under [conventions]",
    ),
    "half turn": (
        remedy(Cause.SERVO, Conventions(servo_offset=-math.pi / 2)),
        "The servo seems to look ahead at 90 degrees",
        "Set servo_offset = -1.5708 under",
    ),
    "half turn, clockwise": (
        remedy(Cause.SERVO, Conventions(servo_sign=-1, servo_offset=math.pi / 2)),
        "The servo seems to look ahead at 90 degrees and to turn clockwise",
        "Set servo_sign = -1 and servo_offset = 1.5708 under",
    ),
    "compass": (
        remedy(Cause.HEADING, Conventions(heading=Heading.COMPASS)),
        "Headings seem to be those of a compass, clockwise from +y",
        'Set heading = "compass" under',
    ),
    "swapped": (
        remedy(Cause.AXES, Conventions(axes=Axes.YX)),
        "X and y seem to be swapped",
        'Set axes = "yx" under',
    ),
    "inches": (
        remedy(Cause.RANGE_UNIT, Conventions(range_unit=2.54)),
        "The ranges seem to be inches that were taken for centimetres",
        "Set range_unit = 2.54 under",
    ),
    "inches, rounded": (
        remedy(Cause.RANGE_UNIT, Conventions(range_unit=0.0254 * (1.0 + 5e-7))),
        "The ranges seem to be inches that were taken for metres",
        "Set range_unit = 0.0254 under",
    ),
    "a unit without a name": (
        remedy(Cause.RANGE_UNIT, Conventions(range_unit=1.7)),
        "The ranges seem to be in another unit",
        "Set range_unit = 1.7 under",
    ),
    "places in centimetres": (
        remedy(Cause.POSITION_UNIT, Conventions(position_unit=0.01)),
        "X and y seem to be centimetres that were taken for metres",
        'Set position_unit = "cm" under',
    ),
    "backwards": (
        remedy(Cause.SENSOR, sensor_id=2, yaw=-1.5708),
        "Sensor 2 seems to look the other way",
        "Set yaw = -1.57080 of sensor 2 in rig.toml and map again.",
    ),
}


@pytest.mark.parametrize("name", REMEDIES)
def test_a_remedy_is_a_line_of_the_rig(name: str) -> None:
    what, problem, step = REMEDIES[name]
    assert reasons(measures(what), NOW)[0] == f"{problem}: 97 % of the echoes fit together then, instead of 49 %."
    assert next_step(measures(what), NOW).startswith(step)


def test_a_remedy_that_explains_as_much_is_named_too() -> None:
    both = measures(remedy(Cause.SERVO, Conventions(servo_sign=-1)), remedy(Cause.AXES, Conventions(axes=Axes.Y_DOWN)))
    assert next_step(both, NOW).endswith(
        ' If y seems to point right of x, as on a screen, set axes = "x-y" under [conventions] in rig.toml instead.'
    )


@pytest.mark.parametrize("name", REMEDIES)
def test_without_a_rig_file_the_remedy_is_to_make_one_first(name: str) -> None:
    what, _, step = REMEDIES[name]
    found = next_step(measures(what), NOW, has_rig_file=False)
    assert found.startswith(step)
    assert found.endswith("echoplan convert SOURCE --to rec/ writes pings.csv and rig.toml. Map rec/ then.")


def test_without_a_rig_file_there_is_none_to_check() -> None:
    assert "check rig.toml" in next_step(measures(), NOW)
    assert "check where the sensors are mounted and the poses" in next_step(measures(), NOW, has_rig_file=False)


def test_what_only_one_station_detects_is_a_reason_beside_what_does_not_fit() -> None:
    lone = "Only 20 % of the echoes come from something that two stations detect."
    assert reasons(measures(share=0.65, confirmed=0.2), NOW) == ("Only 65 % of the echoes fit together.", lone)
    assert reasons(measures(share=0.9, confirmed=0.2), NOW) == (lone,)


def test_a_station_is_named_by_its_sweep_with_what_it_lacks() -> None:
    lone = measures(share=0.9, misplaced=(Misplaced(sweep=7, distance=0.15, turn=math.radians(-15.0), gain=40.0),))
    (reason,) = reasons(lone, NOW)
    assert (
        reason == "Sweep 7 does not fit the others: it would fit 0.15 m elsewhere and turned 15 degrees to the right."
    )
    assert next_step(lone, NOW).startswith("Check x, y and yaw of sweep 7")


@pytest.mark.parametrize(
    ("kind", "said", "step"),
    [
        (RecordingFaultKind.ONE_PLACE, "All readings are from one place", "Record again"),
        (RecordingFaultKind.NARROW_BEAM, "The beam is too narrow for sonar", "Map it with --method point-plot"),
    ],
)
def test_faults_of_the_recording_come_before_symptoms(kind: RecordingFaultKind, said: str, step: str) -> None:
    found = measures(share=0.2, faults=Faults(recording=(RecordingFault(kind=kind),)))
    assert reasons(found, NOW)[0].startswith(said)
    assert len(reasons(found, NOW)) == 2
    assert next_step(found, NOW).startswith(step)


def test_a_fault_of_a_sensor_is_a_reason_and_its_remedy_the_next_step() -> None:
    held = Faults(sensors=(SensorFault(sensor_id=3, kind=SensorFaultKind.HELD),))
    assert reasons(measures(share=0.9, faults=held), NOW)[0].startswith("Sensor 3 repeats its last reading")
    assert next_step(measures(share=0.9, faults=held), NOW).startswith("Correct the sensor")


def test_a_map_of_a_laser_by_points_says_that_nothing_checks_it() -> None:
    laser = Faults(recording=(RecordingFault(kind=RecordingFaultKind.NARROW_BEAM),))
    found = measures(share=1.0, faults=laser, unchecked="point-plot")
    assert reasons(found, NOW)[1:] == ("point-plot does not say how well its map explains the echoes.",)
    assert next_step(found, NOW).startswith("Measure some walls of the room")
