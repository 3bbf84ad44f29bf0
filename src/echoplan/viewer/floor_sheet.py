"""Paper for floor plans: A4 or A3 at a standard scale, with room for dimensions and a title block; y up."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from echoplan.arrays import FloatArray, checked_floats, store
from echoplan.viewer.sheet import round_up

__all__ = ["MARGIN", "FloorSheet", "floor_sheet"]

# Width and height of paper (ISO 216) [mm].
_PAPERS = {
    "A4": ((210.0, 297.0), (297.0, 210.0)),
    "A3": ((420.0, 297.0), (297.0, 420.0)),
}
# Printers leave an edge of some millimetres [mm].
MARGIN = 10.0
# Two rows of dimension lines, 8 mm apart, around the walls [mm].
_DIMENSIONS = 22.0
# Recommended scales are 1:1, 1:2 and 1:5 times a power of ten (ISO 5455).  A room is drawn at 1:10 at most: larger
# drawings would suggest that sonar sees millimetres.
_DIGITS, _LARGEST = (1.0, 2.0, 5.0), 10.0
# Drawings of this scale or larger stay on A4: what fits on it at 1:50 needs no larger paper.
_GOOD = 50.0


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class FloorSheet:
    """Where a floor plan lies on paper; the unit is the millimetre, from the lower left corner.

    Parameters
    ----------
    bounds_xy : ndarray, shape (2, 2)
        Lower left and upper right corner of what is drawn [m].
    paper : str
        Name of the paper.
    size : ndarray, shape (2,)
        Its width and height [mm].
    scale : float
        How many times the room is larger than the drawing.
    foot : float
        Height of what stands below the drawing [mm].
    """

    bounds_xy: FloatArray
    paper: str
    size: FloatArray
    scale: float
    foot: float

    def __post_init__(self) -> None:
        store(
            self,
            bounds_xy=checked_floats(self.bounds_xy, name="bounds_xy", shape=(2, 2)),
            size=checked_floats(self.size, name="size", shape=(2,)),
        )

    @property
    def millimetres(self) -> float:
        """Length of a metre on paper [mm]."""
        return 1000.0 / self.scale

    @property
    def window(self) -> FloatArray:
        """Lower left and upper right corner of the part of the paper that is for the drawing [mm], shape (2, 2)."""
        return np.array([[MARGIN, MARGIN + self.foot], self.size - MARGIN])

    def on_paper(self, points_xy: ArrayLike) -> FloatArray:
        """Take points of the map, shape (..., 2) [m], to the paper [mm]: its middle lies in that of the window."""
        middle = self.bounds_xy.mean(axis=0)
        placed: FloatArray = self.window.mean(axis=0) + self.millimetres * (np.asarray(points_xy) - middle)
        return placed


def floor_sheet(bounds_xy: FloatArray, *, foot: float) -> FloorSheet:
    """Choose paper and scale for a drawing: the largest scale on A4, or on A3 where A4 would force one below 1:50."""
    sheets = list[FloorSheet]()
    for paper, sizes in _PAPERS.items():
        for size in np.array(sizes):
            free = size - 2 * (MARGIN + _DIMENSIONS) - [0.0, foot]
            fitting = round_up(float((1000.0 * np.ptp(bounds_xy, axis=0) / free).max()), _DIGITS)
            scale = max(fitting, _LARGEST)
            sheets.append(FloorSheet(bounds_xy=bounds_xy, paper=paper, size=size, foot=foot, scale=scale))
    # Wide drawings lie on wide paper where both have one scale.
    wide, high = np.ptp(bounds_xy, axis=0)
    sheets.sort(key=lambda each: (each.scale, (each.size[0] > each.size[1]) != (wide > high)))
    on_a4 = next(each for each in sheets if each.paper == "A4")
    return on_a4 if on_a4.scale <= _GOOD else sheets[0]
