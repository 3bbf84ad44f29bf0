from math import erf

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.classical.grids import Cones, MurielRule, MurielSettings
from helpers import cells

SETTINGS = MurielSettings(detection_probability=0.9, sigma=0.05, clutter_density=2.0, place=0.2)


def rule() -> MurielRule:
    return MurielRule(SETTINGS, cells.COARSE)


def joined(*parts: Cones) -> Cones:
    return Cones(*map(np.concatenate, zip(*parts, strict=True)))


@pytest.mark.parametrize("seed", range(3))
def test_the_grid_is_that_of_the_forward_model_written_out(seed: int) -> None:
    cones = cells.random_cones(np.random.default_rng(seed), count=12)
    found = rule()
    found.add(cones)
    raster = cells.raster_of(found.grid)
    places = np.floor(np.column_stack([cones.hub_x, cones.hub_y]) / 0.2)
    strongest: dict[tuple[float, ...], FloatArray] = {}
    for place, seen in zip(map(tuple, places), cells.seen(cones, raster), strict=True):
        q = 0.9 * (1 - (seen.distances / seen.reach) ** 2) * (1 - seen.turns**2)
        z = (seen.reading - seen.distances) / 0.05
        passed = 0.5 * (1 + np.vectorize(erf)(z / np.sqrt(2)))
        ratio = 1 - q * passed + q * np.exp(-(z**2) / 2) / np.sqrt(2 * np.pi) / 0.05 / 2.0
        affected = seen.inside & (seen.distances <= min(seen.reading + 0.15, seen.reach))
        evidence = np.log(np.where(affected, ratio, 1.0))
        best, worst = strongest.get(place, np.zeros((2, *evidence.shape)))
        strongest[place] = np.stack([np.maximum(best, evidence), np.minimum(worst, evidence)])
    total = np.zeros((raster.rows, raster.columns))
    for place, both in strongest.items():
        faces = 2 / np.pi * cones.half_apertures[(places == place).all(axis=1)].max()
        total += np.log(1 - faces + faces * np.exp(both.sum(axis=0)))
    np.testing.assert_allclose(found.grid.values, 1 / (1 + np.exp(-total)), atol=1e-9)


def test_repeats_from_one_place_count_once() -> None:
    ping = cells.cone(0.05, 0.05, hub=(0.0, 0.0))
    once, often, later = rule(), rule(), rule()
    once.add(ping)
    for _ in range(10):
        often.add(ping)
    elsewhere = cells.cone(0.05, 0.55, hub=(0.0, 0.5))
    for cones in (ping, elsewhere, ping):
        later.add(cones)
    assert np.array_equal(once.grid.values, often.grid.values)
    once.add(elsewhere)
    assert np.array_equal(once.grid.values, later.grid.values)


def test_another_place_counts_anew() -> None:
    pings = [cells.cone(0.05, 0.05 + 0.01 * number, hub=(0.0, 0.5 * number)) for number in range(3)]
    found = rule()
    values = []
    for ping in pings:
        found.add(ping)
        values.append(cells.value_at(found, 1.05, 0.05))
    assert 0.5 < values[0] < values[1] < values[2]


def test_the_evidence_of_a_place_is_that_of_its_strongest_pings_for_and_against() -> None:
    strong, weak = cells.cone(0.05, 0.05, reading=1.01), cells.cone(0.05, 0.05, reading=1.06)
    both, one = rule(), rule()
    both.add(joined(weak, strong))
    one.add(strong)
    assert cells.value_at(both, 1.05, 0.05) == cells.value_at(one, 1.05, 0.05) > 0.5


def test_sound_may_be_thrown_away_so_that_a_long_reading_takes_little_from_a_wall() -> None:
    found = rule()
    found.add(cells.cone(0.05, 0.05, half_aperture=0.3))
    before = cells.value_at(found, 1.05, 0.05)
    found.add(cells.cone(0.05, 0.55, bearing=-0.4, reading=2.5, half_aperture=0.3, hub=(0.0, 0.5)))
    assert before > cells.value_at(found, 1.05, 0.05) > 0.5
    faces = 0.6 / np.pi
    alone = rule()
    alone.add(cells.cone(0.05, 0.05, reading=np.inf, half_aperture=0.3))
    assert 0.5 > alone.grid.values.min() > (1 - faces) / (2 - faces)


def test_a_surface_is_not_where_other_pings_of_the_place_look_through() -> None:
    found = rule()
    found.add(cells.cone(0.05, 0.05))
    before = cells.value_at(found, 0.85, 0.55)
    found.add(cells.cone(0.05, 0.05, bearing=0.6, reading=2.0))
    assert before > 0.5 > cells.value_at(found, 0.85, 0.55)


def test_silence_is_evidence_against_cells_and_weaker_the_farther_they_are() -> None:
    found = rule()
    found.add(cells.cone(0.05, 0.05, reading=np.inf))
    values = [cells.value_at(found, x, 0.05) for x in (0.55, 1.55, 2.55)]
    assert values == sorted(values)
    assert max(values) < 0.5
