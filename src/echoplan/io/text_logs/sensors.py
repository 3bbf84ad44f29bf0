"""Sensors: the rig behind the distances of a line."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from echoplan.errors import InputError
from echoplan.io.builtin import builtin_rig
from echoplan.io.text_logs.columns import Column, Role
from echoplan.io.text_logs.facts import Fact, Origin
from echoplan.io.text_logs.options import LogOptions
from echoplan.model import Rig

__all__ = ["understood_sensors"]

# From the axis of the servo to the face of a sensor on a home-made head [m].
_ARM = 0.03
# One sensor looks ahead; four on one servo are mounted crosswise, and printed counter-clockwise from that one [rad].
_CROSSWISE = {1: [0.0], 4: [0.0, 0.5 * math.pi, math.pi, 1.5 * math.pi]}


def understood_sensors(columns: Sequence[Column], options: LogOptions, *, source: str) -> tuple[Rig, Fact]:
    """Return the rig, its sensors in the order of the columns of distances."""
    yaws = [column.yaw for column in columns if column.role is Role.RANGE]
    if options.rig is None:
        return _home_made(yaws, source=source)
    count, name = len(yaws), options.rig.name
    if len(options.rig.sensors) != count:
        problem = f"a line has {count} distances, but the rig {name!r} {len(options.rig.sensors)} sensors"
        raise InputError(source, problem, remedy="name another --rig, or - for distances to leave out in --columns")
    if any(yaw is not None for yaw in yaws):
        problem = f"the rig {name!r} says where its sensors point, and so does @ in --columns"
        raise InputError(source, problem, remedy="leave out --rig, or @ and the angle behind it")
    return options.rig, Fact(subject="sensors", value=f"{count}: {name}", origin=Origin.OPTION)


def _home_made(yaws: Sequence[float | None], *, source: str) -> tuple[Rig, Fact]:
    """Return HC-SR04 on a servo, pointing to the given directions [rad], or as one or four usually do."""
    count = len(yaws)
    given = [yaw for yaw in yaws if yaw is not None]
    directions = given or _CROSSWISE.get(count, [])
    if len(directions) != count:
        problem = f"a line has {count} distances, and nothing says where the sensors point"
        remedy = f"give --rig with {count} sensors in their order, or directions: --columns range@0,range@90, say"
        raise InputError(source, problem, remedy=remedy)
    sensor = builtin_rig("hc-sr04-servo").sensors[0]
    sensors = tuple(
        replace(sensor, sensor_id=number, x=_ARM * math.cos(yaw), y=_ARM * math.sin(yaw), yaw=yaw)
        for number, yaw in enumerate(directions)
    )
    degrees = ", ".join(f"{degree:g}" for degree in np.degrees(directions))
    value = f"{count} HC-SR04, face {100.0 * _ARM:g} cm from the axis, pointing to {degrees} deg"
    origin = Origin.OPTION if given else Origin.DEFAULT
    return Rig(name="HC-SR04 on a servo", sensors=sensors), Fact(subject="sensors", value=value, origin=origin)
