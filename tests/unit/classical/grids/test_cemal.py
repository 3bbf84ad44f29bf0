import numpy as np
import pytest

from echoplan.classical.grids import CemalRule, CemalSettings, Cones
from helpers import cells

THICKNESS = 0.2


def rule(*parts: Cones, share: float = 1.0) -> CemalRule:
    made = CemalRule(CemalSettings(thickness=THICKNESS, min_relative_fit=share), cells.COARSE)
    for part in parts:
        made.add(part)
    return made


def kept_by_the_book(cones: Cones, found: CemalRule) -> list[bool]:
    """Conflicts settled with sets: the shortest reading first, each against all that were kept before."""
    arcs: dict[int, dict[tuple[int, int], float]] = {}
    freed: dict[tuple[int, int], float] = {}
    kept = np.zeros(len(cones.x), dtype=bool)
    looks = list(cells.seen(cones, cells.raster_of(found.grid)))
    for ping in np.argsort(cones.readings, kind="stable"):
        seen = looks[ping]
        loud = np.exp(-2 * seen.turns**2) / seen.distances
        silent = np.isinf(seen.reading)
        depth = seen.reach if silent else seen.reading - THICKNESS / 2
        free = {tuple(cell): loud[tuple(cell)] for cell in np.argwhere(seen.inside & (seen.distances <= depth))}
        on_arc = seen.inside & (seen.distances >= depth) & (seen.distances <= seen.reading + THICKNESS / 2)
        own = {tuple(cell): loud[tuple(cell)] for cell in np.argwhere(on_arc)}
        standing = {cell: level for cell, level in own.items() if level >= freed.get(cell, 0.0)}
        left = {who: {cell for cell, level in arc.items() if level >= free.get(cell, 0.0)} for who, arc in arcs.items()}
        if (standing or silent) and all(left.values()):
            kept[ping] = True
            arcs = {who: {cell: arcs[who][cell] for cell in stays} for who, stays in left.items()}
            freed |= {cell: max(level, freed.get(cell, 0.0)) for cell, level in free.items()}
            if not silent:
                arcs[ping] = standing
    return kept.tolist()


@pytest.mark.parametrize("seed", range(8))
def test_conflicts_are_settled_as_with_plain_sets(seed: int) -> None:
    cones = cells.random_cones(np.random.default_rng(seed), count=25)
    found = rule(cones)
    assert found.kept.tolist() == kept_by_the_book(cones, found)
    assert 5 < found.kept.sum() < 25


def test_a_specular_long_reading_does_not_erase_a_wall() -> None:
    wall = cells.cone(0.05, 0.05, half_aperture=0.3)
    oblique = cells.cone(0.65, 0.55, bearing=-0.9, reading=2.9, half_aperture=1.2)
    for pings in ((wall, oblique), (oblique, wall)):
        found = rule(*pings)
        assert found.kept.tolist() == [each is wall for each in pings]
        assert cells.value_at(found, 1.05, 0.05) == pytest.approx(2 / 3)
    alone = rule(oblique)
    assert alone.kept.all()
    assert cells.value_at(alone, 1.05, 0.05) < 0.5


def test_silence_across_a_whole_arc_does_not_erase_it_either() -> None:
    found = rule(cells.cone(0.35, 0.05, reading=np.inf), cells.cone(0.05, 0.05, half_aperture=0.3))
    assert found.kept.tolist() == [False, True]


def test_a_long_reading_that_leaves_a_part_of_an_arc_narrows_it_to_the_rest() -> None:
    narrow = cells.cone(0.05, 0.05, bearing=0.3, reading=2.0, half_aperture=0.3)
    found = rule(cells.cone(0.05, 0.05), narrow)
    assert found.kept.all()
    occupied = found.grid.centers_xy[found.grid.values > 0.5]
    near = occupied[np.hypot(*(occupied - 0.05).T) < 1.2]
    assert len(near) == 1
    assert near[0, 1] < 0.05


def test_the_cell_that_fits_most_readings_best_explains_them_all() -> None:
    point = np.array([1.05, 0.05])
    stations = [(0.05, 0.05), (0.55, -0.85), (0.65, 0.95)]
    pings = [
        cells.cone(x, y, bearing=np.arctan2(*(point - (x, y))[::-1]) + 0.2, reading=np.hypot(*(point - (x, y))))
        for x, y in stations
    ]
    found = rule(*pings)
    assert found.kept.all()
    occupied = found.grid.values > 0.5
    assert found.grid.values[occupied] == pytest.approx([4 / 5])
    assert np.hypot(*(found.grid.centers_xy[occupied] - point).T) < 0.12


def test_cells_that_fit_nearly_as_well_explain_a_reading_too() -> None:
    echo = cells.cone(0.05, 0.05)
    counts = [(rule(echo, share=share).grid.values > 0.5).sum() for share in (1.0, 0.9, 0.5, 1e-9)]
    assert counts[0] == 1 < counts[1] < counts[2] < counts[3]


def test_nothing_to_settle_is_an_unknown_cell() -> None:
    empty = Cones(*(field[:0] for field in cells.cone()))
    for found in (rule(), rule(empty)):
        assert found.kept.tolist() == []
        assert found.grid.values.tolist() == [[0.5]]
