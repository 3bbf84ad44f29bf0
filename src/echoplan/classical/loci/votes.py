"""Votes of echoes for the lines and points that they may come from (Tardos, Neira, Newman and Leonard 2002).

An echo of range r received at (x, y) in a beam about theta comes from a wall ``(alpha, r + x cos(alpha) +
y sin(alpha))`` or from a corner ``(x + r cos(alpha), y + r sin(alpha))``, for some alpha within the beam.
"""

from collections.abc import Sequence

import numpy as np
from pydantic import Field

from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.classical.features.ballots import Ballot
from echoplan.classical.loci.loci import Loci
from echoplan.geometry import directions
from echoplan.settings import Settings

__all__ = ["VoteSettings", "chance_votes", "line_ballot", "point_ballot"]


class VoteSettings(Settings):
    """Cells of the accumulators, and what wins."""

    angle_step: float = Field(
        default=0.0175, gt=0.0, le=0.2, description="Step of alpha and of the normal of a line [rad]."
    )
    offset_step: float = Field(default=0.03, gt=0.0, description="Width of the cell of a line in offset [m].")
    cell: float = Field(default=0.05, gt=0.0, description="Side of the cell of a point [m].")
    gate: float = Field(
        default=0.03, gt=0.0, description="Largest distance of an arc from the line or point that causes it [m]."
    )
    min_votes: int = Field(default=4, ge=1, description="Smallest number of votes of a detection.")
    false_alarms: float = Field(
        default=0.1, gt=0.0, description="Expected number of detections that random ranges make in a map."
    )
    min_sweeps: int = Field(
        default=3,
        ge=1,
        description="Smallest number of sweeps that must vote for a detection: any two arcs share tangents and "
        "crossings.",
    )


def chance_votes(loci: Loci, *, width: float, cells: int, settings: VoteSettings) -> int:
    """Find how many votes a cell needs so that it hardly won them by chance.

    If ranges were random, up to the longest one, a cell would get a binomial number of votes: of the arcs that look
    into one direction, each with the share of the ranges that a cell is wide (a contrario detection, Desolneux, Moisan
    and Morel 2000).

    Parameters
    ----------
    loci : Loci
        The arcs that vote.
    width : float
        Of a cell, along a range [m].
    cells : int
        How many cells there are.
    settings : VoteSettings
        How many cells may win by chance.

    Returns
    -------
    int
        Least votes.
    """
    from scipy.special import bdtrc  # noqa: PLC0415 - SciPy is slow to import

    if not len(loci):
        return 1
    alphas, inside = _alphas(loci, settings.angle_step)
    directed = int(np.bincount(_columns(alphas, settings.angle_step)[inside]).max(initial=0))
    votes = np.arange(1, directed + 2)
    chances = cells * bdtrc(votes - 1.0, directed, min(width / float(loci.ranges.max()), 1.0))
    return int(votes[:-1][chances[:-1] <= settings.false_alarms].min(initial=directed + 1))


def line_ballot(loci: Loci, settings: VoteSettings) -> Ballot:
    """Let arcs vote for the lines that they touch.

    Parameters
    ----------
    loci : Loci
        The arcs.
    settings : VoteSettings
        Cells of normal angle and offset.

    Returns
    -------
    Ballot
        Only cells for which enough sweeps vote can lead.
    """
    alphas, inside = _alphas(loci, settings.angle_step)
    rays = directions(alphas)
    offsets = loci.ranges[:, None] + np.sum(loci.centers_xy[:, None] * rays, axis=2)
    columns = _columns(alphas, settings.angle_step)
    rows = _halves(offsets, settings.offset_step)
    return _ballot([(rows, columns), (rows - 1, columns)], inside, loci, settings)


def point_ballot(loci: Loci, settings: VoteSettings) -> Ballot:
    """Let arcs vote for the points on them.

    Parameters
    ----------
    loci : Loci
        The arcs.
    settings : VoteSettings
        Cells of x and y.

    Returns
    -------
    Ballot
        Only cells for which enough sweeps vote can lead.
    """
    alphas, inside = _alphas(loci, settings.angle_step)
    points = loci.centers_xy[:, None] + loci.ranges[:, None, None] * directions(alphas)
    columns, rows = np.moveaxis(_halves(points, settings.cell), -1, 0)
    overlapping = [(rows - up, columns - right) for up in (0, 1) for right in (0, 1)]
    return _ballot(overlapping, inside, loci, settings)


def _alphas(loci: Loci, step: float) -> tuple[FloatArray, BoolArray]:
    """Multiples of a step about each beam axis, and whether they lie within the beam."""
    most = int(np.ceil(loci.half_apertures.max(initial=0.0) / step))
    middles = np.rint(loci.bearings / step)[:, None]
    alphas: FloatArray = step * (middles + np.arange(-most, most + 1, dtype=np.float64))
    inside: BoolArray = np.abs(alphas - loci.bearings[:, None]) <= loci.half_apertures[:, None]
    return alphas, inside


def _columns(alphas: FloatArray, step: float) -> IntArray:
    """Return directions as numbers of steps around a turn."""
    columns: IntArray = np.mod(np.rint(alphas / step).astype(np.int64), round(2 * np.pi / step))
    return columns


def _halves(values: FloatArray, step: float) -> IntArray:
    """Count half steps: cells overlap by half, so that nothing lies on the border of all of them."""
    return np.floor(2 * values / step).astype(np.int64)


def _ballot(
    cells: Sequence[tuple[IntArray, IntArray]], inside: BoolArray, loci: Loci, settings: VoteSettings
) -> Ballot:
    """Name each cell of rows and columns once for each arc; cell 0 takes the votes that do not count."""
    lowest = min(int(columns.min(initial=0)) for _, columns in cells)
    width = max(int(columns.max(initial=0)) for _, columns in cells) - lowest + 1
    bottom = min(int(rows.min(initial=0)) for rows, _ in cells)
    named = [np.where(inside, 1 + (rows - bottom) * width + columns - lowest, 0) for rows, columns in cells]
    sorted_cells = np.sort(np.concatenate(named, axis=1), axis=1)
    once = np.where(np.diff(sorted_cells, axis=1, prepend=-1) == 0, 0, sorted_cells)
    ballot = Ballot(once, np.ones(len(loci)))
    ballot.strike(_contested_by_few(once, loci.sweeps, settings.min_sweeps))
    return ballot


def _contested_by_few(cells: IntArray, sweeps: IntArray, min_sweeps: int) -> IntArray:
    """Cells for which too few sweeps vote, and cell 0."""
    span = int(sweeps.max(initial=0)) + 1
    names, counts = np.unique(np.unique(cells * span + sweeps[:, None]) // span, return_counts=True)
    few: IntArray = names[(counts < min_sweeps) | (names == 0)]
    return few
