"""How much of the drawn wall length is true, and how much of the true wall length is drawn."""

from dataclasses import dataclass
from math import nan

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.evaluation.outlines import Outline, OutlineSettings
from echoplan.geometry import crosses_segments
from echoplan.model import FeatureMap, Truth

__all__ = ["WallLengths", "measure_lengths"]


@dataclass(frozen=True, slots=True, kw_only=True)
class WallLengths:
    """Lengths of walls, apart from any matching of objects; those of several maps add up.

    Parameters
    ----------
    drawn, correct : float, optional
        Length of the drawn walls, and how much of it lies close to a true wall [m].
    wanted, covered : float, optional
        Length of the true walls that count for recall, and how much of it lies close to a drawn wall [m].
    walked_through : int, optional
        Drawn walls that the true path crosses, straight from pose to pose; 0 where the truth has no poses.

    Examples
    --------
    >>> both = WallLengths(drawn=4.0, correct=3.0) + WallLengths(drawn=1.0, correct=1.0)
    >>> both.precision
    0.8
    """

    drawn: float = 0.0
    correct: float = 0.0
    wanted: float = 0.0
    covered: float = 0.0
    walked_through: int = 0

    def __add__(self, other: "WallLengths") -> "WallLengths":
        return WallLengths(
            drawn=self.drawn + other.drawn,
            correct=self.correct + other.correct,
            wanted=self.wanted + other.wanted,
            covered=self.covered + other.covered,
            walked_through=self.walked_through + other.walked_through,
        )

    @property
    def recall(self) -> float:
        """Share of the wanted length that is drawn; nan if none is wanted."""
        return self.covered / self.wanted if self.wanted else nan

    @property
    def precision(self) -> float:
        """Share of the drawn length that is true; nan if nothing is drawn."""
        return self.correct / self.drawn if self.drawn else nan


def measure_lengths(
    feature_map: FeatureMap, truth: Truth, *, min_stations: int, settings: OutlineSettings
) -> WallLengths:
    """Compare the walls of a map with the true walls, stretch by stretch.

    Parameters
    ----------
    feature_map : FeatureMap
        The map.
    truth : Truth
        The true walls and poses.
    min_stations : int
        True walls that fewer stations can detect do not count for recall.
    settings : OutlineSettings
        How densely to sample, and how close is close enough.

    Returns
    -------
    WallLengths
        Of this map.
    """
    drawn = np.reshape([wall.endpoints_xy for wall in feature_map.walls], (-1, 2, 2))
    wanted = truth.walls_xy[truth.walls_detected_by >= min_stations]
    path = truth.poses[:, :2]
    return WallLengths(
        drawn=float(_lengths(drawn).sum()),
        correct=_length_near(drawn, truth.walls_xy, settings),
        wanted=float(_lengths(wanted).sum()),
        covered=_length_near(wanted, drawn, settings),
        walked_through=int(crosses_segments(path[:-1], path[1:], drawn).any(axis=0).sum()),
    )


def _lengths(walls: FloatArray) -> FloatArray:
    lengths: FloatArray = np.hypot(*(walls[:, 1] - walls[:, 0]).T)
    return lengths


def _length_near(walls: FloatArray, others: FloatArray, settings: OutlineSettings) -> float:
    """Length of walls that lies close to other walls [m]."""
    other = Outline(segments_xy=others, circles=np.zeros((0, 3)))
    near = 0.0
    for wall, length in zip(walls, _lengths(walls), strict=True):
        samples = Outline(segments_xy=wall[None], circles=np.zeros((0, 3))).samples(settings.spacing)
        near += float(length * np.mean(other.distances(samples) <= settings.tolerance))
    return near
