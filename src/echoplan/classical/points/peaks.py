"""Peaks of a Hough vote of points: the straight segments among them.

Duda and Hart (1972): a point votes for all lines through it.  The points of the fullest cell seed a line; it takes
the points within a band about it, as far as they follow one another without a gap, and is fitted again until it
takes no other.  What it explains is removed, and the next peak is looked for.
"""

from dataclasses import dataclass

import numpy as np

from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.classical.features.ballots import Ballot
from echoplan.classical.points.clouds import Cloud
from echoplan.classical.points.segments import Segment, SegmentSettings, fit_orthogonal, segment_of
from echoplan.geometry import along, directions, signed_distances

__all__ = ["Segments", "find_segments"]

_ROUNDS = 20


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Segments:
    """The segments of a cloud.

    Parameters
    ----------
    found : list of Segment
        The segments, the heaviest peak first; no point is a member of two.
    rest : ndarray of int, shape (r,)
        Indices of the points that no segment explains.
    """

    found: list[Segment]
    rest: IntArray


def find_segments(cloud: Cloud, settings: SegmentSettings) -> Segments:
    """Find the straight segments among points.

    Parameters
    ----------
    cloud : Cloud
        The points.
    settings : SegmentSettings
        What makes a segment.

    Returns
    -------
    Segments
        What lies on a line, and what does not.
    """
    ballot = Ballot(_line_cells(cloud.points_xy, settings), cloud.weights)
    free = np.ones(len(cloud), dtype=bool)
    found = []
    cell, votes = ballot.leader()
    while votes >= settings.min_weight:
        voters = ballot.voters(cell)
        seed = _heaviest_run(cloud, voters, fit_orthogonal(cloud[voters]), settings)
        segment = _settled(cloud, seed, free, settings)
        ballot.withdraw(seed)
        if segment is not None:
            explained = free & _explains(segment, cloud, settings)
            ballot.withdraw(np.flatnonzero(explained))
            free &= ~explained
            found.append(segment)
        cell, votes = ballot.leader()
    return Segments(found=found, rest=np.flatnonzero(free))


def _line_cells(points_xy: FloatArray, settings: SegmentSettings) -> IntArray:
    """Cells of all lines through each point: directions over half a turn, offsets in steps of the band."""
    angles = np.arange(0.0, np.pi, settings.angle_step)
    away = points_xy - points_xy.mean(axis=0) if len(points_xy) else points_xy
    rows = np.floor(away @ directions(angles).T / settings.band).astype(np.int64)
    cells: IntArray = rows * len(angles) + np.arange(len(angles))
    return cells


def _settled(cloud: Cloud, seed: IntArray, free: BoolArray, settings: SegmentSettings) -> Segment | None:
    """Fit and gather in turn until the points stay the same."""
    members = seed
    for _ in range(_ROUNDS):
        line = fit_orthogonal(cloud[members])
        near = np.flatnonzero(free & (np.abs(signed_distances(line, cloud.points_xy)) <= settings.band))
        run = _heaviest_run(cloud, near, line, settings)
        if np.array_equal(run, members) or not len(run):
            break
        members = run
    own = cloud[members]
    # Two distant clusters always share a line, but support little of its length.
    supported = np.minimum(np.diff(np.sort(along(line, own.points_xy))), settings.reach).sum()
    if own.weight < settings.min_weight or supported < settings.min_length:
        return None
    return segment_of(own, line, settings, members=members)


def _heaviest_run(cloud: Cloud, chosen: IntArray, line: FloatArray, settings: SegmentSettings) -> IntArray:
    """Of points near a line, those that follow one another without a gap and weigh most; in order of index."""
    coordinates = along(line, cloud.points_xy[chosen])
    order = np.argsort(coordinates, kind="stable")
    breaks = np.flatnonzero(np.diff(coordinates[order]) > settings.max_gap) + 1
    runs = np.split(chosen[order], breaks)
    return np.sort(max(runs, key=lambda run: float(cloud.weights[run].sum())))


def _explains(segment: Segment, cloud: Cloud, settings: SegmentSettings) -> BoolArray:
    """Mask of the points that a segment explains: those near it, and those just before or behind it."""
    coordinates = along(segment.line, cloud.points_xy)
    beside = (coordinates >= segment.low - settings.band) & (coordinates <= segment.high + settings.band)
    near = np.abs(signed_distances(segment.line, cloud.points_xy)) <= 2 * settings.band
    explained: BoolArray = beside & near
    return explained
