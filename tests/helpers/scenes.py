"""Ideal scenes for tests: what a noiseless array would read of one object, by geometry alone."""

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.classical.features import Observation
from echoplan.extraction import Cluster, LocatedPoint
from echoplan.geometry import directions, wrap
from echoplan.model import Pings, Rig, Sensor, Sweep

ARM = 0.05
STEP = np.radians(1.0)


def rig(*, arm: float = ARM, sensors: int = 4) -> Rig:
    """Sensors on arms of one length, evenly around the turret."""
    yaws = 2 * np.pi * np.arange(sensors) / sensors
    return Rig(
        name="test rig",
        sensors=tuple(
            Sensor(
                sensor_id=number,
                x=arm * float(np.cos(yaw)),
                y=arm * float(np.sin(yaw)),
                yaw=float(yaw),
                half_aperture=0.61,
                min_range=0.03,
                max_range=3.0,
                resolution=0.005,
            )
            for number, yaw in enumerate(yaws)
        ),
    )


def pings(
    bearings: FloatArray, ranges: FloatArray, *, hub: tuple[float, float] = (0.0, 0.0), arm: float = ARM
) -> Pings:
    """Pings of one sensor that turns on an arm about a hub."""
    hubs = np.tile(hub, (len(bearings), 1))
    return Pings(
        origins_xy=hubs + arm * directions(bearings),
        hubs_xy=hubs,
        bearings=bearings,
        ranges=ranges,
        sensors=np.zeros(len(bearings), dtype=np.int64),
    )


def around(middle: float, half_width: float) -> FloatArray:
    """Bearings in steps of one degree about a middle."""
    count = round(half_width / STEP)
    bearings: FloatArray = middle + STEP * np.arange(-count, count + 1, dtype=np.float64)
    return bearings


def wall_ranges(bearings: FloatArray, *, normal: float, distance: float, arm: float = ARM) -> FloatArray:
    """Ranges to a wall whose perpendicular from the hub has this direction and length."""
    ranges: FloatArray = distance - arm * np.cos(bearings - normal)
    return ranges


def cylinder_ranges(
    bearings: FloatArray, *, normal: float, distance: float, radius: float, arm: float = ARM
) -> FloatArray:
    """Ranges to a cylinder whose nearest point, seen from the hub, has this direction and distance."""
    center = (distance + radius) * directions(normal)
    ranges: FloatArray = np.hypot(*(center - arm * directions(bearings)).T) - radius
    return ranges


def cluster(bearings: FloatArray, ranges: FloatArray, *, right: float = np.inf, left: float = np.inf) -> Cluster:
    """A cluster of pings about the origin."""
    return Cluster(pings=pings(bearings, ranges), bearings=bearings, right=right, left=left)


def observed_wall(
    line: tuple[float, float], hub: tuple[float, float], *, sweep: int = 0, degrees: tuple[float, ...] = (0.0, 0.0, 1.0)
) -> Observation:
    """A wall as an ideal sweep from a hub would locate it."""
    distance = line[1] - float(np.dot(directions(line[0]), hub))
    return observed(hub, bearing=float(wrap(line[0])), distance=distance, sweep=sweep, degrees=degrees)


def observed_circle(
    circle: tuple[float, float, float],
    hub: tuple[float, float],
    *,
    sweep: int = 0,
    degrees: tuple[float, ...] = (0.0, 1.0, 0.0),
) -> Observation:
    """A cylinder as an ideal sweep from a hub would locate it; a corner is one of radius 0."""
    away = np.array(circle[:2]) - np.array(hub)
    return observed(
        hub,
        bearing=float(np.arctan2(away[1], away[0])),
        distance=float(np.hypot(*away)) - circle[2],
        sweep=sweep,
        degrees=degrees,
    )


def observed(
    hub: tuple[float, float],
    *,
    bearing: float,
    distance: float,
    sweep: int = 0,
    degrees: tuple[float, ...],
    bearing_sigma: float = 0.0035,
) -> Observation:
    """An observation with the uncertainty of a good sweep: a fifth of a degree and a millimetre."""
    point = LocatedPoint(
        hub_xy=np.array(hub), bearing=bearing, distance=distance, covariance=np.diag([bearing_sigma**2, 0.001**2])
    )
    return Observation(sweep=sweep, point=point, degrees=np.array(degrees), pings=40)


def sweep_of(ranges_of: FloatArray, *, index: int = 0, pose: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Sweep:
    """A sweep of the four-sensor rig: ranges by whole degrees of bearing, 360 of them, from -45 degrees on."""
    steps = np.arange(90)
    sensors = np.arange(4)
    servo = np.repeat(np.radians(steps - 45.0), 4)
    return Sweep(
        index=index,
        stamps_ns=np.repeat(steps * 25_000_000, 4) + index * 10_000_000_000,
        sensor_ids=np.tile(sensors, 90),
        servo_angles=servo,
        ranges=ranges_of[(np.repeat(steps, 4) + 90 * np.tile(sensors, 90)) % 360],
        map_from_base=np.tile(pose, (360, 1)),
    )
