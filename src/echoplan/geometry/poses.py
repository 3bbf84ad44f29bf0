"""Poses in the plane: ``(x, y, yaw)`` in metres and radians, the group SE(2) on arrays of poses.

A pose is named after what it does: ``map_from_base`` takes points in ``base_link`` to the map.
"""

import numpy as np
from numpy.typing import ArrayLike

from echoplan.arrays import FloatArray
from echoplan.geometry.angles import wrap

__all__ = ["aligned", "compose", "identity", "invert", "transform_points"]


def identity() -> FloatArray:
    """Return the pose that moves nothing.

    Returns
    -------
    ndarray of float64, shape (3,)
        ``(0, 0, 0)``.

    Examples
    --------
    >>> identity()
    array([0., 0., 0.])
    """
    return np.zeros(3)


def compose(a_from_b: ArrayLike, b_from_c: ArrayLike) -> FloatArray:
    """Chain poses: ``a_from_c`` of ``a_from_b`` and ``b_from_c``.

    Parameters
    ----------
    a_from_b, b_from_c : array_like, shape (..., 3)
        Poses ``(x, y, yaw)`` [m, m, rad]; leading axes broadcast.

    Returns
    -------
    ndarray of float64, shape (..., 3)
        ``a_from_c``, yaw in [-pi, pi).

    Examples
    --------
    >>> compose([1.0, 0.0, np.pi / 2], [2.0, 0.0, 0.0]).round(6)
    array([1.      , 2.      , 1.570796])
    """
    outer = np.asarray(a_from_b, dtype=np.float64)
    inner = np.asarray(b_from_c, dtype=np.float64)
    points = transform_points(outer, inner[..., :2])
    yaws = wrap(outer[..., 2] + inner[..., 2])
    return np.concatenate([points, yaws[..., None]], axis=-1)


def invert(a_from_b: ArrayLike) -> FloatArray:
    """Invert poses: ``b_from_a`` of ``a_from_b``.

    Parameters
    ----------
    a_from_b : array_like, shape (..., 3)
        Poses ``(x, y, yaw)`` [m, m, rad].

    Returns
    -------
    ndarray of float64, shape (..., 3)
        ``b_from_a``, yaw in [-pi, pi).

    Examples
    --------
    >>> pose = np.array([1.0, 2.0, 0.5])
    >>> np.allclose(compose(invert(pose), pose), 0.0)
    True
    """
    pose = np.asarray(a_from_b, dtype=np.float64)
    cosine, sine = np.cos(pose[..., 2]), np.sin(pose[..., 2])
    x, y = pose[..., 0], pose[..., 1]
    return np.stack([-cosine * x - sine * y, sine * x - cosine * y, wrap(-pose[..., 2])], axis=-1)


def transform_points(a_from_b: ArrayLike, points_b_xy: ArrayLike) -> FloatArray:
    """Take points from frame b to frame a.

    Parameters
    ----------
    a_from_b : array_like, shape (..., 3)
        Poses ``(x, y, yaw)`` [m, m, rad].
    points_b_xy : array_like, shape (..., 2)
        Points in frame b [m]; leading axes broadcast against the poses.

    Returns
    -------
    ndarray of float64, shape (..., 2)
        The points in frame a [m].

    Examples
    --------
    >>> transform_points([1.0, 0.0, np.pi / 2], [[2.0, 0.0]]).round(6)
    array([[1., 2.]])
    """
    pose = np.asarray(a_from_b, dtype=np.float64)
    points = np.asarray(points_b_xy, dtype=np.float64)
    cosine, sine = np.cos(pose[..., 2]), np.sin(pose[..., 2])
    x = pose[..., 0] + cosine * points[..., 0] - sine * points[..., 1]
    y = pose[..., 1] + sine * points[..., 0] + cosine * points[..., 1]
    return np.stack([x, y], axis=-1)


def aligned(poses: ArrayLike, onto: ArrayLike) -> FloatArray:
    r"""Move poses as one body to where their positions are nearest to those of others, in least squares.

    With positions as complex numbers p and q about their means, the turn is the argument of the sum of conj(p) q, as
    of Umeyama (1991) in the plane without scale.

    Parameters
    ----------
    poses, onto : array_like, shape (n, 3)
        Poses ``(x, y, yaw)`` [m, m, rad], at least one.

    Returns
    -------
    ndarray of float64, shape (n, 3)
        The moved ones, yaw in [-pi, pi).

    Examples
    --------
    >>> aligned([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], onto=[[2.0, 0.0, 0.0], [2.0, 1.0, 0.0]]).round(6)
    array([[2.      , 0.      , 1.570796],
           [2.      , 1.      , 1.570796]])
    """
    own, others = np.asarray(poses, dtype=np.float64), np.asarray(onto, dtype=np.float64)
    middle, target = own[:, :2].mean(axis=0), others[:, :2].mean(axis=0)
    (x, y), (u, v) = (own[:, :2] - middle).T, (others[:, :2] - target).T
    turn = np.arctan2(x @ v - y @ u, x @ u + y @ v)
    about = compose([*target, turn], invert([*middle, 0.0]))
    return compose(about, own)
