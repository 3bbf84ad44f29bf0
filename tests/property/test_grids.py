"""Laws of grids: they move and turn with what made them, and some care for no order."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from echoplan.arrays import FloatArray, IntArray
from echoplan.classical.grids import (
    BayesRule,
    BayesSettings,
    CemalRule,
    CemalSettings,
    Cones,
    ElfesRule,
    ElfesSettings,
    GridRule,
    MurielRule,
    MurielSettings,
    RangeLayerRule,
    RangeLayerSettings,
    chosen_cones,
)
from echoplan.model import OccupancyGrid
from helpers import cells

RULES: dict[str, Callable[[], GridRule]] = {
    "bayes": lambda: BayesRule(BayesSettings(thickness=0.2, clear_without_echo=True), cells.COARSE),
    "elfes": lambda: ElfesRule(ElfesSettings(range_error=0.15), cells.COARSE),
    "muriel": lambda: MurielRule(MurielSettings(place=0.2), cells.COARSE),
    "cemal": lambda: CemalRule(CemalSettings(thickness=0.2), cells.COARSE),
    "range layer": lambda: RangeLayerRule(RangeLayerSettings(clear_on_max_reading=True), cells.COARSE),
}
# Its whole numbers turn the rounding of the last digit into a step of a cost.
EXACT = {name: make for name, make in RULES.items() if name != "range layer"}
UNORDERED = {name: RULES[name] for name in ("bayes", "muriel")}
seeds = st.integers(0, 2**32 - 1)
fewer = settings(max_examples=15)


def drawn(make: Callable[[], GridRule], cones: Cones) -> GridRule:
    rule = make()
    rule.add(cones)
    return rule


def values_at(rule: GridRule, points_xy: FloatArray) -> FloatArray:
    """What is drawn at points; 1/2 beyond the grid."""
    grid = rule.grid
    inside = grid.contains(points_xy)
    rows, columns = np.where(inside[..., None], grid.cells_of(points_xy), 0).T
    return np.where(inside, grid.values[rows, columns], 0.5)


def centers_about(rule: GridRule) -> FloatArray:
    return rule.grid.centers_xy.reshape(-1, 2)


def turned(cones: Cones) -> Cones:
    """The same cones after a quarter turn about the origin."""
    return cones._replace(x=-cones.y, y=cones.x, ux=-cones.uy, uy=cones.ux, hub_x=-cones.hub_y, hub_y=cones.hub_x)


def moved(cones: Cones, steps: IntArray) -> Cones:
    """The same cones after so many cells to the right and up."""
    x, y = cells.COARSE.resolution * steps
    return cones._replace(x=cones.x + x, y=cones.y + y, hub_x=cones.hub_x + x, hub_y=cones.hub_y + y)


def off_the_lattice(seed: int, count: int = 15) -> Cones:
    """Cones whose turrets stand within their places, not on a border."""
    cones = cells.random_cones(np.random.default_rng(seed), count=count)
    return cones._replace(hub_x=cones.hub_x + 0.03, hub_y=cones.hub_y + 0.03)


@pytest.mark.parametrize("name", EXACT)
@given(seed=seeds)
@fewer
def test_a_grid_turns_with_what_made_it(name: str, seed: int) -> None:
    # Places are squares of the lattice: they turn only into each other.
    cones = off_the_lattice(seed)
    one, other = drawn(RULES[name], cones), drawn(RULES[name], turned(cones))
    centers = centers_about(one)
    np.testing.assert_allclose(values_at(other, centers[:, ::-1] * [-1.0, 1.0]), values_at(one, centers), atol=1e-6)


@pytest.mark.parametrize("name", EXACT)
@given(seed=seeds, steps=st.tuples(st.integers(-100, 100), st.integers(-100, 100)))
@fewer
def test_a_grid_moves_with_what_made_it_by_whole_places(name: str, seed: int, steps: tuple[int, int]) -> None:
    cones, way = off_the_lattice(seed), 2 * np.array(steps)
    one, other = drawn(RULES[name], cones), drawn(RULES[name], moved(cones, way))
    centers = centers_about(one)
    there = values_at(other, centers + cells.COARSE.resolution * way)
    np.testing.assert_allclose(there, values_at(one, centers), atol=1e-6)


@pytest.mark.parametrize("name", UNORDERED)
@given(seed=seeds)
@fewer
def test_the_order_of_pings_does_not_matter(name: str, seed: int) -> None:
    cones = off_the_lattice(seed)
    order = np.random.default_rng(seed).permutation(len(cones.x))
    one, other = drawn(RULES[name], cones), drawn(RULES[name], chosen_cones(cones, order))
    np.testing.assert_allclose(one.grid.values, other.grid.values, atol=1e-9)


@pytest.mark.parametrize("name", RULES)
@given(seed=seeds)
@fewer
def test_nothing_is_learnt_of_cells_that_no_cone_touches(name: str, seed: int) -> None:
    cones = off_the_lattice(seed, count=4)
    rule = drawn(RULES[name], cones)
    centers = centers_about(rule)
    away = np.hypot(centers[:, None, 0] - cones.x, centers[:, None, 1] - cones.y)
    # A rectangle about a cone is at most this much longer than its reading.
    depths = 1.2 * np.sqrt(2.0) * np.minimum(cones.readings, cones.reaches) + 0.4
    far = (away > depths).all(axis=1)
    assert (values_at(rule, centers[far]) == 0.5).all()


@pytest.mark.parametrize("name", RULES)
@given(seed=seeds)
@fewer
def test_every_value_stays_a_probability_after_many_equal_pings(name: str, seed: int) -> None:
    rule = RULES[name]()
    for _ in range(100):
        rule.add(off_the_lattice(seed, count=2))
    assert rule.grid.values.min() >= 0.0
    assert rule.grid.values.max() <= 1.0


@given(
    x=st.floats(-50.0, 50.0),
    y=st.floats(-50.0, 50.0),
    resolution=st.floats(0.01, 2.0),
    shape=st.tuples(st.integers(1, 9), st.integers(1, 9)),
)
def test_every_centre_lies_in_its_own_cell_and_on_the_grid(
    x: float, y: float, resolution: float, shape: tuple[int, int]
) -> None:
    grid = OccupancyGrid(origin_xy=np.array([x, y]), resolution=resolution, values=np.full(shape, 0.5))
    assert np.array_equal(grid.cells_of(grid.centers_xy), np.moveaxis(np.indices(shape), 0, -1))
    assert grid.contains(grid.centers_xy).all()
    outside = [grid.origin_xy - 0.5 * resolution, grid.origin_xy + grid.size_xy + 0.5 * resolution]
    assert not grid.contains(outside).any()
