"""Grids of rooms that the simulator sounds: mirrors for walls, as they are."""

from pathlib import Path

import numpy as np
import pytest

from echoplan.evaluation import Evaluation, GridScore, Outline, evaluate, map_error, score_grid
from echoplan.io import read_grid, write_grid
from echoplan.methods import METHODS, map_sweeps
from echoplan.methods.grids import GridMapper
from echoplan.model import Sweep
from echoplan.simulation import Simulation
from echoplan.sources import open_source

NAMES = [name for name in METHODS if name.startswith("grid-")]


@pytest.fixture(scope="module")
def room() -> Simulation:
    """The room of the paper, heard from ten stations."""
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
    made = METHODS[name].build(room.rig, settings)
    assert isinstance(made, GridMapper)
    map_sweeps(made, sweeps)
    return made


def scored(room: Simulation, made: GridMapper) -> GridScore:
    return score_grid(made.grid, room.truth, reach=float(room.rig.max_ranges.max()))


def evaluated(room: Simulation, made: GridMapper) -> Evaluation:
    return evaluate(made.result(), room.truth)


def astray(room: Simulation, made: GridMapper) -> float:
    """Barshan's distance between the occupied cells and the true faces [m]."""
    grid = made.grid
    faces = Outline(segments_xy=room.truth.walls_xy, circles=room.truth.cylinders).samples(0.01)
    return map_error(grid.centers_xy[grid.values > 0.65], faces).mean


@pytest.mark.parametrize("name", NAMES)
def test_every_grid_of_the_papers_room_knows_more_than_nothing(
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
    distances = {name: astray(room, made) for name, made in mappers.items()}
    assert min(distances, key=lambda name: distances[name]) == "grid-cemal"
    assert distances["grid-cemal"] < 0.12
    tally = evaluated(room, mappers["grid-cemal"]).matches.walls.tally
    assert (tally.wanted, tally.found) == (8, 8)
    assert tally.spurious <= 3


def test_silence_taken_for_free_space_erases_walls(
    room: Simulation, sweeps: list[Sweep], mappers: dict[str, GridMapper]
) -> None:
    by_the_book = mapper(room, sweeps, "grid-bayes", clear_without_echo=True)
    assert scored(room, by_the_book).occupied > scored(room, mappers["grid-bayes"]).occupied + 0.2


def test_standing_longer_at_the_stations_changes_what_bayes_believes_and_muriel_does_not(
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
