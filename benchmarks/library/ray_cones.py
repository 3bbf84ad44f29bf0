"""Ray cones: the sonar of most robot simulators."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.model import Pings, Rig, Sweep, World

__all__ = ["cast", "with_cones"]


def with_cones(rig: Rig, half_angle: float) -> Rig:
    """Give all sensors of a rig another cone, and steps of a millimetre."""
    sensors = tuple(replace(each, half_aperture=half_angle, resolution=0.001) for each in rig.sensors)
    return replace(rig, sensors=sensors)


def cast(
    sweeps: Sequence[Sweep], world: World, rig: Rig, *, rays: int, noise: float, rng: np.random.Generator
) -> list[Sweep]:
    """Replace the ranges of sweeps by the least range of the rays in the cone of each ping."""
    found = []
    for sweep in sweeps:
        pings = Pings.from_sweep(sweep, rig)
        half = np.array([each.half_aperture for each in rig.sensors])[pings.sensors]
        bearings = pings.bearings[:, None] + half[:, None] * np.linspace(-1.0, 1.0, rays)
        nearest = np.minimum(
            _to_faces(pings.origins_xy, bearings, world), _to_cylinders(pings.origins_xy, bearings, world)
        )
        ranges = nearest.min(axis=1) + rng.normal(0.0, noise, len(nearest))
        found.append(replace(sweep, ranges=np.where(ranges < rig.max_ranges[pings.sensors], ranges, np.inf)))
    return found


def _to_faces(origins_xy: FloatArray, bearings: FloatArray, world: World) -> FloatArray:
    """Range of each ray to the nearest face [m], shape (n, rays)."""
    ways = np.stack([np.cos(bearings), np.sin(bearings)], axis=-1)[:, :, None]
    starts, ends = world.segments_xy[:, 0], world.segments_xy[:, 1]
    along, off = ends - starts, (starts - origins_xy[:, None])[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        turned = ways[..., 0] * along[:, 1] - ways[..., 1] * along[:, 0]
        ranges = (off[..., 0] * along[:, 1] - off[..., 1] * along[:, 0]) / turned
        places = (off[..., 0] * ways[..., 1] - off[..., 1] * ways[..., 0]) / turned
    met = (ranges > 0.0) & (places >= 0.0) & (places <= 1.0)
    nearest: FloatArray = np.where(met, ranges, np.inf).min(axis=-1, initial=np.inf)
    return nearest


def _to_cylinders(origins_xy: FloatArray, bearings: FloatArray, world: World) -> FloatArray:
    """Range of each ray to the nearest cylinder [m], shape (n, rays)."""
    ways = np.stack([np.cos(bearings), np.sin(bearings)], axis=-1)[:, :, None]
    off = (world.discs[:, :2] - origins_xy[:, None])[:, None]
    ahead, aside = (off * ways).sum(axis=-1), off[..., 0] * ways[..., 1] - off[..., 1] * ways[..., 0]
    inside = world.discs[:, 2] ** 2 - aside**2
    ranges = ahead - np.sqrt(np.maximum(inside, 0.0))
    nearest: FloatArray = np.where((inside > 0.0) & (ranges > 0.0), ranges, np.inf).min(axis=-1, initial=np.inf)
    return nearest
