"""One battery for all of geometry: none, one or many items, leading axes first."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.geometry import (
    along,
    compose,
    crosses_discs,
    crosses_segments,
    directions,
    distances_to_segments,
    feet,
    intersections,
    invert,
    is_blocked,
    lines_through,
    signed_distances,
    transform_points,
    wrap,
)

# Each function, the shapes of one item of its arguments, and that of one result.
ITEM_BY_ITEM: list[tuple[Callable[..., FloatArray], list[tuple[int, ...]], tuple[int, ...]]] = [
    (wrap, [()], ()),
    (directions, [()], (2,)),
    (lines_through, [(2,), (2,)], (2,)),
    (signed_distances, [(2,), (2,)], ()),
    (along, [(2,), (2,)], ()),
    (feet, [(2,), (2,)], (2,)),
    (intersections, [(2,), (2,)], (2,)),
    (compose, [(3,), (3,)], (3,)),
    (invert, [(3,)], (3,)),
    (transform_points, [(3,), (2,)], (2,)),
]
NAMES = [function.__name__ for function, _, _ in ITEM_BY_ITEM]


def arguments(shapes: list[tuple[int, ...]], leading: tuple[int, ...]) -> list[FloatArray]:
    rng = np.random.default_rng(0)
    return [rng.uniform(-3, 3, size=(*leading, *shape)) for shape in shapes]


@pytest.mark.parametrize(("function", "shapes", "result"), ITEM_BY_ITEM, ids=NAMES)
@pytest.mark.parametrize("leading", [(), (0,), (5,), (2, 3)], ids=str)
def test_leading_axes_are_items(
    function: Any, shapes: list[tuple[int, ...]], result: tuple[int, ...], leading: tuple[int, ...]
) -> None:
    assert np.shape(function(*arguments(shapes, leading))) == (*leading, *result)


@pytest.mark.parametrize(("function", "shapes", "result"), ITEM_BY_ITEM, ids=NAMES)
def test_many_items_at_once_are_as_one_by_one(
    function: Any, shapes: list[tuple[int, ...]], result: tuple[int, ...]
) -> None:
    many = arguments(shapes, (7,))
    singly = [function(*items) for items in zip(*many, strict=True)]
    assert function(*many) == pytest.approx(np.array(singly), abs=1e-12)


@pytest.mark.parametrize(("function", "shapes", "result"), ITEM_BY_ITEM, ids=NAMES)
def test_lists_are_as_good_as_arrays_and_nothing_is_written_into(
    function: Any, shapes: list[tuple[int, ...]], result: tuple[int, ...]
) -> None:
    given = arguments(shapes, (4,))
    for array in given:
        array.setflags(write=False)
    assert np.array_equal(function(*(array.tolist() for array in given)), function(*given), equal_nan=True)


@pytest.mark.parametrize("lines", [0, 1, 3])
@pytest.mark.parametrize("items", [0, 1, 4])
def test_every_sight_line_meets_every_item(lines: int, items: int) -> None:
    eyes, targets = np.zeros((lines, 2)), np.ones((lines, 2))
    assert crosses_segments(eyes, targets, np.zeros((items, 2, 2))).shape == (lines, items)
    assert crosses_discs(eyes, targets, np.ones((items, 3))).shape == (lines, items)
    assert distances_to_segments(eyes, np.zeros((items, 2, 2))).shape == (lines, items)
    blocked = is_blocked(eyes, targets, segments_xy=np.zeros((items, 2, 2)), discs=np.ones((items, 3)))
    assert blocked.shape == (lines,)
