"""A small room as an ideal array detects it from within: four walls, a column, an edge and a stray echo, for tests."""

from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from echoplan.arrays import FloatArray
from echoplan.classical.mdp_fuzzy import MdpFuzzyMapper
from echoplan.geometry import directions, wrap
from echoplan.model import Sweep
from echoplan.viewer.stages import SweepStages, sweep_stages
from helpers.scenes import cylinder_ranges, rig, sweep_of, wall_ranges

# East, north, west and south, as (normal_angle, offset); none is as far away as another.
LINES = np.array([[0.0, 1.0], [np.pi / 2, 0.8], [-np.pi, 1.2], [-np.pi / 2, 0.6]])
COLUMN, EDGE = (0.75, 0.75, 0.1), (-0.9, 0.9, 0.0)
STRAY = 225
HUBS = ((0.0, 0.0), (0.1, -0.05))

# Beside the axis of the beam echoes are fainter, so that they are detected later [m/rad^2].
LATENESS = 0.02

# Directions from -45 degrees on, as sweeps of the four sensors hold them.
BEARINGS = np.radians(np.arange(360.0) - 45)


def recorded(hub: ArrayLike, *, index: int = 0) -> Sweep:
    """What an ideal array measures at a hub: walls over 41 degrees, the column over 23, the edge over 9."""
    ranges = np.full(360, np.inf)
    for normal, offset in LINES:
        distance = float(offset - directions(normal) @ np.asarray(hub))
        _put(ranges, wall_ranges(BEARINGS, normal=normal, distance=distance), normal=normal, half_width=20)
    for (x, y, radius), half_width in ((COLUMN, 11), (EDGE, 4)):
        away = np.array([x, y]) - hub
        normal, distance = float(np.arctan2(away[1], away[0])), float(np.hypot(*away)) - radius
        detected = cylinder_ranges(BEARINGS, normal=normal, distance=distance, radius=radius)
        _put(ranges, detected, normal=normal, half_width=half_width)
    ranges[(STRAY + 45) % 360] = 2.5
    return sweep_of(ranges, index=index, pose=(*np.asarray(hub).tolist(), 0.0))


@cache
def mapped() -> tuple[MdpFuzzyMapper, tuple[Sweep, ...]]:
    """A mapper that was given both sweeps, and the sweeps."""
    sweeps = tuple(recorded(hub, index=3 + 2 * number) for number, hub in enumerate(HUBS))
    mapper = MdpFuzzyMapper(rig())
    for sweep in sweeps:
        mapper.add(sweep)
    return mapper, sweeps


@cache
def staged() -> tuple[SweepStages, ...]:
    """Both sweeps, stage by stage."""
    mapper, sweeps = mapped()
    return tuple(sweep_stages(mapper, sweep) for sweep in sweeps)


def _put(ranges: FloatArray, own: FloatArray, *, normal: float, half_width: float) -> None:
    turns = wrap(BEARINGS - normal)
    near = np.abs(turns) <= np.radians(half_width) + 1e-9
    ranges[near] = own[near] + LATENESS * turns[near] ** 2
