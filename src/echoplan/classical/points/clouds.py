"""Clouds: points with weights, and what they have in common."""

from dataclasses import dataclass

import numpy as np

from echoplan.arrays import BoolArray, FloatArray, IntArray, checked_floats, chosen_items, store
from echoplan.errors import InvalidValueError

__all__ = ["Cloud"]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Cloud:
    """Points that count for more or less.

    Parameters
    ----------
    points_xy : ndarray, shape (n, 2)
        The points [m].
    weights : ndarray, shape (n,)
        How much each counts, in points.

    Raises
    ------
    InvalidValueError
        If lengths differ, a number is not finite or a weight is not positive.
    """

    points_xy: FloatArray
    weights: FloatArray

    def __post_init__(self) -> None:
        weights = checked_floats(self.weights, name="weights", shape=(None,))
        if (weights <= 0).any():
            raise InvalidValueError(f"weights must be positive, not {weights.min():g}")
        store(
            self, weights=weights, points_xy=checked_floats(self.points_xy, name="points_xy", shape=(len(weights), 2))
        )

    def __len__(self) -> int:
        return len(self.weights)

    def __getitem__(self, chosen: BoolArray | IntArray) -> "Cloud":
        """Return some of the points: a mask or indices."""
        return chosen_items(self, chosen)

    @property
    def weight(self) -> float:
        """Sum of all weights [points]."""
        return float(self.weights.sum())

    @property
    def centroid_xy(self) -> FloatArray:
        """Weighted mean of the points [m], shape (2,)."""
        centroid: FloatArray = self.weights @ self.points_xy / self.weights.sum()
        return centroid

    def information(self, coordinates: FloatArray, *, spacing: float) -> FloatArray:
        """Return the effective number of independent points that each point counts as.

        Neighbouring points come from the same echoes and share their errors: all points within one stretch of
        ``spacing`` count as one.

        Parameters
        ----------
        coordinates : ndarray, shape (n,)
            Place of each point along a curve [m].
        spacing : float
            Length within which points share their errors [m].

        Returns
        -------
        ndarray, shape (n,)
            The shares; they sum to the number of stretches that hold a point, or to the weight if that is less.
        """
        stretches = len(np.unique(np.floor(coordinates / spacing)))
        weights: FloatArray = self.weights * (min(stretches, self.weight) / self.weight)
        return weights
