"""The MDP compensation (Eq. 1-5): what the turning arm adds to the distance of an object.

The sensor sits on an arm b; turned by theta away from the object's normal, its acoustic centre is farther from the
object than at theta = 0, by an amount that depends on the object: Eq. 1 for a flat, Eq. 5 for a cylinder of radius
r.  A flat is the limit r -> infinity, a corner the limit r = 0.
"""

import numpy as np
from numpy.typing import ArrayLike

from echoplan.arrays import FloatArray

__all__ = ["arm_excess", "cylinder_excess", "flat_excess"]


def flat_excess(angles: ArrayLike, *, arm: ArrayLike) -> FloatArray:
    """Excess distance of a flat object (Eq. 1).

    Parameters
    ----------
    angles : array_like, shape (n,)
        Angle theta of the arm from the normal of the object [rad].
    arm : array_like
        Length b of the arm [m]; broadcasts.

    Returns
    -------
    ndarray, shape (n,)
        ``b (1 - cos theta)`` [m].

    Examples
    --------
    >>> round(float(flat_excess(np.pi / 3, arm=0.05)), 6)
    0.025
    """
    excess: FloatArray = np.asarray(arm) * (1 - np.cos(np.asarray(angles, dtype=np.float64)))
    return excess


def cylinder_excess(angles: ArrayLike, *, arm: ArrayLike, depth: float, radius: float) -> FloatArray:
    """Excess distance of a cylinder (Eq. 2-5).

    Parameters
    ----------
    angles : array_like, shape (n,)
        Angle theta of the arm from the normal of the object [rad].
    arm : array_like
        Length b of the arm [m]; broadcasts.
    depth : float
        The reading a1 at theta = 0 [m].
    radius : float
        Radius r [m]; 0 for a corner.

    Returns
    -------
    ndarray, shape (n,)
        ``l2 / cos(beta) - a1 - r`` with ``l1 = b sin theta``, ``l2 = a1 + r + b (1 - cos theta)`` and
        ``beta = arctan(l1 / l2)`` [m].

    Examples
    --------
    >>> far = cylinder_excess(0.5, arm=0.05, depth=1.0, radius=1e6)
    >>> bool(np.isclose(far, flat_excess(0.5, arm=0.05)))
    True
    """
    angles = np.asarray(angles, dtype=np.float64)
    across = np.asarray(arm) * np.sin(angles)
    ahead = depth + radius + np.asarray(arm) * (1 - np.cos(angles))
    # l2 / cos(arctan(l1 / l2)) is the hypotenuse; written so, nothing overflows near 90 degrees.
    excess: FloatArray = np.hypot(across, ahead) - depth - radius
    return excess


def arm_excess(angles: ArrayLike, *, arm: ArrayLike, depth: float, radius: float) -> FloatArray:
    """Excess distance of an object of any curvature.

    Parameters
    ----------
    angles : array_like, shape (n,)
        Angle theta of the arm from the normal of the object [rad].
    arm : array_like
        Length b of the arm [m]; broadcasts.
    depth : float
        The reading a1 at theta = 0 [m].
    radius : float
        Radius of the object [m]: ``inf`` for a flat, 0 for a corner.

    Returns
    -------
    ndarray, shape (n,)
        Eq. 1 or Eq. 5 [m].
    """
    if np.isinf(radius):
        return flat_excess(angles, arm=arm)
    return cylinder_excess(angles, arm=arm, depth=depth, radius=radius)
