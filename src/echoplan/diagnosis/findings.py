"""Sentences about faults of readings and recordings: what is wrong, what is done about it, and what to do."""

import math
from collections.abc import Mapping

from echoplan.preprocessing import Faults, RecordingFaultKind, SensorFaultKind

__all__ = ["faults_in_words"]

# Text after the name of the sensor; a fault that several sensors share is reported once.
_SENSORS: Mapping[SensorFaultKind, str] = {
    SensorFaultKind.DEAD: (
        "has no echo where others have, or none at all. It is left out. Check its wiring and its power."
    ),
    SensorFaultKind.STUCK: (
        "reads {value} wherever the robot stands and the sensor points. It is left out. Check its wiring, and that "
        "nothing is in front of it."
    ),
    SensorFaultKind.NO_ECHO_VALUE: (
        "reads {value} where it has no echo ({percent} % of its readings). These readings are taken for no echo. Write "
        "inf for them."
    ),
    SensorFaultKind.BLIND_VALUE: (
        "reads {value} in {percent} % of its readings, and nothing nearer: that stands for anything too close. These "
        "readings are left out. Set min_range, in rig.toml or for a bag with --field, to the least distance that the "
        "module can measure."
    ),
    SensorFaultKind.FIXED_VALUE: (
        "reads {value} in {percent} % of its readings, also from places where nothing is at that distance. These "
        "readings are left out. Check whether it detects a part of the robot or the burst of another sensor."
    ),
    SensorFaultKind.HELD: (
        "repeats its last reading where it has no echo. Repeated readings are left out. Write inf after a timeout."
    ),
    SensorFaultKind.LOGGED_REPEATEDLY: (
        "is logged faster than it measures: each reading is there about {number} times. One of each is used. Log each "
        "reading once."
    ),
    SensorFaultKind.FLYBACK: (
        "reads while the servo is still on its way back: the first {number} readings of each sweep belong to other "
        "angles. They are left out. Wait 0.8 s before the first reading of a sweep."
    ),
}
_RECORDINGS: Mapping[RecordingFaultKind, str] = {
    RecordingFaultKind.NO_POSES: (
        "There are no positions in this recording: the robot never moves, but its readings change. No features are "
        "drawn. Write where the robot was: x and y in metres, yaw in radians."
    ),
    RecordingFaultKind.ONE_PLACE: (
        "All readings are from one place: a wall, a corner and a pole look the same from one place. Record from "
        "at least three places, 30 cm apart."
    ),
    RecordingFaultKind.TWO_PLACES: (
        "All readings are from two places: too few to be sure of a map. Record from at least three places, 30 cm apart."
    ),
    RecordingFaultKind.NARROW_BEAM: (
        "The beam is too narrow for sonar, about {beam} in all: these are readings of a laser or of infrared light. "
        "--method point-plot draws them."
    ),
}


def faults_in_words(faults: Faults) -> tuple[str, ...]:
    """Describe the faults of a recording, how they are handled and what to do.

    Parameters
    ----------
    faults : Faults
        Faults of a recording.

    Returns
    -------
    tuple of str
        One paragraph per fault, those of the recording first; sensors with the same fault share one.

    Examples
    --------
    >>> from echoplan.preprocessing import SensorFault
    >>> fault = SensorFault(sensor_id=0, kind=SensorFaultKind.HELD)
    >>> print(*faults_in_words(Faults(sensors=(fault,))))
    Sensor 0 repeats its last reading where it has no echo. Repeated readings are left out. Write inf after a timeout.
    """
    recordings = []
    for each in faults.recording:
        beam = max(math.degrees(2 * each.value), 2.0)
        recordings.append(_RECORDINGS[each.kind].format(beam=f"{beam:.0f}\N{DEGREE SIGN}"))
    sensors: dict[str, list[int]] = {}
    for fault in faults.sensors:
        value = "nan" if math.isnan(fault.value) else f"{round(fault.value, 3):g} m"
        percent, number = round(100 * fault.share), f"{fault.value:.0f}"
        words = _SENSORS[fault.kind].format(value=value, percent=percent, number=number)
        sensors.setdefault(words, []).append(fault.sensor_id)
    return (*recordings, *(f"{_named(own)} {words}" for words, own in sensors.items()))


def _named(numbers: list[int]) -> str:
    if len(numbers) == 1:
        return f"Sensor {numbers[0]}"
    return f"Each of the sensors {', '.join(map(str, numbers[:-1]))} and {numbers[-1]}"
