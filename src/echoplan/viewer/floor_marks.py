"""Dimensions and labels of floor plans, and how they find a free place on the paper; all lengths in millimetres."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, Protocol, TypeVar

import numpy as np

from echoplan.arrays import FloatArray, checked_floats, store
from echoplan.geometry import directions
from echoplan.viewer.outline import label_turn

if TYPE_CHECKING:
    from shapely import Polygon
    from shapely.geometry.base import BaseGeometry

__all__ = ["TEXT_SIZES", "Dimension", "Label", "place", "text_width"]

# Heights of letters [pt] by what they are about.
TEXT_SIZES = {"dimension": 7.0, "area": 9.0, "wall": 6.0, "opening": 6.0, "cylinder": 6.0}
# A point [mm]; digits and most letters of DejaVu Sans are at most 0.64 of the size wide, and capitals 0.73 high.
_POINT, _WIDE, _HIGH = 25.4 / 72.0, 0.64, 0.73
# Space around text, and between a dimension line and the text above it.
_AIR, _ABOVE = 0.5, 0.8


class _Mark(Protocol):
    @property
    def footprint(self) -> Polygon:
        """What the mark covers on paper [mm]."""
        ...


M = TypeVar("M", bound=_Mark)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Dimension:
    """A dimension line with its text above it.

    Parameters
    ----------
    ends : ndarray, shape (2, 2)
        Points between which it measures.
    line : ndarray, shape (2, 2)
        Ends of the dimension line, beside these.
    text : str
        Length as it is written.
    """

    ends: FloatArray
    line: FloatArray
    text: str

    def __post_init__(self) -> None:
        store(
            self,
            ends=checked_floats(self.ends, name="ends", shape=(2, 2)),
            line=checked_floats(self.line, name="line", shape=(2, 2)),
        )

    @property
    def turn(self) -> float:
        """Angle of the text [degrees]."""
        return label_turn(self.line)

    @property
    def text_place(self) -> FloatArray:
        """Middle of the lower edge of the text, shape (2,)."""
        place: FloatArray = self.line.mean(axis=0) + _ABOVE * directions(np.radians(self.turn + 90.0))
        return place

    @property
    def fits(self) -> bool:
        """Whether the line is longer than its text."""
        return float(np.hypot(*(self.line[1] - self.line[0]))) >= text_width(self.text, kind="dimension") + 1.0

    @property
    def footprint(self) -> Polygon:
        """The line and its text; less at its ends, where neighbours in a row meet."""
        from shapely import Polygon  # noqa: PLC0415 - a tenth of a second of import

        height = _ABOVE + _HIGH * _POINT * TEXT_SIZES["dimension"]
        up = directions(np.radians(self.turn + 90.0))
        way = self.line[1] - self.line[0]
        line = self.line + np.outer([_AIR, -_AIR], way / np.hypot(*way))
        low, high = line - _AIR * up, line[::-1] + (height + _AIR) * up
        return Polygon(np.concatenate([low, high]))


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Label:
    """A text in its place.

    Parameters
    ----------
    kind : str
        What it is about.
    text : str
        What it says.
    middle : ndarray, shape (2,)
        Its middle.
    turn : float, optional
        Its angle [degrees].
    """

    kind: Literal["area", "wall", "opening", "cylinder"]
    text: str
    middle: FloatArray
    turn: float = 0.0

    def __post_init__(self) -> None:
        store(self, middle=checked_floats(self.middle, name="middle", shape=(2,)))

    @property
    def half_size(self) -> FloatArray:
        """Half of its width and height with the space around, shape (2,); the number of a wall is in a circle.

        Circles of one and of two digits are alike.
        """
        width, height = text_width(self.text, kind=self.kind), _HIGH * _POINT * TEXT_SIZES[self.kind]
        half = np.array([width, height]) / 2 + _AIR
        return np.full(2, max(half.max(), text_width("00", kind="wall") / 2 + _AIR)) if self.kind == "wall" else half

    @property
    def footprint(self) -> Polygon:
        """The box around it."""
        from shapely import Polygon  # noqa: PLC0415 - as above

        x, y = directions(np.radians(self.turn + np.array([0.0, 90.0]))) * self.half_size[:, None]
        return Polygon(self.middle + np.stack([-x - y, x - y, x + y, y - x]))


def text_width(text: str, *, kind: str) -> float:
    """Width of a text of digits, at most."""
    return len(text) * _WIDE * _POINT * TEXT_SIZES[kind]


def place(
    wanted: Iterable[Iterable[M]], taken: Sequence[BaseGeometry], *, window: FloatArray
) -> tuple[list[M], list[BaseGeometry]]:
    """Place each mark at the first of its choices that is free and in the window, or not at all.

    Returns the marks that found a place, and all that is taken now.
    """
    import shapely  # noqa: PLC0415 - a tenth of a second of import

    placed, occupied = list[M](), list(taken)
    inside = shapely.box(*window.ravel())
    for choices in wanted:
        for choice in choices:
            footprint = choice.footprint
            if inside.covers(footprint) and not shapely.intersects(np.array(occupied, dtype=object), footprint).any():
                placed.append(choice)
                occupied.append(footprint)
                break
    return placed, occupied
