"""Errors of estimated lengths against the 95 % intervals that the map gives them."""

from dataclasses import dataclass, field
from math import nan

import numpy as np

from echoplan.arrays import FloatArray, checked_floats, store
from echoplan.model import HALF_OF_95

__all__ = ["IntervalErrors"]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class IntervalErrors:
    """Errors of n estimated lengths; those of several maps add up.

    Parameters
    ----------
    errors : ndarray, shape (n,), optional
        Estimated minus true [m].
    sigmas : ndarray, shape (n,), optional
        Standard deviations by the map [m]; nan where it gives none.

    Examples
    --------
    >>> widths = IntervalErrors(errors=[0.01, -0.03], sigmas=[0.01, 0.01])
    >>> round(widths.mean, 3), round(widths.bias, 3), widths.share_inside
    (0.02, -0.01, 0.5)
    """

    errors: FloatArray = field(default_factory=lambda: np.zeros(0))
    sigmas: FloatArray = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        errors = checked_floats(self.errors, name="errors", shape=(None,))
        sigmas = checked_floats(self.sigmas, name="sigmas", shape=(len(errors),), finite=False)
        store(self, errors=errors, sigmas=sigmas)

    def __add__(self, other: "IntervalErrors") -> "IntervalErrors":
        return IntervalErrors(
            errors=np.concatenate([self.errors, other.errors]), sigmas=np.concatenate([self.sigmas, other.sigmas])
        )

    @property
    def mean(self) -> float:
        """Mean error without sign [m]; nan without estimates."""
        return float(np.abs(self.errors).mean()) if len(self.errors) else nan

    @property
    def bias(self) -> float:
        """Mean error with sign [m]; nan without estimates."""
        return float(self.errors.mean()) if len(self.errors) else nan

    @property
    def share_inside(self) -> float:
        """Share of the true lengths inside their 95 % interval; nan where the map gives none."""
        known = np.isfinite(self.sigmas)
        inside = np.abs(self.errors[known]) <= HALF_OF_95 * self.sigmas[known]
        return float(inside.mean()) if len(inside) else nan
