"""Circles among weighted points: one around each knot of points that lie on a rim."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray, IntArray
from echoplan.classical.points.clouds import Cloud
from echoplan.settings import Settings

__all__ = ["Circle", "CircleSettings", "circle_covariance", "find_circles", "fit_taubin"]

_ROUNDS = 20
# Points so many times farther off the rim than the median do not belong to it.
_FARTHER = 2.0


class CircleSettings(Settings):
    """What makes a circle."""

    former_keys: ClassVar = {"common": "common_sigma"}

    link: float = Field(
        default=0.1, gt=0.0, description="Largest distance between neighbouring points of one object [m]."
    )
    band: float = Field(default=0.03, gt=0.0, description="Largest distance of a point from its circle [m].")
    min_radius: float = Field(
        default=0.03, gt=0.0, description="Smallest radius of a circle; a smaller one is an edge [m]."
    )
    max_radius: float = Field(default=0.5, gt=0.0, description="Largest radius of a cylinder [m].")
    min_weight: float = Field(default=6.0, gt=0.0, description="Smallest weight of a circle [points].")
    min_arc: float = Field(default=1.05, gt=0.0, description="Smallest part of the rim that must be observed [rad].")
    common_sigma: float = Field(
        default=0.005,
        gt=0.0,
        description="Standard deviation of the error that all points share [m]: a step of a module.",
    )


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Circle:
    """A circle through points.

    Parameters
    ----------
    parameters : ndarray, shape (3,)
        ``(x, y, radius)`` [m].
    covariance : ndarray, shape (3, 3)
        Of the parameters.
    members : ndarray of int, shape (m,)
        Indices of its points.
    stations : int, optional
        Number of stations that detected them.
    """

    parameters: FloatArray
    covariance: FloatArray
    members: IntArray
    stations: int = 0


def find_circles(cloud: Cloud, settings: CircleSettings) -> list[Circle]:
    """Find circles among points that nothing else explains.

    Parameters
    ----------
    cloud : Cloud
        The points.
    settings : CircleSettings
        What makes a circle.

    Returns
    -------
    list of Circle
        At most one for each knot of points.
    """
    circles = [_settled(cloud, knot, settings) for knot in _knots(cloud, settings.link)]
    return [circle for circle in circles if circle is not None]


def fit_taubin(cloud: Cloud) -> FloatArray | None:
    """Fit a circle by Taubin's method (1991), as Chernov (2010) puts it in terms of singular values.

    Parameters
    ----------
    cloud : Cloud
        The points.

    Returns
    -------
    ndarray, shape (3,), or None
        ``(x, y, radius)`` [m]; None for fewer than three points and for points on a line.

    Examples
    --------
    >>> cloud = Cloud(points_xy=[[1.2, 0.0], [1.0, 0.2], [0.8, 0.0]], weights=np.ones(3))
    >>> fit_taubin(cloud).round(6) + 0.0
    array([1. , 0. , 0.2])
    """
    if len(cloud) < 3:
        return None
    away = cloud.points_xy - cloud.centroid_xy
    squares = np.sum(away**2, axis=1)
    mean = float(cloud.weights @ squares / cloud.weight)
    if mean == 0.0:
        return None
    scaled = np.column_stack([(squares - mean) / (2 * np.sqrt(mean)), away]) * np.sqrt(cloud.weights)[:, None]
    _, _, axes = np.linalg.svd(scaled, full_matrices=False)
    bend = axes[2, 0] / (2 * np.sqrt(mean))
    if abs(bend) * np.sqrt(mean) < 1e-6:
        return None
    center = -axes[2, 1:] / (2 * bend)
    radius = float(np.sqrt(center @ center + mean))
    return np.append(center + cloud.centroid_xy, radius)


def circle_covariance(cloud: Cloud, circle: FloatArray, settings: CircleSettings) -> FloatArray | None:
    """Covariance of a circle through points.

    The residual ``|p - c| - r`` has the derivatives ``(-u, -1)`` by centre and radius, with u the direction of the
    point from the centre; points of one stretch of the rim count once.

    Parameters
    ----------
    cloud : Cloud
        Its points.
    circle : ndarray, shape (3,)
        ``(x, y, radius)`` [m].
    settings : CircleSettings
        How long a stretch is, and what is common.

    Returns
    -------
    ndarray, shape (3, 3), or None
        Of x, y and radius [m]; None if the points leave them undetermined.
    """
    away = cloud.points_xy - circle[:2]
    depths = np.hypot(*away.T)
    angles = np.arctan2(away[:, 1], away[:, 0])
    weights = cloud.information(angles * circle[2], spacing=settings.band)
    slopes = np.column_stack([away / depths[:, None], np.ones_like(depths)])
    information = (slopes * weights[:, None]).T @ slopes
    if np.linalg.cond(information) > 1e8:
        return None
    scatter = float(weights @ (depths - circle[2]) ** 2 / weights.sum()) + settings.common_sigma**2
    covariance: FloatArray = scatter * np.linalg.inv(information) + settings.common_sigma**2 * np.eye(3)
    return (covariance + covariance.T) / 2


def _knots(cloud: Cloud, link: float) -> list[IntArray]:
    """Points that are linked over steps of less than a length."""
    from scipy.sparse import coo_array  # noqa: PLC0415 - SciPy is slow to import
    from scipy.sparse.csgraph import connected_components  # noqa: PLC0415
    from scipy.spatial import cKDTree  # noqa: PLC0415

    if not len(cloud):
        return []
    pairs = cKDTree(cloud.points_xy).query_pairs(link, output_type="ndarray")
    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(cloud), len(cloud)))
    count, labels = connected_components(links)
    return [np.flatnonzero(labels == label) for label in range(count)]


def _settled(cloud: Cloud, knot: IntArray, settings: CircleSettings) -> Circle | None:
    """Fit and drop what lies farther off the rim than most, until all that is left lies on it."""
    members, circle = knot, fit_taubin(cloud[knot])
    for _ in range(_ROUNDS):
        if circle is None:
            return None
        off = np.abs(np.hypot(*(cloud.points_xy[knot] - circle[:2]).T) - circle[2])
        on_rim = knot[off <= max(settings.band, _FARTHER * float(np.median(off)))]
        if np.array_equal(on_rim, members):
            break
        members, circle = on_rim, fit_taubin(cloud[on_rim])
    return None if circle is None else _accepted(cloud[members], circle, members, settings)


def _accepted(own: Cloud, circle: FloatArray, members: IntArray, settings: CircleSettings) -> Circle | None:
    off = np.abs(np.hypot(*(own.points_xy - circle[:2]).T) - circle[2])
    likely = settings.min_radius <= circle[2] <= settings.max_radius and off.max() <= settings.band
    if not likely or own.weight < settings.min_weight or _arc(own, circle) < settings.min_arc:
        return None
    covariance = circle_covariance(own, circle, settings)
    if covariance is None or covariance[2, 2] > (circle[2] / 2) ** 2:
        return None
    return Circle(parameters=circle, covariance=covariance, members=members)


def _arc(cloud: Cloud, circle: FloatArray) -> float:
    """Part of the rim between the outermost points [rad]: a turn less the widest gap."""
    away = cloud.points_xy - circle[:2]
    angles = np.sort(np.arctan2(away[:, 1], away[:, 0]))
    gaps = np.diff(angles, append=angles[0] + 2 * np.pi)
    return float(2 * np.pi - gaps.max())
