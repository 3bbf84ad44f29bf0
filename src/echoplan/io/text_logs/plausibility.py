"""Plausibility: units and no-echo values that the numbers of a log show by themselves."""

import math
from collections.abc import Sequence

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.model import UNITS, Sensor

__all__ = ["looks_like_radians", "no_echo_values", "plausible_position_units", "plausible_range_units", "spacing"]

# Share of the echoes that must lie within what the sensor can read.
_READABLE = 0.98
# No room is so small that nine echoes in ten come from less [m].
_SMALLEST_ROOM = 0.5
# Share of the readings from which one value at the top is what the program writes for no echo.
_FREQUENT = 0.03
_FEWEST = 3
# Highest numbers of one and two bytes, and of sensors that answer over a bus.
_SENTINELS = (255.0, 2.55, 65535.0, 65.535, 6553.5, 8190.0, 8191.0, 819.0, 8.19)
# Places closer together than this are one place [m]; a robot is not put down farther away than it can see.
_NEAREST = 0.1


def no_echo_values(ranges: FloatArray) -> list[float]:
    """Return readings that stand for no echo: 0, one negative number, and a round number that is often the greatest."""
    finite = ranges[np.isfinite(ranges)]
    found = [0.0] if (finite == 0.0).any() else []
    negative = np.unique(finite[finite < 0.0])
    if len(negative) == 1:
        found.append(float(negative[0]))
    if finite.size:
        top = float(finite.max())
        count = int((finite == top).sum())
        digits = f"{top:.6g}".replace(".", "").strip("0")
        is_round = len(digits) <= 2 or set(digits) == {"9"} or top in _SENTINELS
        if top > 0.0 and is_round and count >= max(_FEWEST, _FREQUENT * finite.size):
            found.append(top)
    return found


def plausible_range_units(
    echoes: FloatArray, sensor: Sensor, *, units: dict[str, float], between: float | None
) -> list[str]:
    """Return the units in which the echoes can be readings of a sensor.

    ``between`` is the distance between successive places [m]; the echoes come from a room in which they lie.
    """
    fitting = []
    for name, unit in units.items():
        metres = echoes * unit
        readable = float(np.mean((metres >= sensor.min_range) & (metres <= 1.05 * sensor.max_range)))
        is_room = np.quantile(metres, 0.9) >= min(_SMALLEST_ROOM, 0.5 * sensor.max_range)
        # On its way from one place to the next there was nothing, and the sensor looked there, too.
        reaches = between is None or metres.max() >= min(between, 0.9 * sensor.max_range)
        if readable >= _READABLE and is_room and reaches:
            fitting.append(name)
    return fitting


def plausible_position_units(apart: float, sensor: Sensor) -> list[str]:
    """Return the units in which the median distance between successive places can be one."""
    return [name for name in ("cm", "m", "mm") if _NEAREST <= apart * UNITS[name] <= sensor.max_range]


def spacing(positions_xy: FloatArray) -> float | None:
    """Return the median distance between successive places, in their unit; None if there is one place only."""
    apart = np.hypot(*np.diff(positions_xy, axis=0).T)
    apart = apart[apart > 0.0]
    return float(np.median(apart)) if apart.size else None


def looks_like_radians(angles: Sequence[float] | FloatArray) -> bool:
    """Whether angles lie within a turn in radians and are no whole numbers."""
    values = np.asarray(angles, dtype=np.float64)
    return bool(len(values) and np.abs(values).max() <= 2.0 * math.pi + 0.01 and (values != values.round()).any())
