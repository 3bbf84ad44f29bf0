"""How far the outlines of two maps lie apart (Barshan 2008), apart from any matching of objects."""

from dataclasses import dataclass
from math import ceil, nan, pi

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray, checked_floats, store
from echoplan.geometry import directions, distances_to_segments
from echoplan.model import FeatureMap, Truth
from echoplan.settings import Settings

__all__ = ["DirectedError", "MapError", "Outline", "OutlineSettings", "compare_outlines"]

# Points that are compared with an outline at once: a whole building would fill the memory.
_BLOCK = 4096
# At the default spacing a kilometre of walls, more than a large building has; longer outlines are sampled less densely.
_SAMPLES_AT_MOST = 100_000


class OutlineSettings(Settings):
    """How outlines are compared."""

    spacing: float = Field(
        default=0.01,
        gt=0,
        description="Largest distance between two samples of an outline [m]: the centimetre of an HC-SR04.",
    )
    tolerance: float = Field(
        default=0.05, gt=0, description="Largest distance between an estimated and a true piece of wall that agree [m]."
    )


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Outline:
    """The faces of a map: segments and circles.

    Parameters
    ----------
    segments_xy : ndarray, shape (m, 2, 2)
        Walls: item, start or end, x or y [m].
    circles : ndarray, shape (k, 3)
        Cylinders: x, y, radius [m].
    """

    segments_xy: FloatArray
    circles: FloatArray

    def __post_init__(self) -> None:
        store(
            self,
            segments_xy=checked_floats(self.segments_xy, name="segments_xy", shape=(None, 2, 2)),
            circles=checked_floats(self.circles, name="circles", shape=(None, 3)),
        )

    @property
    def length(self) -> float:
        """Length of all segments and circles [m]."""
        spans = self.segments_xy[:, 1] - self.segments_xy[:, 0]
        return float(np.hypot(*spans.T).sum() + 2 * pi * self.circles[:, 2].sum())

    def samples(self, spacing: float) -> FloatArray:
        """Take points at even distances; each stands for an equal stretch of its segment or circle.

        Parameters
        ----------
        spacing : float
            Greatest distance between neighbours along the outline [m]; where that makes more than 100 000 points,
            the distance that makes so many.

        Returns
        -------
        ndarray, shape (n, 2)
            The points [m].

        Examples
        --------
        >>> Outline(segments_xy=[[[0, 1], [1, 1]]], circles=np.zeros((0, 3))).samples(0.5)
        array([[0.25, 1.  ],
               [0.75, 1.  ]])
        """
        spacing = max(spacing, self.length / _SAMPLES_AT_MOST)
        walls = [start + _middles(np.hypot(*(end - start)), spacing) * (end - start) for start, end in self.segments_xy]
        rounds = [
            circle[:2] + circle[2] * directions(2 * pi * _middles(2 * pi * circle[2], spacing)[:, 0])
            for circle in self.circles
        ]
        return np.concatenate([np.zeros((0, 2)), *walls, *rounds])

    def distances(self, points_xy: FloatArray) -> FloatArray:
        """Distance of points from the nearest point of the outline.

        Parameters
        ----------
        points_xy : ndarray, shape (n, 2)
            Points [m].

        Returns
        -------
        ndarray, shape (n,)
            Distances [m]; inf from an empty outline.
        """
        blocks = np.array_split(points_xy, max(ceil(len(points_xy) / _BLOCK), 1))
        return np.concatenate([self._distances(block) for block in blocks])

    def _distances(self, points_xy: FloatArray) -> FloatArray:
        from_walls = distances_to_segments(points_xy, self.segments_xy)
        offsets = points_xy[:, None] - self.circles[None, :, :2]
        from_rounds = np.abs(np.hypot(offsets[..., 0], offsets[..., 1]) - self.circles[:, 2])
        nearest: FloatArray = np.concatenate([from_walls, from_rounds], axis=1).min(axis=1, initial=np.inf)
        return nearest


@dataclass(frozen=True, slots=True, kw_only=True)
class DirectedError:
    """How far the points of one outline lie from the other outline; nan if one of them is empty.

    Parameters
    ----------
    mean, median, maximum : float, optional
        Of the distances [m].
    """

    mean: float = nan
    median: float = nan
    maximum: float = nan


@dataclass(frozen=True, slots=True, kw_only=True)
class MapError:
    """How far a map and the truth lie apart.

    Parameters
    ----------
    map_to_truth : DirectedError
        How far what the map shows is from anything true.
    truth_to_map : DirectedError
        How far what the stations can detect is from anything that the map shows.
    """

    map_to_truth: DirectedError
    truth_to_map: DirectedError

    @property
    def mean(self) -> float:
        """Symmetric mean of the nearest-point distances, the criterion of Barshan (2008) [m]."""
        return (self.map_to_truth.mean + self.truth_to_map.mean) / 2

    @property
    def median(self) -> float:
        """Mean of the two medians [m]."""
        return (self.map_to_truth.median + self.truth_to_map.median) / 2

    @property
    def hausdorff(self) -> float:
        """Hausdorff distance: the greatest of all [m], short of it by half a spacing at most."""
        return float(np.maximum(self.map_to_truth.maximum, self.truth_to_map.maximum))


def compare_outlines(
    feature_map: FeatureMap, truth: Truth, *, min_stations: int, settings: OutlineSettings
) -> MapError:
    """Measure how far a map and the truth lie apart.

    One outline is sampled and the distance taken from the other outline itself: what Barshan's criterion between
    point sets tends to when the second set becomes dense.

    Parameters
    ----------
    feature_map : FeatureMap
        The estimates; walls and cylinders have outlines, corners are the ends of walls.
    truth : Truth
        The true objects.
    min_stations : int
        The map need not show what fewer stations can detect.
    settings : OutlineSettings
        How densely to sample.

    Returns
    -------
    MapError
        Both directions; nan where the map or the truth is empty.
    """
    estimated = Outline(
        segments_xy=np.reshape([wall.endpoints_xy for wall in feature_map.walls], (-1, 2, 2)),
        circles=np.reshape([[*each.center_xy, each.radius] for each in feature_map.cylinders], (-1, 3)),
    )
    true = Outline(segments_xy=truth.walls_xy, circles=truth.cylinders)
    audible = Outline(
        segments_xy=truth.walls_xy[truth.walls_detected_by >= min_stations],
        circles=truth.cylinders[truth.cylinders_detected_by >= min_stations],
    )
    return MapError(
        map_to_truth=_directed(estimated, true, spacing=settings.spacing),
        truth_to_map=_directed(audible, estimated, spacing=settings.spacing),
    )


def _middles(length: float, spacing: float) -> FloatArray:
    """Middles of the even parts of a unit length, as a column."""
    count = max(ceil(length / spacing), 1)
    return ((np.arange(count) + 0.5) / count)[:, None]


def _directed(outline: Outline, other: Outline, *, spacing: float) -> DirectedError:
    distances = other.distances(outline.samples(spacing))
    if not len(distances) or not np.isfinite(distances).all():
        return DirectedError()
    return DirectedError(
        mean=float(distances.mean()), median=float(np.median(distances)), maximum=float(distances.max())
    )
