"""A tree of boxes around faces, which finds the few of many faces that a straight way can meet."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from echoplan.arrays import FloatArray, IntArray

__all__ = ["MARGIN", "Tree", "build_tree"]

# Boxes are larger than their faces by this, so that neither rounding nor the ties of the ray tracer matter [m].
MARGIN = 1e-6
# To look into a box takes as long as to look at about four faces.
_FACES_IN_A_LEAF = 4

_BOX = np.dtype([("center", "c16"), ("half", "c16"), ("skip", "i8"), ("first", "i8"), ("last", "i8")])


class Tree(NamedTuple):
    """Boxes in preorder: a box comes before those within it.

    Attributes
    ----------
    boxes : ndarray of records, shape (n,)
        Center and half size [m], x + jy; the next box for a way that does not meet this one; and, if there are no
        boxes within it, the range of its faces in ``order``.
    order : ndarray of int, shape (m,)
        Faces.
    """

    boxes: NDArray[np.void]
    order: IntArray


def build_tree(segments_xy: FloatArray) -> Tree:
    """Halve faces along the longer side of their box, again and again."""
    lows, highs = segments_xy.min(axis=1), segments_xy.max(axis=1)
    order, boxes = np.arange(len(segments_xy)), list[tuple[complex, complex, int, int, int]]()

    def grow(first: int, last: int) -> None:
        """Append the box of a range of faces in ``order``, and of its halves in turn."""
        place, faces = len(boxes), order[first:last]
        low, high = lows[faces].min(axis=0), highs[faces].max(axis=0)
        center, half = complex(*(low + high)) / 2, complex(*(high - low)) / 2 + complex(MARGIN, MARGIN)
        boxes.append((center, half, place + 1, first, last))
        if last - first > _FACES_IN_A_LEAF:
            middles = (lows + highs)[faces, int(half.imag > half.real)]
            size = (last - first) // 2
            order[first:last] = faces[np.argpartition(middles, size)]
            grow(first, first + size)
            grow(first + size, last)
            boxes[place] = (center, half, len(boxes), 0, 0)

    if len(order):
        grow(0, len(order))
    return Tree(boxes=np.array(boxes, dtype=_BOX), order=order)
