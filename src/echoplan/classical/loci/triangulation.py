"""Triangulation-based fusion (Wijk and Christensen 2000; as recalled).

The newest readings are crossed with those of the last few sweeps.  Crossings that lie together on the newest arc and
come from several sweeps support a point that stands there; crossings with one sweep only do not.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray, IntArray
from echoplan.classical.loci.crossings import Crossings, find_crossings
from echoplan.classical.loci.loci import Loci
from echoplan.settings import Settings

__all__ = ["Triangulated", "TriangulationSettings", "triangulate"]


class TriangulationSettings(Settings):
    """How many sweeps are remembered, and what agrees."""

    window: int = Field(
        default=10, ge=1, description="Number of earlier sweeps with which the newest is compared, as recalled."
    )
    gate: float = Field(default=0.05, gt=0.0, description="Length of an arc within which crossings agree [m].")
    min_angle: float = Field(
        default=0.1745, gt=0.0, lt=1.5708, description="Smallest angle between arcs that cross [rad]."
    )
    min_sweeps: int = Field(
        default=2, ge=1, description="Smallest number of earlier sweeps that must agree, as recalled."
    )


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Triangulated:
    """Points that several sweeps agree on.

    Parameters
    ----------
    points_xy : ndarray, shape (t, 2)
        The points [m].
    origins_xy : ndarray, shape (t, 2)
        Acoustic centres of the newest readings that found them [m].
    sweeps : ndarray of int, shape (t,)
        Numbers of the newest sweeps.
    counts : ndarray of int, shape (t,)
        How many earlier sweeps agree with the newest.
    """

    points_xy: FloatArray
    origins_xy: FloatArray
    sweeps: IntArray
    counts: IntArray

    @classmethod
    def joined(cls, parts: Sequence["Triangulated"]) -> "Triangulated":
        """Put triangulated points together.

        Parameters
        ----------
        parts : sequence of Triangulated
            Any number of them.

        Returns
        -------
        Triangulated
            All of them, in order.
        """
        return cls(
            points_xy=np.concatenate([np.zeros((0, 2)), *(part.points_xy for part in parts)]),
            origins_xy=np.concatenate([np.zeros((0, 2)), *(part.origins_xy for part in parts)]),
            sweeps=np.concatenate([np.zeros(0, dtype=np.int64), *(part.sweeps for part in parts)]),
            counts=np.concatenate([np.zeros(0, dtype=np.int64), *(part.counts for part in parts)]),
        )


def triangulate(newest: Loci, earlier: Loci, settings: TriangulationSettings) -> Triangulated:
    """Cross the newest arcs with earlier ones and count who agrees.

    Parameters
    ----------
    newest : Loci
        Arcs of one sweep.
    earlier : Loci
        Arcs of the sweeps before.
    settings : TriangulationSettings
        What agrees.

    Returns
    -------
    Triangulated
        At most one point for each of the newest arcs: the mean of the crossings on that stretch of it on which most
        earlier sweeps agree.
    """
    crossings = find_crossings(newest, earlier, min_angle=settings.min_angle)
    own = newest[crossings.first]
    places = np.floor(own.turns(crossings.points_xy) * own.ranges / (settings.gate / 2)).astype(np.int64)
    # Stretches overlap by half, so that two crossings nearer than half the gate are always on one together.
    arcs, stretches = np.tile(crossings.first, 2), np.concatenate([places, places - 1])
    fullest = _fullest(arcs, stretches, np.tile(earlier.sweeps[crossings.second], 2))
    return _means(newest, crossings, places, fullest[fullest[:, 2] >= settings.min_sweeps])


def _fullest(arcs: IntArray, stretches: IntArray, sweeps: IntArray) -> IntArray:
    """For each arc, the stretch on which most sweeps agree: rows of arc, stretch and count."""
    if not len(arcs):
        return np.zeros((0, 3), dtype=np.int64)
    lowest, span = stretches.min(), int(np.ptp(stretches)) + 1
    # One number for each pair of arc and stretch, and one for each sweep on it, sort faster than rows.
    places = arcs * span + (stretches - lowest)
    agreed = np.unique(places * (int(sweeps.max()) + 1) + sweeps) // (int(sweeps.max()) + 1)
    places, counts = np.unique(agreed, return_counts=True)
    order = np.lexsort((-counts, places // span))
    _, first = np.unique(places[order] // span, return_index=True)
    best = order[first]
    return np.column_stack([places[best] // span, places[best] % span + lowest, counts[best]])


def _means(newest: Loci, crossings: Crossings, places: IntArray, fullest: IntArray) -> Triangulated:
    stretch = np.full(len(newest), np.iinfo(np.int64).min // 2)
    stretch[fullest[:, 0]] = fullest[:, 1]
    beyond = places - stretch[crossings.first]
    own = (beyond == 0) | (beyond == 1)
    weights = np.bincount(crossings.first[own], minlength=len(newest))[fullest[:, 0]]
    sums = [
        np.bincount(crossings.first[own], weights=axis, minlength=len(newest))[fullest[:, 0]]
        for axis in crossings.points_xy[own].T
    ]
    return Triangulated(
        points_xy=np.column_stack(sums) / weights[:, None],
        origins_xy=newest.centers_xy[fullest[:, 0]],
        sweeps=newest.sweeps[fullest[:, 0]],
        counts=fullest[:, 2],
    )
