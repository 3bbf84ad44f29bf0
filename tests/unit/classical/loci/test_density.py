import numpy as np
import pytest

from echoplan.classical.loci import ArcMap, arc_map, directional_maxima
from helpers import arcs

POINT = (3.01, 1.01)
STATIONS = [(1.0, 1.0), (3.1, -0.8), (2.6, 2.8)]
STEP = 0.02


def test_the_densest_cell_is_where_arcs_cross() -> None:
    cells = arc_map(arcs.on_point(POINT, STATIONS), resolution=STEP)
    assert cells.counts.max() == 3
    assert cells.points_xy[cells.counts == 3] == pytest.approx(np.array([POINT]), abs=STEP)


def test_an_arc_counts_once_in_each_cell_and_leaves_no_gap() -> None:
    (radius,), half = np.hypot([2.01], [0.01]), arcs.HALF_APERTURE
    cells = arc_map(arcs.on_point(POINT, STATIONS[:1]), resolution=STEP)
    assert set(cells.counts.tolist()) == {1}
    columns = np.unique(np.floor(cells.points_xy[:, 1] / STEP))
    assert len(columns) == columns.max() - columns.min() + 1
    assert len(columns) == pytest.approx(2 * radius * np.sin(half) / STEP, abs=2)


def test_cells_lie_on_their_arc_on_either_side_of_the_axes() -> None:
    loci = arcs.on_point((-1.0, -1.0), [(0.3, 0.4)])
    cells = arc_map(loci, resolution=STEP)
    assert np.hypot(*(cells.points_xy - [0.3, 0.4]).T) == pytest.approx(loci.ranges[0], abs=STEP)


def test_arcs_are_thinned_to_the_densest_cell_on_each_line() -> None:
    # A ridge along x whose crest is the row y = 0.05: across it, only the crest survives.
    x, y = (0.01 + 0.02 * axis for axis in np.meshgrid(np.arange(10), np.arange(5)))
    ridge = ArcMap(
        points_xy=np.column_stack([x.ravel(), y.ravel()]), counts=np.repeat([1, 2, 5, 2, 1], 10).astype(np.int64)
    )
    leads = directional_maxima(ridge, count=2, resolution=STEP).reshape(5, 10)
    assert (leads[2] >= 1).all()
    assert leads.sum(axis=0)[1:].tolist() == [1] * 9
    assert leads[:, 0].tolist() == [1, 1, 2, 1, 1]


def test_each_direction_adds_its_own_maxima() -> None:
    cells = arc_map(arcs.on_point(POINT, STATIONS), resolution=STEP)
    few, many = (directional_maxima(cells, count=count, resolution=STEP) > 0 for count in (1, 8))
    assert many[few].all()
    assert many.sum() > few.sum()
    assert many.sum() < len(cells.counts)


def test_no_arcs_have_no_map() -> None:
    cells = arc_map(arcs.nothing(), resolution=STEP)
    assert cells.points_xy.shape == (0, 2)
    assert directional_maxima(cells, count=4, resolution=STEP).tolist() == []
