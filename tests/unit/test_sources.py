"""A source is named in one line of text."""

import errno
from pathlib import Path

import numpy as np
import pytest

from echoplan.errors import InputError, UnknownNameError
from echoplan.io import builtin_rig, builtin_route, builtin_world, write_recording, write_rig, write_route, write_world
from echoplan.model import Recording, Source, Sweep
from echoplan.simulation import Simulation, SimulationSettings
from echoplan.sources import find_rig, find_route, find_world, open_source


def opened(text: str, settings: SimulationSettings | None = None) -> Simulation:
    simulation = open_source(text, simulation=settings)
    assert isinstance(simulation, Simulation)
    return simulation


def first_ranges(source: Source) -> list[float]:
    ranges: list[float] = next(iter(source)).ranges.tolist()
    return ranges


@pytest.fixture
def room(tmp_path: Path) -> Path:
    """Write a room and a way through it into files."""
    write_world(tmp_path / "room.toml", builtin_world("hexagon"))
    write_route(tmp_path / "room.csv", builtin_route("hexagon"))
    return tmp_path / "room.toml"


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    """Write a recording of a single ping."""
    sweep = Sweep(
        index=0,
        stamps_ns=np.array([0]),
        sensor_ids=np.array([0]),
        servo_angles=np.zeros(1),
        ranges=np.array([1.5]),
        map_from_base=np.zeros((1, 3)),
    )
    path = tmp_path / "take.2"
    write_recording(path, Recording(name="take", rig=builtin_rig("ring-16"), sweeps=(sweep,)))
    return path


def test_a_folder_is_a_recording(recording: Path) -> None:
    source = open_source(f"{recording}/")
    assert (source.name, len(source), first_ranges(source)) == ("take.2", 1, [1.5])


def test_a_built_in_world_is_simulated_with_the_array_of_the_paper_on_its_own_route() -> None:
    simulation = opened("sim:square")
    assert (simulation.name, simulation.rig.name, simulation.seed) == ("square", "rotary array", 0)
    assert simulation.route.map_from_base.tolist() == builtin_route("square").map_from_base.tolist()


def test_options_follow_after_commas() -> None:
    simulation = opened("sim:square,rig=ring-16,seed=3,route=hexagon")
    assert (simulation.rig.name, simulation.seed) == ("ring of sixteen", 3)
    assert simulation.route.map_from_base.tolist() == builtin_route("hexagon").map_from_base.tolist()


def test_only_the_seed_determines_the_random_numbers() -> None:
    settings = SimulationSettings(jitter=0.02)
    ranges = [first_ranges(opened(f"sim:square,rig=ring-16,seed={seed}", settings)) for seed in (3, 3, 4)]
    np.testing.assert_array_equal(ranges[0], ranges[1])
    assert ranges[0] != ranges[2]


def test_settings_reach_the_simulator() -> None:
    settings = SimulationSettings(assumed_temperature=30.0)
    assert opened("sim:square", settings).settings is settings


def test_a_world_of_its_own_takes_the_route_beside_it(room: Path) -> None:
    simulation = opened(f"sim:{room}")
    assert simulation.name == "hexagon"
    assert simulation.route.map_from_base.tolist() == builtin_route("hexagon").map_from_base.tolist()


def test_rig_and_route_may_be_files(room: Path) -> None:
    write_rig(room.parent / "mine.toml", builtin_rig("hc-sr04-servo"))
    write_route(room.parent / "way.txt", builtin_route("square"))
    simulation = opened(f"sim:{room},rig={room.parent}/mine.toml,route={room.parent}/way.txt")
    assert simulation.rig.name == "HC-SR04 on a servo"
    assert simulation.route.map_from_base.tolist() == builtin_route("square").map_from_base.tolist()


def test_names_of_files_may_have_commas(room: Path) -> None:
    write_rig(room.parent / "mine, new.toml", builtin_rig("hc-sr04-servo"))
    write_route(room.parent / "way, long.csv", builtin_route("square"))
    simulation = opened(f"sim:{room},rig={room.parent}/mine, new.toml,route={room.parent}/way, long.csv,seed=2")
    assert simulation.rig.name == "HC-SR04 on a servo"
    assert simulation.route.map_from_base.tolist() == builtin_route("square").map_from_base.tolist()
    assert simulation.seed == 2


def test_names_are_built_in_and_paths_are_files(room: Path) -> None:
    assert find_world("office").name == "office"
    assert find_world(str(room)).name == "hexagon"
    assert find_rig("ring-16").sensors == builtin_rig("ring-16").sensors
    assert find_route(str(room)).map_from_base.shape == builtin_route("hexagon").map_from_base.shape


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("paper-room", "paper-room: there is no such file or folder; name sim:paper-room"),
        ("takes/one", "takes/one: there is no such file or folder; name a recording's folder, a ROS bag or sim:WORLD"),
        ("tape:one", "tape:one: there is no such file or folder; name a recording's folder, a ROS bag or sim:WORLD"),
        ("sim:square,seed=soon", "sim:square,seed=soon: the seed 'soon' is no whole number; write, say, seed=3"),
        ("sim:square,seed=-1", "the seed '-1' is no whole number"),
        ("sim:square,seed", "the seed '' is no whole number"),
        (f"sim:square,seed={'9' * 5000}", r"the seed '999.*999' is no whole number of up to 18 digits; write, say"),
        ("sim:none.toml", r"none\.toml: there is no such file; check the name"),
    ],
)
def test_an_invalid_source_is_refused(text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        open_source(text)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("sim:paperroom", "unknown world 'paperroom'; did you mean 'paper-room'"),
        ("sim:", "unknown world ''"),
        ("sim:square,rig=ring-61", "unknown rig 'ring-61'; did you mean 'ring-16'"),
        ("sim:square,sede=3", "unknown option 'sede'; did you mean 'seed'"),
    ],
)
def test_an_unknown_name_is_refused_with_the_nearest(text: str, message: str) -> None:
    with pytest.raises(UnknownNameError, match=message):
        open_source(text)


def test_a_file_that_is_no_recording_is_refused(room: Path) -> None:
    with pytest.raises(InputError, match=r"room\.toml: it is a file; name a folder with pings\.csv and rig\.toml"):
        open_source(str(room))


def test_a_world_without_a_route_is_refused(room: Path) -> None:
    room.with_suffix(".csv").unlink()
    with pytest.raises(InputError, match=r"room\.csv: there is no route through room\.toml; write its stations there"):
        open_source(f"sim:{room}")


def test_a_path_that_may_not_be_searched_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(_: Path) -> bool:
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(Path, "exists", refuse)
    with pytest.raises(InputError, match="rec: it may not be read; ask its owner for permission"):
        open_source("private/rec")
