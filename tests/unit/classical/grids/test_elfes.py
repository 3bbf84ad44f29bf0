import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.classical.grids import Cones, ElfesRule, ElfesSettings
from helpers import cells

ERROR = 0.15


def rule(**changed: float) -> ElfesRule:
    return ElfesRule(ElfesSettings(range_error=ERROR, **changed), cells.COARSE)


def certainties(cones: Cones, found: ElfesRule) -> FloatArray:
    """Empty and occupied certainties by the formulas of 1985, one ping after the other."""
    raster = cells.raster_of(found.grid)
    empty, occupied = np.zeros((2, raster.rows, raster.columns))
    echoes = [each for each in cells.seen(cones, raster) if np.isfinite(each.reading)]
    for seen in echoes:
        beyond = (seen.distances - 0.05) / (seen.reading - ERROR - 0.05)
        near = seen.inside & (seen.distances >= 0.05) & (seen.distances <= seen.reading - ERROR)
        share = np.where(near, (1 - beyond**2) * (1 - seen.turns**2), 0.0)
        empty = empty + share - empty * share
    for seen in echoes:
        off = (seen.distances - seen.reading) / ERROR
        share = np.where(seen.inside & (np.abs(off) <= 1), (1 - off**2) * (1 - seen.turns**2), 0.0) * (1 - empty)
        share = share / share.sum() if share.sum() > 0 else share
        occupied = occupied + share - occupied * share
    return np.stack([empty, occupied])


@pytest.mark.parametrize("seed", range(5))
def test_the_certainties_are_those_of_the_formulas_written_out(seed: int) -> None:
    cones = cells.random_cones(np.random.default_rng(seed))
    found = rule()
    found.add(cones)
    empty, occupied = certainties(cones, found)
    wanted = np.where(occupied > empty, (1 + occupied) / 2, (1 - empty) / 2)
    np.testing.assert_allclose(found.grid.values, wanted, atol=1e-9)


def test_the_certainties_of_one_echo_sum_to_one() -> None:
    found = rule()
    found.add(cells.cone(0.02, 0.03))
    assert found._canvas.layers[1].sum() == pytest.approx(1.0)


def test_a_cell_known_to_be_empty_cancels_and_the_rest_of_the_arc_takes_its_share() -> None:
    echo = cells.cone(0.05, 0.05)
    alone, cancelled = rule(), rule()
    alone.add(echo)
    for _ in range(20):
        cancelled.add(cells.cone(1.05, 1.05, bearing=-np.pi / 2, reading=1.25, half_aperture=0.3))
    cancelled.add(echo)
    assert cells.value_at(alone, 1.05, 0.05) > 0.5 > cells.value_at(cancelled, 1.05, 0.05)
    assert cells.value_at(cancelled, 0.95, -0.35) > cells.value_at(alone, 0.95, -0.35) > 0.5


def test_the_empty_cells_of_a_sweep_count_before_its_echoes() -> None:
    pings = [cells.cone(0.05, 0.05), cells.cone(1.05, 1.05, bearing=-np.pi / 2, reading=1.9)]
    both = [Cones(*map(np.concatenate, zip(*order, strict=True))) for order in (pings, pings[::-1])]
    first, second = rule(), rule()
    first.add(both[0])
    second.add(both[1])
    np.testing.assert_allclose(first.grid.values, second.grid.values, atol=1e-12)


def test_silence_and_readings_beyond_the_farthest_usable_are_discarded() -> None:
    found = rule(max_range=0.9)
    found.add(cells.cone(reading=np.inf))
    found.add(cells.cone(reading=1.0))
    assert found.grid.values.tolist() == [[0.5]]
