"""Arc-transversal medians (Choset, Nagatani and Lazar 2003; as recalled).

An echo comes from anywhere on its arc.  Where many other arcs cross it transversally there is something; the median
of these crossings along the arc is not moved by a few stray ones.
"""

from dataclasses import dataclass

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray, IntArray
from echoplan.classical.loci.crossings import find_crossings
from echoplan.classical.loci.loci import Loci
from echoplan.settings import Settings

__all__ = ["MedianSettings", "Medians", "transversal_medians"]


class MedianSettings(Settings):
    """What counts as a crossing, and how many have a median."""

    min_angle: float = Field(
        default=0.5236,
        gt=0.0,
        lt=1.5708,
        description="Smallest angle between arcs that cross [rad]: 30 degrees, as recalled.",
    )
    min_crossings: int = Field(
        default=3,
        ge=1,
        description="Smallest number of crossings of an arc that gives a point: of two, one outlier is half.",
    )


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Medians:
    """Where arcs were crossed in the middle.

    Parameters
    ----------
    arcs : ndarray of int, shape (m,)
        Numbers of the arcs that were crossed often enough.
    turns : ndarray, shape (m,)
        Median angle of the crossings from the beam axis [rad].
    """

    arcs: IntArray
    turns: FloatArray


def transversal_medians(loci: Loci, others: Loci, settings: MedianSettings) -> Medians:
    """Find the median of the transversal crossings along each arc.

    Parameters
    ----------
    loci : Loci
        The arcs.
    others : Loci
        Arcs that may cross them; themselves among them change nothing.
    settings : MedianSettings
        What counts.

    Returns
    -------
    Medians
        In the order of the arcs.
    """
    crossings = find_crossings(loci, others, min_angle=settings.min_angle)
    turns = loci[crossings.first].turns(crossings.points_xy)
    order = np.lexsort((turns, crossings.first))
    arcs, starts, counts = np.unique(crossings.first[order], return_index=True, return_counts=True)
    lower, upper = starts + (counts - 1) // 2, starts + counts // 2
    medians = (turns[order][lower] + turns[order][upper]) / 2
    enough = counts >= settings.min_crossings
    return Medians(arcs=arcs[enough], turns=medians[enough])
