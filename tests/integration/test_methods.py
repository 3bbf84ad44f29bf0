"""What every method must do: whatever stands in the registry is tried here."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

from echoplan.evaluation import evaluate
from echoplan.io import read_map, write_map
from echoplan.methods import METHODS, Method, map_sweeps, observations_of
from echoplan.model import FeatureMap, Sweep
from echoplan.simulation import Simulation
from echoplan.sources import open_source

# Five stations are few for these: they map points, or ask for a third witness of each wall.
RELUCTANT = {"arc-hough-tbf", "iepf-kalman", "tbf"}
# Walls are mirrors for sound, and what a long way round makes empty, this one never takes back: see test_grids.py.
HELPLESS = {"grid-elfes"}


@pytest.fixture(params=METHODS.values(), ids=list(METHODS), scope="module")
def method(request: pytest.FixtureRequest) -> Method:
    """Each method in turn."""
    chosen: Method = request.param
    return chosen


@pytest.fixture(scope="module")
def square() -> Simulation:
    """A square room, recorded from five stations."""
    source = open_source("sim:square,seed=1")
    assert isinstance(source, Simulation)
    return source


@pytest.fixture(scope="module")
def sweeps(square: Simulation) -> list[Sweep]:
    return list(square)


@pytest.fixture(scope="module")
def found(method: Method, square: Simulation, sweeps: list[Sweep]) -> FeatureMap:
    """The map of the square by each method."""
    return map_sweeps(method.build(square.rig), sweeps)


def written(found: FeatureMap, path: Path) -> str:
    write_map(path, found)
    return path.read_text(encoding="utf-8")


def silent(sweep: Sweep) -> Sweep:
    return replace(sweep, ranges=np.full(len(sweep), np.inf))


def test_walls_of_a_square_room_are_found_to_a_hands_breadth(
    method: Method, square: Simulation, found: FeatureMap
) -> None:
    walls = evaluate(found, square.truth).matches.walls
    assert walls.tally.found >= (0 if method.name in HELPLESS else 1 if method.name in RELUCTANT else 3)
    assert max((match.distance for match in walls.right), default=0.0) < 0.1


def test_the_map_says_how_it_was_made(method: Method, sweeps: list[Sweep], found: FeatureMap, tmp_path: Path) -> None:
    assert found.method == method.name
    assert found.sweeps.tolist() == [sweep.index for sweep in sweeps]
    # A method may add what it found out by itself.
    used = {name: found.parameters[name] for name in method.settings_type.model_fields}
    assert method.settings_type.model_validate(used) == method.settings_type()
    text = written(found, tmp_path / "map.json")
    assert written(read_map(tmp_path / "map.json"), tmp_path / "again.json") == text


def test_the_same_sweeps_give_the_same_map_every_time(
    method: Method, square: Simulation, sweeps: list[Sweep], found: FeatureMap, tmp_path: Path
) -> None:
    mapper = method.build(square.rig)
    maps = [map_sweeps(mapper, sweeps), mapper.result(), found]
    first, again, third = (written(each, tmp_path / f"{number}.json") for number, each in enumerate(maps))
    assert first == again == third


def test_a_map_can_be_made_before_the_last_sweep(
    method: Method, square: Simulation, sweeps: list[Sweep], found: FeatureMap, tmp_path: Path
) -> None:
    mapper = method.build(square.rig)
    half = len(sweeps) // 2
    map_sweeps(mapper, sweeps[:half])
    parted = map_sweeps(mapper, sweeps[half:])
    assert written(parted, tmp_path / "map.json") == written(found, tmp_path / "whole.json")


def test_a_recording_without_echoes_gives_an_empty_map(method: Method, square: Simulation, sweeps: list[Sweep]) -> None:
    for given in ([], [silent(sweep) for sweep in sweeps]):
        mapper = method.build(square.rig)
        found = map_sweeps(mapper, given)
        assert (found.walls, found.corners, found.cylinders) == ((), (), ())
        assert len(found.poses) == len(given)
        assert observations_of(mapper) == ()


def test_its_settings_are_refused_where_they_are_misspelt(method: Method) -> None:
    with pytest.raises(ValidationError, match="Extra inputs are not permitted"):
        method.settings_type.model_validate({"no_such_setting": 1})


def test_it_says_in_one_line_what_it_does(method: Method) -> None:
    assert 10 < len(method.summary) < 100
    assert "\n" not in method.summary
