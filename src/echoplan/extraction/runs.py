"""Runs: neighbouring echoes around the circle whose distance does not jump, robust to dropouts and strays."""

import numpy as np

from echoplan.arrays import FloatArray, IntArray

__all__ = ["connected_runs"]


def connected_runs(
    bearings: FloatArray, distances: FloatArray, *, max_gap: float, jump: float, reach: int
) -> list[IntArray]:
    """Find runs of neighbouring echoes without a jump in distance.

    Echoes are taken around the full circle.  Each is linked to those of its next few neighbours that lie within a gap
    and differ by less than a jump: runs survive dropouts, step over stray echoes and wrap around 360 degrees.

    Parameters
    ----------
    bearings : ndarray, shape (n,)
        Directions of the beam axes [rad].
    distances : ndarray, shape (n,)
        Distances of the echoes [m]; ``inf`` where there is none.
    max_gap : float
        Greatest angle between two linked echoes [rad].
    jump : float
        Greatest difference of their distances [m].
    reach : int
        To how many neighbours an echo may be linked.

    Returns
    -------
    list of ndarray of int
        Indices of the echoes of each run; every finite echo is in one.

    Examples
    --------
    >>> bearings, distances = np.radians([1.0, 2, 3, 359, 90]), np.array([1.0, 1.01, 5, 1, 2])
    >>> sorted(run.tolist() for run in connected_runs(bearings, distances, max_gap=0.1, jump=0.02, reach=3))
    [[0, 1, 3], [2], [4]]
    """
    from scipy.sparse import coo_array  # noqa: PLC0415 - SciPy is slow to import, and only mappers need it
    from scipy.sparse.csgraph import connected_components  # noqa: PLC0415

    count = len(bearings)
    if not count:
        return []
    circle = np.argsort(np.mod(bearings, 2 * np.pi), kind="stable")
    first = np.tile(np.arange(count), reach)
    second = (first + np.repeat(np.arange(1, reach + 1), count)) % count
    a, b = circle[first], circle[second]
    with np.errstate(invalid="ignore"):
        near = np.abs(distances[b] - distances[a]) <= jump
    linked = near & (np.mod(bearings[b] - bearings[a], 2 * np.pi) <= max_gap)
    links = coo_array((np.ones(linked.sum()), (a[linked], b[linked])), shape=(count, count))
    labels = connected_components(links, directed=False)[1]
    detected = np.flatnonzero(np.isfinite(distances))
    order = detected[np.argsort(labels[detected], kind="stable")]
    return np.split(order, np.flatnonzero(np.diff(labels[order])) + 1) if len(order) else []
