"""Plans: a map with what lies beneath it, ready to be drawn on paper or on a screen."""

import string
from dataclasses import dataclass, field

import numpy as np

from echoplan.arrays import FloatArray, IntArray, checked_floats, store
from echoplan.classical.features import Observation
from echoplan.model import Conventions, FeatureMap, OccupancyGrid, Truth
from echoplan.viewer.uncertainty import Ellipse, error_ellipse

__all__ = ["MOST_LABELS", "Plan", "station_labels"]

# More names than letters would cover each other, and so would names that are nearer than they are wide: a character is
# about this share of how far stations go.
MOST_LABELS, _CHARACTER = len(string.ascii_uppercase), 1.0 / 36.0

# Walls are drawn this thick, as a share of the drawing's greater side.
_THICKNESS = 0.012

# No enlarged ellipse is longer than this share of it.
_LONGEST = 0.1


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Plan:
    """A map with what lies beneath it.

    Parameters
    ----------
    feature_map : FeatureMap
        The map.
    truth : Truth, optional
        The room as it is.
    detections : tuple of Observation, optional
        Detections of single sweeps: each becomes a beam.
    echoes_xy : ndarray, shape (n, 2), optional
        Points that the readings would mean if sound were a ray [m].
    grid : OccupancyGrid, optional
        Cells of which the map was made.
    conventions : Conventions, optional
        How the recording is written that was mapped.
    """

    feature_map: FeatureMap
    truth: Truth | None = None
    detections: tuple[Observation, ...] = ()
    echoes_xy: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))
    grid: OccupancyGrid | None = None
    conventions: Conventions = field(default_factory=Conventions)

    def __post_init__(self) -> None:
        store(self, echoes_xy=checked_floats(self.echoes_xy, name="echoes_xy", shape=(None, 2)))

    @property
    def bounds_xy(self) -> FloatArray:
        """Lower left and upper right corner of all but the echoes [m], shape (2, 2); a metre at least each way."""
        points = np.concatenate([self._mapped_xy, self._true_xy])
        points = points if len(points) else self.echoes_xy
        low, high = (points.min(axis=0), points.max(axis=0)) if len(points) else (np.zeros(2), np.ones(2))
        short = np.maximum(1.0 - (high - low), 0.0) / 2
        return np.stack([low - short, high + short])

    @property
    def thickness(self) -> float:
        """How thick to draw walls [m]."""
        return _THICKNESS * float(np.ptp(self.bounds_xy, axis=0).max())

    @property
    def ellipses(self) -> list[Ellipse]:
        """Where the corners, and then the axes of the cylinders, lie with 95 % probability."""
        return [
            *(error_ellipse(each.position_xy, each.covariance) for each in self.feature_map.corners),
            *(error_ellipse(each.center_xy, each.covariance[:2, :2]) for each in self.feature_map.cylinders),
        ]

    @property
    def pose_ellipses(self) -> list[Ellipse]:
        """Where the robot stood with 95 % probability; empty where poses were not corrected."""
        found = self.feature_map
        known = zip(found.poses, found.pose_covariances, strict=False)
        return [error_ellipse(pose[:2], covariance[:2, :2]) for pose, covariance in known]

    @property
    def magnification(self) -> int:
        """How many times to enlarge the ellipses: good ones are millimetres in a room of metres."""
        longest = 2 * max((float(each.semi_axes[0]) for each in self.ellipses), default=0.0)
        room = _LONGEST * float(np.ptp(self.bounds_xy, axis=0).max())
        return next((times for times in (10, 5, 2) if times * longest <= room), 1)

    @property
    def _mapped_xy(self) -> FloatArray:
        found = self.feature_map
        circles = np.array([[*each.center_xy, each.radius] for each in found.cylinders]).reshape(-1, 3)
        return np.concatenate(
            [
                found.poses[:, :2],
                *(wall.endpoints_xy for wall in found.walls),
                *(opening.endpoints_xy for opening in found.openings),
                *(stretch.endpoints_xy for stretch in found.unobserved),
                *(corner.position_xy[None] for corner in found.corners),
                circles[:, :2] - circles[:, 2:],
                circles[:, :2] + circles[:, 2:],
            ]
        )

    @property
    def _true_xy(self) -> FloatArray:
        if self.truth is None:
            return np.zeros((0, 2))
        circles = self.truth.cylinders
        return np.concatenate(
            [self.truth.walls_xy.reshape(-1, 2), circles[:, :2] - circles[:, 2:], circles[:, :2] + circles[:, 2:]]
        )


def station_labels(sweeps: IntArray, places_xy: FloatArray) -> list[str]:
    """Name stations: A, B, C and so on, as the paper does, or some by the number of their sweep if there are many.

    Parameters
    ----------
    sweeps : ndarray of int, shape (s,)
        Numbers of the sweeps.
    places_xy : ndarray, shape (s, 2)
        Where they were made [m].

    Returns
    -------
    list of str
        One a station; empty for those that would cover another one.

    Examples
    --------
    >>> station_labels(np.array([0, 1, 2]), np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 0.001]]))
    ['A', 'B', '']
    """
    if not len(sweeps):
        return []
    names = string.ascii_uppercase if len(sweeps) <= MOST_LABELS else list(map(str, sweeps.tolist()))
    apart = _CHARACTER * max(map(len, names)) * float(np.ptp(places_xy, axis=0).max())
    named = list[int]()
    for number in range(0, len(sweeps), -(-len(sweeps) // MOST_LABELS)):
        if np.hypot(*(places_xy[named] - places_xy[number]).T).min(initial=np.inf) >= apart:
            named.append(number)
    return [names[number] if number in named else "" for number in range(len(sweeps))]
