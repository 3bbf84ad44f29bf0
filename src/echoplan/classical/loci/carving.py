"""Arc carving (Silver et al. 2004; as recalled): what a newer echo shows to be free is cut out of older arcs."""

from dataclasses import dataclass

import numpy as np
from pydantic import Field

from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.classical.loci.loci import Loci
from echoplan.compiled import compiled, inlined
from echoplan.geometry import directions
from echoplan.settings import Settings

__all__ = ["Carved", "CarvingSettings", "carve", "longest_runs", "sample_turns"]


class CarvingSettings(Settings):
    """How finely arcs are cut, and what is left of them."""

    samples: int = Field(default=25, ge=3, description="Number of points that represent an arc.")
    margin: float = Field(
        default=0.05,
        gt=0.0,
        description="Distance before an echo from which on space is not surely free, for noise and pose errors [m].",
    )
    core: float = Field(
        default=0.5,
        gt=0.0,
        le=1.0,
        description="Share of the beam that is certain to be free before an echo: its rim may miss objects.",
    )
    max_width: float = Field(
        default=0.5236,
        gt=0.0,
        description="Largest width of what is left of an arc that gives a point [rad]: 30 degrees.",
    )


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Carved:
    """What is left of arcs.

    Parameters
    ----------
    arcs : ndarray of int, shape (m,)
        Numbers of the arcs of which something is left.
    turns : ndarray, shape (m,)
        Middle of the longest piece, from the beam axis [rad].
    widths : ndarray, shape (m,)
        Its width [rad].
    """

    arcs: IntArray
    turns: FloatArray
    widths: FloatArray


def sample_turns(loci: Loci, samples: int) -> FloatArray:
    """Spread points over arcs.

    Parameters
    ----------
    loci : Loci
        The arcs.
    samples : int
        How many points each.

    Returns
    -------
    ndarray, shape (n, samples)
        Angles from the beam axes, from one end to the other [rad].
    """
    return loci.half_apertures[:, None] * np.linspace(-1.0, 1.0, samples)


def carve(points_xy: FloatArray, left: BoolArray, cones: Loci, *, margin: float, core: float = 1.0) -> BoolArray:
    """Cut out of arcs what lies in the free part of beams.

    Parameters
    ----------
    points_xy : ndarray, shape (n, k, 2)
        Points on the arcs [m].
    left : ndarray of bool, shape (n, k)
        Which of them are left.
    cones : Loci
        Echoes: each shows that its beam is free up to its range.
    margin : float
        How much nearer than the echo [m].
    core : float, optional
        Part of the beam that counts.

    Returns
    -------
    ndarray of bool, shape (n, k)
        Which are left still.

    Examples
    --------
    >>> cone = Loci(centers_xy=[[0, 0]], ranges=[2.0], bearings=[0.0], half_apertures=[0.3], sweeps=[0])
    >>> points = np.array([[[1.0, 0.0], [1.0, 0.5], [1.99, 0.0]]])
    >>> carve(points, np.ones((1, 3), dtype=bool), cone, margin=0.05)
    array([[False,  True,  True]])
    """
    reaches = np.maximum(cones.ranges - margin, 0.0)
    axes, cosines = directions(cones.bearings), np.cos(core * cones.half_apertures)
    return _carve(points_xy, left, np.column_stack([cones.centers_xy, axes, reaches, cosines]))


def longest_runs(left: BoolArray, turns: FloatArray) -> Carved:
    """Find the longest piece that is left of each arc.

    Parameters
    ----------
    left : ndarray of bool, shape (n, k)
        Which points of each arc are left.
    turns : ndarray, shape (n, k)
        Their angles from the beam axes, evenly spaced [rad].

    Returns
    -------
    Carved
        The first of several that are alike; each point stands for the step about it.

    Examples
    --------
    >>> left = np.array([[True, False, True, True], [False] * 4])
    >>> runs = longest_runs(left, np.tile([-0.3, -0.1, 0.1, 0.3], (2, 1)))
    >>> runs.arcs, runs.turns.round(6), runs.widths.round(6)
    (array([0]), array([0.2]), array([0.4]))
    """
    length, best, end = (np.zeros(len(left), dtype=np.int64) for _ in range(3))
    for number in range(left.shape[1]):
        length = (length + 1) * left[:, number]
        longer = length > best
        best, end = np.where(longer, length, best), np.where(longer, number, end)
    arcs = np.flatnonzero(best)
    steps = turns[arcs, 1] - turns[arcs, 0]
    last = turns[arcs, end[arcs]]
    return Carved(arcs=arcs, turns=last - (best[arcs] - 1) / 2 * steps, widths=best[arcs] * steps)


@compiled
def _carve(points_xy: FloatArray, left: BoolArray, cones: FloatArray) -> BoolArray:
    kept = left.copy()
    for arc in range(kept.shape[0]):
        for number in range(kept.shape[1]):
            if kept[arc, number]:
                kept[arc, number] = not _is_free(points_xy[arc, number, 0], points_xy[arc, number, 1], cones)
    return kept


@inlined
def _is_free(x: float, y: float, cones: FloatArray) -> bool:
    for cone in range(len(cones)):
        dx, dy = x - cones[cone, 0], y - cones[cone, 1]
        square = dx * dx + dy * dy
        if square < cones[cone, 4] ** 2:
            ahead = dx * cones[cone, 2] + dy * cones[cone, 3]
            if ahead > 0 and ahead * ahead >= square * cones[cone, 5] ** 2:
                return True
    return False
