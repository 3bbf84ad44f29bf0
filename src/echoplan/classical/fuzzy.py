"""The fuzzy model of Section 4: from the width of a cluster and its covering to the class of the object.

The printed Eq. 14-17 contradict each other; the one reading in which they hold together is used here, and
docs/paper.md proves it.
"""

from enum import IntEnum
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from echoplan.arrays import FloatArray
from echoplan.classical.covering import Covering
from echoplan.model import FeatureClass
from echoplan.settings import Settings

__all__ = [
    "BIG",
    "CORRECTIONS",
    "CROSSINGS",
    "MEDIUM",
    "SMALL",
    "FuzzySettings",
    "RangeState",
    "class_of",
    "corrected_memberships",
    "memberships",
]

# Eq. 13, as shares of the greatest width.
SMALL, MEDIUM, BIG = 0.15, 0.55, 0.90

# Eq. 17: the widths at which small meets medium, and medium meets big.
CROSSINGS = (
    (BIG * MEDIUM - SMALL**2) / (BIG + MEDIUM - 2 * SMALL),
    (BIG**2 - SMALL * MEDIUM) / (2 * BIG - SMALL - MEDIUM),
)


class RangeState(IntEnum):
    """Linguistic value of the width of a cluster (Table 1), and so the class that it supports (Table 3)."""

    SMALL = 0
    MEDIUM = 1
    BIG = 2


# Table 4: [range state, covering, membership], what is added to the memberships of small, medium, big.
CORRECTIONS = np.array(
    [
        [[0.0, 0.0, 0.0], [-0.25, 0.25, 0.0], [-0.25, 0.25, 0.0], [-0.30, 0.0, 0.30]],
        [[0.0, 0.0, 0.0], [0.0, -0.20, 0.20], [0.0, -0.20, 0.20], [0.0, -0.30, 0.30]],
        [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]],
    ]
)
CORRECTIONS.setflags(write=False)

# Holds every kink of the memberships, which are linear between them: roots by interpolation are exact.
_GRID = np.linspace(0.0, 1.0, 2001)

_CLASSES = (FeatureClass.CORNER, FeatureClass.CYLINDER, FeatureClass.WALL)


class FuzzySettings(Settings):
    """Settings of the fuzzy classifier."""

    rules: Literal["paper", "monotone"] = Field(
        default="paper",
        description="Table 4 as printed (paper), or corrected so that a wider cluster never has a lower class "
        "(monotone).",
    )
    max_width: float | None = Field(
        default=None,
        gt=0.0,
        description="L_max of Eq. 12 [rad]; measured from the recording if it is missing.",
    )


def memberships(widths: ArrayLike) -> FloatArray:
    """Membership of widths in small, medium and big (Eq. 14-16).

    Parameters
    ----------
    widths : array_like, shape (...)
        Width of clusters as a share of the greatest; clipped to [0, 1].

    Returns
    -------
    ndarray, shape (..., 3)
        Memberships in [0, 1].

    Examples
    --------
    >>> memberships(0.55).round(3)
    array([0.467, 1.   , 0.533])
    """
    u = np.clip(np.asarray(widths, dtype=np.float64), 0.0, 1.0)
    small = np.clip((BIG - u) / (BIG - SMALL), 0.0, 1.0)
    medium = np.clip(np.minimum((u - SMALL) / (MEDIUM - SMALL), (BIG - u) / (BIG - MEDIUM)), 0.0, 1.0)
    big = np.clip((u - SMALL) / (BIG - SMALL), 0.0, 1.0)
    return np.stack([small, medium, big], axis=-1)


def corrected_memberships(width: float, covering: Covering, *, rules: str = "paper") -> FloatArray:
    """Memberships after the rules of Table 4.

    Parameters
    ----------
    width : float
        Width of a cluster as a share of the greatest.
    covering : Covering
        Its boundary state.
    rules : {"paper", "monotone"}, optional
        Table 4 to the letter, or its monotone reading.

    Returns
    -------
    ndarray, shape (3,)
        Memberships of small, medium, big; the paper's corrections may leave [0, 1].

    Examples
    --------
    >>> corrected_memberships(0.2, Covering.LEFT).round(3)
    array([0.683, 0.375, 0.067])
    """
    if rules == "monotone":
        return memberships(_monotone_width(width, covering))
    degrees = memberships(width)
    corrected: FloatArray = degrees + CORRECTIONS[_largest(degrees), covering]
    return corrected


def class_of(degrees: FloatArray) -> FeatureClass:
    """Defuzzify: the class of the largest membership (Section 4.3.2, Table 3).

    Parameters
    ----------
    degrees : ndarray, shape (3,)
        Memberships of small, medium, big.

    Returns
    -------
    FeatureClass
        Corner, cylinder or wall; ties go to the larger class value.

    Examples
    --------
    >>> class_of(np.array([0.2, 0.6, 0.6]))
    <FeatureClass.WALL: 'wall'>
    """
    return _CLASSES[_largest(degrees)]


def _largest(degrees: FloatArray) -> RangeState:
    return RangeState(2 - int(np.argmax(degrees[::-1])))


def _monotone_width(width: float, covering: Covering) -> float:
    """Width that an uncovered cluster of the same class would have.

    Table 4 corrects by the range state, so the correction jumps where the state changes, and a covered cluster can
    fall from cylinder back to corner as it gets wider.  Read monotonically, each correction moves the border that
    lies above its state: the corner's border is where small, corrected, stops being the largest, the flat's where
    medium, corrected, stops exceeding big.  Between these borders the width is stretched.
    """
    corner, flat = _borders(covering)
    return float(np.interp(width, [0.0, corner, max(flat, corner + 1e-9), 1.0], [0.0, *CROSSINGS, 1.0]))


def _borders(covering: Covering) -> tuple[float, float]:
    """Widths at which a covered cluster stops being a corner, and stops being less than a flat."""
    small = memberships(_GRID) + CORRECTIONS[RangeState.SMALL, covering]
    medium = memberships(_GRID) + CORRECTIONS[RangeState.MEDIUM, covering]
    corner = _last_root(small[:, 0] - small[:, 1:].max(axis=1))
    flat = _last_root(medium[:, 1] - medium[:, 2])
    return corner, max(flat, corner)


def _last_root(values: FloatArray) -> float:
    """Last width at which a function on the grid falls through zero; 0 where it is never positive."""
    positive = np.flatnonzero(values > 0)
    if not positive.size:
        return 0.0
    last = int(positive[-1])
    share = values[last] / (values[last] - values[last + 1])
    return float(_GRID[last] + share * (_GRID[last + 1] - _GRID[last]))
