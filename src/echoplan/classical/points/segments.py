"""Straight segments: stretches of lines through weighted points, by orthogonal regression."""

from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray, IntArray
from echoplan.classical.points.clouds import Cloud
from echoplan.geometry import along, directions, signed_distances, wrap
from echoplan.settings import Settings

__all__ = ["Segment", "SegmentSettings", "fit_orthogonal", "line_covariance", "segment_of"]


class SegmentSettings(Settings):
    """What makes a segment."""

    former_keys: ClassVar = {"common": "common_sigma"}

    band: float = Field(default=0.03, gt=0.0, description="Largest distance of a point from its line [m].")
    angle_step: float = Field(
        default=0.0175, gt=0.0, le=0.5, description="Step of the directions that are voted for [rad]."
    )
    max_gap: float = Field(
        default=0.7,
        gt=0.0,
        description="Largest gap between points of one segment [m]: a beam of 20 degrees to either side at 1 m.",
    )
    min_length: float = Field(
        default=0.3, gt=0.0, description="Smallest length of a segment that its points cover [m]."
    )
    reach: float = Field(default=0.1, gt=0.0, description="Length of a gap between two points that they cover [m].")
    min_weight: float = Field(default=6.0, gt=0.0, description="Smallest weight of a segment [points].")
    common_sigma: float = Field(
        default=0.005,
        gt=0.0,
        description="Standard deviation of the error that the points at each end share [m]: a step of a module.",
    )


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Segment:
    """A stretch of a line through points.

    Parameters
    ----------
    line : ndarray, shape (2,)
        ``(normal_angle, offset)`` [rad, m]; the normal points away from the origin.
    covariance : ndarray, shape (2, 2)
        Of the line, in that order.
    low, high : float
        Coordinates of its first and last point along the line [m].
    members : ndarray of int, shape (m,), optional
        Indices of its points.
    stations : int, optional
        Number of stations that detected them.
    """

    line: FloatArray
    covariance: FloatArray
    low: float
    high: float
    members: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    stations: int = 0

    @property
    def ends_xy(self) -> FloatArray:
        """First and last point [m], shape (2, 2)."""
        middle = self.line[1] * directions(self.line[0])
        ends: FloatArray = middle + np.outer([self.low, self.high], directions(self.line[0] + np.pi / 2))
        return ends

    def turned(self) -> "Segment":
        """Return the same segment with its normal to the other side."""
        mirror = np.diag([1.0, -1.0])
        return replace(
            self,
            line=np.array([wrap(self.line[0] + np.pi), -self.line[1]]),
            covariance=mirror @ self.covariance @ mirror,
            low=-self.high,
            high=-self.low,
        )


def fit_orthogonal(cloud: Cloud) -> FloatArray:
    """Fit a line by orthogonal regression (Pearson 1901).

    Parameters
    ----------
    cloud : Cloud
        At least one point.

    Returns
    -------
    ndarray, shape (2,)
        ``(normal_angle, offset)`` [rad, m] of the line with the least weighted sum of squared distances; the offset
        is not negative.

    Examples
    --------
    >>> cloud = Cloud(points_xy=[[0.0, 2.0], [1.0, 2.1], [2.0, 2.0]], weights=[1.0, 2.0, 1.0])
    >>> fit_orthogonal(cloud).round(3)
    array([1.571, 2.05 ])
    """
    away = cloud.points_xy - cloud.centroid_xy
    _, axes = np.linalg.eigh((away * cloud.weights[:, None]).T @ away)
    offset = float(cloud.centroid_xy @ axes[:, 0])
    x, y = axes[:, 0] * (1.0 if offset >= 0 else -1.0)
    return np.array([np.arctan2(y, x), abs(offset)])


def line_covariance(cloud: Cloud, line: FloatArray, settings: SegmentSettings) -> FloatArray:
    """Covariance of a line through points.

    The scatter of the points, with points of one stretch of the line counted once, and what the points at each end
    have in common, which no scatter shows.

    Parameters
    ----------
    cloud : Cloud
        Its points.
    line : ndarray, shape (2,)
        ``(normal_angle, offset)`` [rad, m].
    settings : SegmentSettings
        How long a stretch is, and what is common.

    Returns
    -------
    ndarray, shape (2, 2)
        Of normal angle and offset [rad, m].
    """
    coordinates = along(line, cloud.points_xy)
    weights = cloud.information(coordinates, spacing=settings.band)
    middle = float(weights @ coordinates / weights.sum())
    scatter = float(weights @ signed_distances(line, cloud.points_xy) ** 2 / weights.sum())
    lever = float(weights @ (coordinates - middle) ** 2)
    turn = scatter / lever + 2 * (settings.common_sigma / np.ptp(coordinates)) ** 2
    shift = scatter / float(weights.sum()) + settings.common_sigma**2 / 2
    # The offset is that of the middle, moved along the turned line to the foot of the origin.
    return np.array([[turn, middle * turn], [middle * turn, shift + middle**2 * turn]])


def segment_of(cloud: Cloud, line: FloatArray, settings: SegmentSettings, *, members: IntArray) -> Segment:
    """Make a segment of a line and its points.

    Parameters
    ----------
    cloud : Cloud
        Its points, not all in one place.
    line : ndarray, shape (2,)
        ``(normal_angle, offset)`` [rad, m].
    settings : SegmentSettings
        What makes its uncertainty.
    members : ndarray of int, shape (m,)
        Indices of the points.

    Returns
    -------
    Segment
        From the first to the last point.
    """
    coordinates = along(line, cloud.points_xy)
    return Segment(
        line=line,
        covariance=line_covariance(cloud, line, settings),
        low=float(coordinates.min()),
        high=float(coordinates.max()),
        members=members,
    )
