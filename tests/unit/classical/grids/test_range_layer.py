import math

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.classical.grids import CanvasSettings, Cones, RangeLayerRule, RangeLayerSettings
from echoplan.classical.grids.range_layer import cost_after, sensor_model, weight_of
from helpers import cells

HALF_APERTURE = 0.6
HALF_WIDTH = 1.0


def rule(canvas: CanvasSettings = cells.COARSE, *, clear_on_max_reading: bool = False) -> RangeLayerRule:
    return RangeLayerRule(RangeLayerSettings(clear_on_max_reading=clear_on_max_reading), canvas)


def costs(cones: Cones, found: RangeLayerRule) -> FloatArray:
    """The layer's arithmetic on the whole grid at once, ping by ping."""
    raster = cells.raster_of(found.grid)
    layer = np.full((raster.rows, raster.columns), 127.0)
    rows, columns = np.indices(layer.shape)
    for ping, seen in enumerate(cells.seen(cones, raster)):
        if np.isinf(seen.reading):
            continue
        origin = np.array([cones.x[ping], cones.y[ping]])
        axis = math.atan2(cones.uy[ping], cones.ux[ping])
        target = found.grid.cells_of(origin + seen.reading * np.array([cones.ux[ping], cones.uy[ping]]))
        layer[tuple(target)] = 233.0
        angles = axis + cones.half_apertures[ping] * np.array([-1.0, 1.0])
        sides = origin + 1.2 * seen.reading * np.column_stack([np.cos(angles), np.sin(angles)])
        corners = found.grid.cells_of(np.vstack([origin, sides]))
        (low_row, low_column), (high_row, high_column) = corners.min(axis=0), corners.max(axis=0)
        boxed = (rows >= low_row) & (rows <= high_row) & (columns >= low_column) & (columns <= high_column)
        aside = np.where(np.abs(seen.turns) <= 1, 1 - seen.turns**2, 0.0)
        weight = (1 - (1 + np.tanh(2 * (seen.distances - 1.2))) / 2) * aside
        error, off = 0.1 * seen.reading, seen.distances - seen.reading
        sensor = np.select(
            [off < -2 * error, off < -error, off < error],
            [
                (1 - weight) / 2,
                weight * 0.5 * ((off + 2 * error) / error) ** 2 + (1 - weight) / 2,
                weight * (0.5 - 0.5 * (off / error) ** 2) + 0.5,
            ],
            0.5,
        )
        prior = layer / 254
        after = np.floor(sensor * prior / (sensor * prior + (1 - sensor) * (1 - prior)) * 254)
        layer = np.where(boxed, after, layer)
    return layer


@pytest.mark.parametrize("seed", range(5))
def test_the_costs_are_those_of_the_layer_written_out(seed: int) -> None:
    cones = cells.random_cones(np.random.default_rng(seed))
    found = rule()
    found.add(cones)
    differences = np.abs(254 * found.grid.values - costs(cones, found))
    # Cut off, not rounded, a cost may differ by one where the same sum was added up in another order.
    assert differences.max() <= 2.0
    assert (differences < 0.5).mean() > 0.99


def square_room(canvas: CanvasSettings) -> RangeLayerRule:
    """What becomes of a square room, four steps of a degree, from its middle; its walls scatter sound."""
    found = rule(canvas)
    for bearing in np.radians(np.arange(0.5, 360.0)):
        rays = bearing + np.linspace(-HALF_APERTURE, HALF_APERTURE, 61)
        reading = float((HALF_WIDTH / np.maximum(np.abs(np.cos(rays)), np.abs(np.sin(rays)))).min())
        found.add(cells.cone(bearing=bearing, reading=reading, half_aperture=HALF_APERTURE))
    return found


def test_a_square_room_comes_out_round_and_its_corners_are_cut_off_by_two_fifths_of_its_half_width() -> None:
    grid = square_room(CanvasSettings(resolution=0.05)).grid
    marked = grid.centers_xy[grid.values > 0.8]
    distances, angles = np.hypot(*marked.T), np.arctan2(*marked.T[::-1])
    diagonal = np.abs(np.abs(angles) % (np.pi / 2) - np.pi / 4) < np.radians(5.0)
    cut = HALF_WIDTH * (math.sqrt(2.0) - 1.0 / math.cos(math.pi / 4 - HALF_APERTURE))
    assert cut == pytest.approx(0.397, abs=0.001)
    assert math.sqrt(2.0) * HALF_WIDTH - np.median(distances[diagonal]) == pytest.approx(cut, abs=0.05)
    assert np.ptp(distances) < 0.2
    assert np.median(distances) == pytest.approx(HALF_WIDTH, abs=0.05)


def test_the_side_of_a_cell_is_taken_for_a_relative_error_of_the_range() -> None:
    assert sensor_model(2.0, 2.15, 1.0, 0.05) == 0.5
    assert sensor_model(2.0, 2.15, 1.0, 0.10) > 0.7
    assert sensor_model(1.0, 1.0, 1.0, 0.05) == 1.0


def test_cells_beyond_phi_hardly_count() -> None:
    assert weight_of(1.2, 0.0, 1.2) == 0.5
    assert weight_of(2.5, 0.0, 1.2) < 0.01
    assert weight_of(0.5, 1.1, 1.2) == 0.0


def test_the_faintest_hint_of_free_space_lowers_a_cost_and_none_of_an_obstacle_raises_it() -> None:
    between = [float(cost) for cost in range(1, 254)]
    assert [cost_after(cost, 0.4999) for cost in between] == [cost - 1 for cost in between]
    assert [cost_after(cost, 0.5001) for cost in between] == between


def test_what_is_surely_free_or_occupied_stays_so() -> None:
    assert cost_after(0.0, 0.99) == 0.0
    assert cost_after(254.0, 0.01) == 254.0


def test_the_echo_of_a_wide_beam_lies_beyond_the_rectangle_that_is_updated() -> None:
    wide, narrow = rule(), rule()
    wide.add(cells.cone(0.05, 0.05, reading=1.0, half_aperture=0.9))
    narrow.add(cells.cone(0.05, 0.05, reading=1.0, half_aperture=0.3))
    assert cells.value_at(wide, 1.05, 0.05) == pytest.approx(233 / 254)
    assert cells.value_at(wide, 1.05, 0.15) == 0.5
    assert cells.value_at(narrow, 1.05, 0.15) > 0.6


def test_silence_changes_nothing_unless_it_makes_the_whole_rectangle_free() -> None:
    silent, clearing = rule(), rule(clear_on_max_reading=True)
    for found in (silent, clearing):
        found.add(cells.cone(0.05, 0.05, reading=np.inf, half_aperture=0.3))
    assert silent.grid.values.tolist() == [[0.5]]
    assert cells.value_at(clearing, 2.55, 0.05) == 0.0
    # Not within the beam, but in the rectangle about it.
    assert cells.value_at(clearing, 0.25, 0.75) == 0.0
