import numpy as np
import pytest

from echoplan.classical.grids import BayesRule, BayesSettings
from helpers import cells

SETTINGS = BayesSettings(occupied=0.8, free=0.4, thickness=0.2, clear_without_echo=True)


def rule(settings: BayesSettings = SETTINGS) -> BayesRule:
    return BayesRule(settings, cells.COARSE)


@pytest.mark.parametrize("seed", range(5))
def test_the_grid_is_that_of_the_inverse_sensor_model_written_out(seed: int) -> None:
    cones = cells.random_cones(np.random.default_rng(seed))
    found = rule()
    found.add(cones)
    raster = cells.raster_of(found.grid)
    odds = np.zeros((raster.rows, raster.columns))
    for seen in cells.seen(cones, raster):
        depth = min(seen.reading, seen.reach)
        free = seen.inside & (seen.distances <= depth - 0.1 * np.isfinite(seen.reading))
        occupied = seen.inside & ~free & (seen.distances <= depth + 0.1) & np.isfinite(seen.reading)
        odds += np.log(0.8 / 0.2) * occupied + np.log(0.4 / 0.6) * free
    np.testing.assert_allclose(found.grid.values, 1 / (1 + np.exp(-odds)), atol=1e-12)


def test_one_ping_makes_its_arc_occupied_and_the_space_before_it_free_and_changes_nothing_else() -> None:
    found = rule()
    found.add(cells.cone(0.05, 0.05))
    values = [cells.value_at(found, x, y) for x, y in ((1.05, 0.05), (0.55, 0.05), (1.35, 0.05), (0.05, 0.75))]
    assert values == pytest.approx([0.8, 0.4, 0.5, 0.5])


def test_equal_evidence_cancels() -> None:
    found = rule(BayesSettings(occupied=0.7, free=0.3, thickness=0.2))
    found.add(cells.cone(0.05, 0.05, reading=1.0))
    assert cells.value_at(found, 1.05, 0.05) == pytest.approx(0.7)
    found.add(cells.cone(0.05, 0.05, reading=2.0))
    assert cells.value_at(found, 1.05, 0.05) == pytest.approx(0.5)


def test_pings_count_the_same_in_any_order_and_in_any_portions() -> None:
    cones = cells.random_cones(np.random.default_rng(9))
    whole, parts = rule(), rule()
    whole.add(cones)
    for ping in np.random.default_rng(1).permutation(len(cones.x)):
        parts.add(type(cones)(*(field[ping : ping + 1] for field in cones)))
    assert whole.grid.origin_xy.tolist() == parts.grid.origin_xy.tolist()
    np.testing.assert_allclose(whole.grid.values, parts.grid.values, atol=1e-12)


def test_silence_changes_nothing_unless_it_is_set_to_clear_the_whole_cone() -> None:
    deaf = rule(BayesSettings(clear_without_echo=False))
    for found, wanted in ((rule(), 0.4), (deaf, 0.5)):
        found.add(cells.cone(0.05, 0.05, reading=np.inf))
        found.add(cells.cone(0.05, 3.05, reading=1.0))
        assert cells.value_at(found, 2.85, 0.05) == pytest.approx(wanted)
