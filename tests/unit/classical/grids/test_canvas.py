import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.classical.grids import Canvas, CanvasSettings
from echoplan.errors import InvalidValueError

SETTINGS = CanvasSettings(resolution=0.1, max_cells=20_000)


def box(low: float, high: float) -> FloatArray:
    return np.array([[low, low], [high, high]])


def test_a_canvas_begins_with_nothing_and_gives_one_unknown_cell() -> None:
    canvas = Canvas(SETTINGS)
    canvas.cover(box(np.inf, -np.inf))
    assert canvas.layers.shape == (1, 0, 0)
    assert canvas.grid(canvas.layers[0]).values.tolist() == [[0.5]]


def test_what_was_drawn_stays_where_it_is_when_the_canvas_grows() -> None:
    canvas = Canvas(SETTINGS, fills=(7.0, 0.25))
    canvas.cover(box(0.0, 1.0))
    row, column = canvas.grid(canvas.layers[1]).cells_of([0.55, 0.75])
    canvas.layers[:, row, column] = [1.0, 0.75]
    canvas.cover(box(-4.0, -3.9))
    grown = canvas.grid(canvas.layers[1])
    assert grown.origin_xy == pytest.approx([-6.4, -6.4])
    assert grown.values[tuple(grown.cells_of([0.55, 0.75]))] == 0.75
    assert sorted(set(canvas.layers[0].ravel())) == [1.0, 7.0]
    assert (grown.values == 0.25).sum() == grown.values.size - 1


def test_a_canvas_never_shrinks() -> None:
    canvas = Canvas(SETTINGS)
    canvas.cover(box(-4.0, 4.0))
    before = canvas.raster
    canvas.cover(box(0.0, 0.1))
    assert canvas.raster == before


def test_a_canvas_is_added_to_a_wider_one() -> None:
    wide, narrow = Canvas(SETTINGS), Canvas(SETTINGS)
    wide.cover(box(-4.0, 4.0))
    narrow.cover(box(0.1, 0.2))
    wide.add(narrow, np.full((32, 32), 3.0))
    assert wide.layers.sum() == 3.0 * 32 * 32
    row, column = wide.grid(wide.layers[0] / 3).cells_of([0.0001, 0.0001])
    assert wide.layers[0, row, column] == 3.0 > wide.layers[0, row - 1, column - 1]


@pytest.mark.parametrize("far", [100.0, 1e30])
def test_a_map_that_would_grow_too_large_is_refused_and_the_canvas_left_as_it_was(far: float) -> None:
    canvas = Canvas(SETTINGS)
    canvas.cover(box(0.0, 1.0))
    before = canvas.raster
    with pytest.raises(InvalidValueError, match=r"more cells than max_cells = 20000; check the poses or choose"):
        canvas.cover(box(0.0, far))
    assert canvas.raster == before


def test_a_place_so_far_away_that_cells_cannot_be_distinguished_is_refused() -> None:
    with pytest.raises(InvalidValueError, match=r"up to 1e\+30 m from the origin"):
        Canvas(SETTINGS).cover(box(1e30, 1e30))
