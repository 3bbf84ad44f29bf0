"""Grids of rooms that the simulator sounds: mirrors for walls, as they are."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from echoplan.arrays import BoolArray
from echoplan.classical.grid_mapper import GridMapper
from echoplan.evaluation import Evaluation, GridScore, Outline, evaluate, map_error, score_grid
from echoplan.geometry import directions
from echoplan.io import read_grid, write_grid
from echoplan.methods import METHODS, map_sweeps
from echoplan.model import Pings, Sweep
from echoplan.simulation import Simulation
from echoplan.sources import open_source

NAMES = [name for name in METHODS if name.startswith("grid-")]


@pytest.fixture(scope="module")
def room() -> Simulation:
    """The room of the paper, recorded from ten stations."""
    source = open_source("sim:paper-room,seed=1")
    assert isinstance(source, Simulation)
    return source


@pytest.fixture(scope="module")
def sweeps(room: Simulation) -> list[Sweep]:
    return list(room)


@pytest.fixture(scope="module")
def mappers(room: Simulation, sweeps: list[Sweep]) -> dict[str, GridMapper]:
    """All methods of grids, each with all sweeps."""
    return {name: mapper(room, sweeps, name) for name in NAMES}


def mapper(room: Simulation, sweeps: list[Sweep], name: str, **rule: object) -> GridMapper:
    settings = METHODS[name].settings_type.model_validate({"rule": rule})
    made = METHODS[name].build(room.rig, settings).mapper
    assert isinstance(made, GridMapper)
    map_sweeps(made, sweeps)
    return made


def scored(room: Simulation, made: GridMapper) -> GridScore:
    return score_grid(made.grid, room.truth, reach=float(room.rig.max_ranges.max()))


def evaluated(room: Simulation, made: GridMapper) -> Evaluation:
    return evaluate(made.result(), room.truth)


def mean_distance(room: Simulation, made: GridMapper) -> float:
    """Barshan's distance between the occupied cells and the true faces [m]."""
    grid = made.grid
    faces = Outline(segments_xy=room.truth.walls_xy, circles=room.truth.cylinders).samples(0.01)
    return map_error(grid.centers_xy[grid.values > 0.65], faces).mean


@pytest.mark.parametrize("name", NAMES)
def test_every_grid_of_the_papers_room_is_better_than_an_empty_one(
    name: str, room: Simulation, mappers: dict[str, GridMapper]
) -> None:
    score = scored(room, mappers[name])
    assert score.occupied < 0.65
    assert score.free < 0.4
    assert score.balanced_error < 0.45
    assert evaluated(room, mappers[name]).matches.walls.tally.found >= 5


def test_settling_conflicts_brings_occupied_cells_nearest_to_the_walls(
    room: Simulation, mappers: dict[str, GridMapper]
) -> None:
    distances = {name: mean_distance(room, made) for name, made in mappers.items()}
    assert min(distances, key=lambda name: distances[name]) == "grid-cemal"
    assert distances["grid-cemal"] < 0.12
    tally = evaluated(room, mappers["grid-cemal"]).matches.walls.tally
    assert (tally.wanted, tally.found) == (8, 8)
    assert tally.spurious <= 3


def detours(room: Simulation, sweep: Sweep) -> BoolArray:
    """Which echoes came later than from the nearest point within the beam: by way of a corner or of two walls."""
    pings = Pings.from_sweep(sweep, room.rig)
    turns = np.linspace(-1.0, 1.0, 41) * room.rig.sensors[0].half_aperture
    ways = 4.0 * directions(pings.bearings[:, None] + turns)
    (left, low), (right, high) = (edge(room.truth.walls_xy.reshape(-1, 2), axis=0) for edge in (np.min, np.max))
    borders = np.where(ways > 0, [right, high], [left, low]) - pings.origins_xy[:, None]
    direct = 4.0 * (borders / ways).min(axis=(1, 2))
    late: BoolArray = np.isfinite(pings.ranges) & (pings.ranges > direct + 0.03)
    return late


def test_what_hides_the_square_room_from_the_grid_of_1985_is_echoes_by_way_of_corners() -> None:
    square = open_source("sim:square,seed=1")
    assert isinstance(square, Simulation)
    sweeps = list(square)
    late = [detours(square, sweep) for sweep in sweeps]
    assert 0.35 < np.concatenate(late).mean() < 0.45
    direct = [
        replace(sweep, ranges=np.where(those, np.inf, sweep.ranges)) for sweep, those in zip(sweeps, late, strict=True)
    ]
    found = [
        evaluated(square, made).matches.walls.tally.found
        for made in (
            mapper(square, sweeps, "grid-elfes"),
            mapper(square, direct, "grid-elfes"),
            # What the authors call the greatest usable range does the same, where rooms are known to be small.
            mapper(square, sweeps, "grid-elfes", max_range=1.5),
        )
    ]
    assert found == [0, 4, 4]


def test_silence_taken_for_free_space_erases_walls(
    room: Simulation, sweeps: list[Sweep], mappers: dict[str, GridMapper]
) -> None:
    by_the_book = mapper(room, sweeps, "grid-bayes", clear_without_echo=True)
    assert scored(room, by_the_book).occupied > scored(room, mappers["grid-bayes"]).occupied + 0.2


def test_standing_longer_at_the_stations_changes_the_grid_of_bayes_but_not_that_of_muriel(
    room: Simulation, sweeps: list[Sweep], mappers: dict[str, GridMapper]
) -> None:
    changes = {}
    for name in ("grid-bayes", "grid-muriel"):
        longer = mapper(room, [each for each in sweeps for _ in range(3)], name)
        changes[name] = np.abs(longer.grid.values - mappers[name].grid.values).max()
    assert changes["grid-bayes"] > 0.1
    assert changes["grid-muriel"] < 1e-9


@pytest.mark.parametrize("name", NAMES)
def test_a_grid_that_was_kept_says_which_cells_were_occupied(
    name: str, mappers: dict[str, GridMapper], tmp_path: Path
) -> None:
    grid = mappers[name].grid
    write_grid(tmp_path / "room.yaml", grid)
    again = read_grid(tmp_path / "room.yaml")
    assert np.array_equal(again.values == 1.0, grid.values > 0.65)
    assert np.array_equal(again.values == 0.0, grid.values < 0.196)
    np.testing.assert_allclose(again.centers_xy, grid.centers_xy, atol=1e-8)
