"""Limits, beam and resolution of each sensor, from the messages of a bag."""

import math

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.errors import InputError
from echoplan.io.ros.contents import BagContents
from echoplan.io.ros.mounting import Mounting
from echoplan.io.ros.series import Series, SeriesKey
from echoplan.io.units import possible_length_units
from echoplan.model import UNITS, Sensor

__all__ = ["sensor_of"]

# Resolutions of sensors are multiples of this [m]: centimetres, millimetres, inches of 25.4 mm.
_UNIT = 1e-4
# No robot is larger [m]; as in rig.toml.
_FARTHEST_MOUNT = 50.0
# Ultrasound in air reaches no farther [m]; as in rig.toml.
_LONGEST_RANGE = 50.0
# For remedies: the properties that a sensor needs, with a typical value from data sheets.
_EXAMPLES = {"field_of_view": "0.5", "min_range": "0.02", "max_range": "4"}
# Fewer distinct readings may have a common divisor by chance.
_FEWEST_READINGS = 3


def sensor_of(read: BagContents, key: SeriesKey, *, series: Series, mounting: Mounting, sensor_id: int) -> Sensor:
    """Describe a sensor by its messages, or by the constants that the user states.

    Raises ``InputError`` if the opening of its beam or its limits are unknown or cannot be.
    """
    view, least, most = (_known(read, key, name=name, series=series) for name in _EXAMPLES)
    if view > 2.0 * math.pi:
        problem = f"field_of_view is {view:g}, more than a full turn"
        remedy = f"if these are degrees, add --field field_of_view={math.radians(view):.4f} [rad]"
        raise InputError(read.path, problem, place=key.topic, remedy=remedy)
    if least >= most:
        problem, remedy = f"min_range, {least:g}, is not less than max_range, {most:g}", "state them: {} {}"
        examples = (f"--field {name}={_EXAMPLES[name]}" for name in ("min_range", "max_range"))
        raise InputError(read.path, problem, place=key.topic, remedy=remedy.format(*examples))
    x, y, yaw = mounting.turret_from_sensor.tolist()
    farthest = float(np.abs([x, y, *mounting.base_from_turret[:2]]).max())
    if farthest > _FARTHEST_MOUNT:
        remedy = "write the transforms in metres, or state it with --mount"
        raise InputError(read.path, f"it is mounted {farthest:g} m from the robot", place=key.topic, remedy=remedy)
    _check_unit(read, key, ranges=series.column("range"), least=least, most=most)
    return Sensor(
        sensor_id=sensor_id,
        x=x,
        y=y,
        yaw=yaw,
        half_aperture=view / 2.0,
        min_range=least,
        max_range=most,
        resolution=_step_of(series.column("range")),
    )


def _check_unit(read: BagContents, key: SeriesKey, *, ranges: FloatArray, least: float, most: float) -> None:
    """Refuse readings that cannot be in metres."""
    nearest, farthest = np.full(len(ranges), least), np.full(len(ranges), most)
    units = possible_length_units(ranges, min_ranges=nearest, max_ranges=farthest) or (
        ("cm", "mm") if most > _LONGEST_RANGE else ()
    )
    if units:
        field = next((str(each) for each in read.options.ranges if each.topic == key.topic), f"{key.topic}.range")
        factors = " or ".join(f"--field range={field}*{UNITS[unit]:g}" for unit in units)
        problem = f"its ranges, up to {np.max(ranges[np.isfinite(ranges)], initial=0.0):g}, are not in metres"
        remedy = f"add {factors}, and state field_of_view, min_range and max_range with --field"
        raise InputError(read.path, f"{problem} where max_range is {most:g}", place=key.topic, remedy=remedy)


def _known(read: BagContents, key: SeriesKey, *, name: str, series: Series) -> float:
    """Return the opening of the beam or a limit; the largest value if it changes."""
    stated = read.options.constant(name)
    # Single precision turns 0.02 into 0.0199999996.
    value = float(f"{np.max(series.column(name)):.7g}") if stated is None else stated
    if math.isfinite(value) and (value > 0.0 or (name == "min_range" and value == 0.0)):
        return value
    problem = f"its messages lack the {name}" if math.isnan(value) else f"its {name} is {value:g}"
    unit = "rad, the full angle" if name == "field_of_view" else "m"
    remedy = f"state it from the data sheet, for example --field {name}={_EXAMPLES[name]} [{unit}]"
    raise InputError(read.path, problem, place=key.topic, remedy=remedy)


def _step_of(ranges: FloatArray) -> float:
    """Find the largest step of which all readings are multiples; 0 if there is none."""
    tenths = np.unique(ranges[np.isfinite(ranges)]) / _UNIT
    units = np.rint(tenths)
    if len(units) < _FEWEST_READINGS or (np.abs(tenths - units) > 0.1).any():
        return 0.0
    return round(float(np.gcd.reduce(units.astype(np.int64))) * _UNIT, 4)
