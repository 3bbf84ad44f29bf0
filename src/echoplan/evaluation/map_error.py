"""How far two sets of points lie apart: the criterion of Barshan (2008; as recalled)."""

import numpy as np

from echoplan.arrays import FloatArray, checked_floats
from echoplan.evaluation.outlines import DirectedError, MapError

__all__ = ["map_error"]


def map_error(points_xy: FloatArray, reference_xy: FloatArray) -> MapError:
    """Measure how far the points of a map and of a reference lie apart.

    With the n points p of the map and the m points q of the reference, the criterion is the mean of

    ``E = 1/2 (1/n sum_i min_j |p_i - q_j| + 1/m sum_j min_i |p_i - q_j|)``.

    Parameters
    ----------
    points_xy : ndarray, shape (n, 2)
        Points of the map: an arc map, or the centres of occupied cells [m].
    reference_xy : ndarray, shape (m, 2)
        What they should show, as densely as the map [m]; ``Outline.samples`` makes it of walls and cylinders.

    Returns
    -------
    MapError
        Both directions; nan where one of the sets is empty.

    Raises
    ------
    InvalidValueError
        If a number is not finite.

    Examples
    --------
    >>> map_error([[0, 0], [1, 0]], [[0, 0.1]]).mean.__round__(3)
    0.326
    """
    points = checked_floats(points_xy, name="points_xy", shape=(None, 2))
    reference = checked_floats(reference_xy, name="reference_xy", shape=(None, 2))
    return MapError(map_to_truth=_directed(points, reference), truth_to_map=_directed(reference, points))


def _directed(points_xy: FloatArray, others_xy: FloatArray) -> DirectedError:
    from scipy.spatial import cKDTree  # noqa: PLC0415 - SciPy is slow to import, and few commands compare points

    if not len(points_xy) or not len(others_xy):
        return DirectedError()
    distances, _ = cKDTree(others_xy).query(points_xy)
    return DirectedError(
        mean=float(distances.mean()), median=float(np.median(distances)), maximum=float(distances.max())
    )
