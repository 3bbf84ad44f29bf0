"""Straight segments among weighted points: the peak of a Hough vote, settled by orthogonal regression.

Duda and Hart (1972): a point votes for all lines through it.  The points of the fullest cell seed a line; it takes
the points within a band about it, as far as they follow one another without a gap, and is fitted again until it
takes no other.  What it explains is removed, and the next peak is looked for.
"""

from dataclasses import dataclass

import numpy as np
from pydantic import BaseModel, Field

from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.geometry import along, directions, signed_distances
from echoplan.mapping.ballots import Ballot
from echoplan.mapping.points.clouds import Cloud

__all__ = ["Segment", "SegmentSettings", "Segments", "find_segments", "fit_orthogonal", "line_covariance"]

_ROUNDS = 20


class SegmentSettings(BaseModel, frozen=True, extra="forbid"):
    """What makes a segment."""

    band: float = Field(default=0.03, gt=0.0, description="greatest distance of a point from its line [m]")
    angle_step: float = Field(default=0.0175, gt=0.0, le=0.5, description="step of the votes' directions [rad]")
    max_gap: float = Field(
        default=0.7,
        gt=0.0,
        description="greatest gap between points of one segment [m]: a beam of 20 degrees to either side at 1 m",
    )
    min_length: float = Field(default=0.3, gt=0.0, description="a segment of which points cover less is none [m]")
    reach: float = Field(default=0.1, gt=0.0, description="a gap between two points is covered up to so much of it [m]")
    min_weight: float = Field(default=6.0, gt=0.0, description="a segment of less weight is none [points]")
    common: float = Field(
        default=0.005, gt=0.0, description="what the points at each end have in common [m]: a step of a module"
    )


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Segment:
    """A stretch of a line through points.

    Parameters
    ----------
    line : ndarray, shape (2,)
        ``(normal_angle, offset)`` [rad, m]; the normal points away from the origin.
    covariance : ndarray, shape (2, 2)
        Of the line, in that order.
    members : ndarray of int, shape (m,)
        Indices of its points.
    """

    line: FloatArray
    covariance: FloatArray
    members: IntArray


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


def fit_orthogonal(cloud: Cloud) -> FloatArray:
    """Fit a line by orthogonal regression (Pearson 1901).

    Parameters
    ----------
    cloud : Cloud
        At least one point.

    Returns
    -------
    ndarray, shape (2,)
        ``(normal_angle, offset)`` [rad, m] of the line with the least weighted sum of squared distances; the offset
        is not negative.

    Examples
    --------
    >>> cloud = Cloud(points_xy=[[0.0, 2.0], [1.0, 2.1], [2.0, 2.0]], weights=[1.0, 2.0, 1.0])
    >>> fit_orthogonal(cloud).round(3)
    array([1.571, 2.05 ])
    """
    away = cloud.points_xy - cloud.centroid_xy
    _, axes = np.linalg.eigh((away * cloud.weights[:, None]).T @ away)
    offset = float(cloud.centroid_xy @ axes[:, 0])
    x, y = axes[:, 0] * (1.0 if offset >= 0 else -1.0)
    return np.array([np.arctan2(y, x), abs(offset)])


def line_covariance(cloud: Cloud, line: FloatArray, settings: SegmentSettings) -> FloatArray:
    """Tell how sure a line through points is.

    The scatter of the points, with points of one stretch of the line counted once, and what the points at each end
    have in common, which no scatter shows.

    Parameters
    ----------
    cloud : Cloud
        Its points.
    line : ndarray, shape (2,)
        ``(normal_angle, offset)`` [rad, m].
    settings : SegmentSettings
        How long a stretch is, and what is common.

    Returns
    -------
    ndarray, shape (2, 2)
        Of normal angle and offset [rad, m].
    """
    coordinates = along(line, cloud.points_xy)
    worth = cloud.information(coordinates, spacing=settings.band)
    middle = float(worth @ coordinates / worth.sum())
    scatter = float(worth @ signed_distances(line, cloud.points_xy) ** 2 / worth.sum())
    lever = float(worth @ (coordinates - middle) ** 2)
    turn = scatter / lever + 2 * (settings.common / np.ptp(coordinates)) ** 2
    shift = scatter / float(worth.sum()) + settings.common**2 / 2
    # The offset is that of the middle, moved along the turned line to the foot of the origin.
    return np.array([[turn, middle * turn], [middle * turn, shift + middle**2 * turn]])


def _line_cells(points_xy: FloatArray, settings: SegmentSettings) -> IntArray:
    """Cells of all lines through each point: directions over half a turn, offsets in steps of the band."""
    angles = np.arange(0.0, np.pi, settings.angle_step)
    rows = np.floor(points_xy @ directions(angles).T / settings.band).astype(np.int64)
    rows -= rows.min(initial=0)
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
    if own.weight < settings.min_weight or _covered(own, line, settings) < settings.min_length:
        return None
    return Segment(line=line, covariance=line_covariance(own, line, settings), members=members)


def _heaviest_run(cloud: Cloud, chosen: IntArray, line: FloatArray, settings: SegmentSettings) -> IntArray:
    """Of points near a line, those that follow one another without a gap and weigh most; in order of index."""
    coordinates = along(line, cloud.points_xy[chosen])
    order = np.argsort(coordinates, kind="stable")
    breaks = np.flatnonzero(np.diff(coordinates[order]) > settings.max_gap) + 1
    runs = np.split(chosen[order], breaks)
    return np.sort(max(runs, key=lambda run: float(cloud.weights[run].sum())))


def _covered(cloud: Cloud, line: FloatArray, settings: SegmentSettings) -> float:
    """Length of a line of which points tell [m]: two knots far apart have always one, and tell of little of it."""
    return float(np.minimum(np.diff(np.sort(along(line, cloud.points_xy))), settings.reach).sum())


def _explains(segment: Segment, cloud: Cloud, settings: SegmentSettings) -> BoolArray:
    """Tell which points a segment explains: those near it, and those just before or behind it."""
    coordinates = along(segment.line, cloud.points_xy)
    own = coordinates[segment.members]
    beside = (coordinates >= own.min() - settings.band) & (coordinates <= own.max() + settings.band)
    near = np.abs(signed_distances(segment.line, cloud.points_xy)) <= 2 * settings.band
    explained: BoolArray = beside & near
    return explained
