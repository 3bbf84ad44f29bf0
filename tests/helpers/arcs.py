"""Arcs for tests: what ideal sensors measure of a point or a wall, whose beams look past it by known angles."""

from collections.abc import Sequence

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.classical.loci import Loci
from echoplan.geometry import directions

HALF_APERTURE = 0.4


def nothing() -> Loci:
    """No arcs at all."""
    return Loci.joined([])


def on_point(
    point_xy: tuple[float, float], stations_xy: Sequence[tuple[float, float]], *, turns: Sequence[float] = (0.0,)
) -> Loci:
    """Arcs through a point: one for each station, in a sweep of its own, and each angle between axis and point."""
    away = np.array(point_xy) - np.array(stations_xy)
    return _arcs(stations_xy, np.arctan2(away[:, 1], away[:, 0]), np.hypot(*away.T), turns)


def on_wall(
    line: tuple[float, float], stations_xy: Sequence[tuple[float, float]], *, turns: Sequence[float] = (0.0,)
) -> Loci:
    """Arcs that touch a wall, likewise."""
    ranges = line[1] - np.array(stations_xy) @ directions(line[0])
    return _arcs(stations_xy, np.full(len(ranges), line[0]), ranges, turns)


def _arcs(
    stations_xy: Sequence[tuple[float, float]], bearings: FloatArray, ranges: FloatArray, turns: Sequence[float]
) -> Loci:
    count = len(turns)
    return Loci(
        centers_xy=np.repeat(np.array(stations_xy), count, axis=0),
        ranges=np.repeat(ranges, count),
        bearings=np.add.outer(bearings, turns).ravel(),
        half_apertures=np.full(len(ranges) * count, HALF_APERTURE),
        sweeps=np.repeat(np.arange(len(ranges)), count),
    )
