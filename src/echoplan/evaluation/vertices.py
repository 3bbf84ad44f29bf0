"""The true corners of a room: where its faces end."""

from dataclasses import dataclass

import numpy as np

from echoplan.arrays import FloatArray, IntArray, checked_floats, checked_integers, store
from echoplan.model import Truth

__all__ = ["Vertices", "true_vertices"]

# Ends of faces that agree to a tenth of a millimetre are one vertex: files round.
_DECIMALS = 4


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Vertices:
    """Points in which true faces end.

    Parameters
    ----------
    positions_xy : ndarray, shape (v, 2)
        The points [m], rounded to 0.1 mm.
    detected_by : ndarray of int, shape (v,)
        Number of stations that can detect the less detected of its two faces; 0 where not just two faces meet.
    """

    positions_xy: FloatArray
    detected_by: IntArray

    def __post_init__(self) -> None:
        positions = checked_floats(self.positions_xy, name="positions_xy", shape=(None, 2))
        store(
            self,
            positions_xy=positions,
            detected_by=checked_integers(self.detected_by, name="detected_by", shape=(len(positions),)),
        )


def true_vertices(truth: Truth) -> Vertices:
    """Find the vertices of a truth.

    Parameters
    ----------
    truth : Truth
        The faces and the number of stations that can detect each.

    Returns
    -------
    Vertices
        Every end of a face once, ordered by x, then y.

    Examples
    --------
    >>> truth = Truth(walls_xy=[[[0, 0], [4, 0]], [[4, 0], [4, 3]]], walls_detected_by=[5, 2])
    >>> true_vertices(truth).detected_by
    array([0, 2, 0])
    """
    ends = truth.walls_xy.reshape(-1, 2).round(_DECIMALS)
    positions, vertex_of_end = np.unique(ends, axis=0, return_inverse=True)
    faces = np.bincount(vertex_of_end, minlength=len(positions))
    detected_by = np.full(len(positions), np.iinfo(np.int64).max)
    np.minimum.at(detected_by, vertex_of_end, np.repeat(truth.walls_detected_by, 2))
    return Vertices(positions_xy=positions, detected_by=np.where(faces == 2, detected_by, 0))
