"""Several recordings of one place, each with poses in a frame of its own, make one map."""

import re
import shutil
import tomllib
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from shapely import Point, Polygon

import echoplan as ep
from echoplan.geometry import compose, invert
from echoplan.io import builtin_rig, read_map, read_recording, write_arrays, write_recording
from echoplan.model import Polyline, Recording, Rig, Route, Sweep, World
from echoplan.simulation import Simulation
from helpers.typed import echoplan, succeed

# Frame of the second recording in that of the first one: 0.3 m and 20 degrees away.
AWAY = np.array([0.3, -0.1, np.radians(20.0)])

# A room with a table, the same room with cupboards instead, and poses in both.
SMALL_ROOM = Polyline(points_xy=np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]]), closed=True)
TABLE = ([1.7, 1.3, 2.1, 1.6],)
CUPBOARDS = ([3.2, 0.03, 3.97, 0.8], [0.03, 2.2, 0.8, 2.97], [3.2, 2.2, 3.97, 2.97], [0.03, 0.03, 0.8, 0.5])
AROUND_A_TABLE = (
    [1.2, 0.7, 0.2],
    [1.7, 0.8, 0.0],
    [2.3, 0.7, 0.3],
    [2.7, 1.1, 0.8],
    [2.8, 1.7, 1.5],
    [2.4, 2.1, 2.4],
    [1.9, 2.1, 3.1],
    [1.4, 1.9, 3.5],
    [1.1, 1.4, 4.5],
)


def box(corners: Sequence[float]) -> Polyline:
    """Return the outline of a rectangle between two opposite corners."""
    x, y, right, top = corners
    return Polyline(points_xy=np.array([[x, y], [right, y], [right, top], [x, top]]), closed=True)


def written(folder: Path, sweeps: Sequence[Sweep], *, rig: Rig, away: np.ndarray) -> Path:
    """Write sweeps as a recording of their own, with poses in another frame."""
    moved = tuple(
        replace(sweep, index=number, map_from_base=compose(invert(away), sweep.map_from_base))
        for number, sweep in enumerate(sweeps)
    )
    write_recording(folder, Recording(name=folder.name, rig=rig, sweeps=moved))
    return folder


@pytest.fixture(scope="module")
def flat() -> ep.Simulation:
    """A flat of two rooms."""
    return ep.simulate("two-room-flat", seed=2)


@pytest.fixture(scope="module")
def recordings(flat: ep.Simulation, tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """The flat in two recordings: four stations are in both."""
    folder, sweeps = tmp_path_factory.mktemp("recordings"), list(flat)
    return [
        written(folder / "one", sweeps[:13], rig=flat.rig, away=np.zeros(3)),
        written(folder / "two", sweeps[9:], rig=flat.rig, away=AWAY),
    ]


@pytest.fixture(scope="module")
def mapped(recordings: list[Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The map of both."""
    out = tmp_path_factory.mktemp("mapped") / "map"
    succeed("map", *recordings, "--out", out)
    return out


def test_they_make_the_map_of_one_recording(flat: ep.Simulation, mapped: Path) -> None:
    found = ep.evaluate(mapped, flat.truth).matches.walls
    assert found.tally.found == found.tally.wanted
    assert not found.spurious
    assert max(each.distance for each in found.right) < 0.003


def test_the_poses_of_both_are_in_the_frame_of_the_first(flat: ep.Simulation, mapped: Path) -> None:
    found, true = read_map(mapped), flat.truth.poses
    assert found.sweeps.tolist() == list(range(len(true) + 4))
    assert np.hypot(*(found.poses - np.concatenate([true[:13], true[9:]]))[:, :2].T).max() < 0.003


def test_the_report_names_both_recordings(mapped: Path) -> None:
    assert "<h1>Map of one and two</h1>" in (mapped / "report.html").read_text(encoding="utf-8")


def test_the_way_between_two_recordings_is_no_path(mapped: Path) -> None:
    assert len(read_map(mapped).openings) == 1
    assert [len(path_xy) for path_xy in read_map(mapped).paths_xy] == [13, len(read_map(mapped).poses) - 13]


def test_a_recording_that_shares_too_little_is_refused(
    flat: ep.Simulation, recordings: list[Path], tmp_path: Path
) -> None:
    other = written(tmp_path / "other", list(flat)[22:], rig=flat.rig, away=AWAY)
    done = echoplan("map", recordings[0], other, "--out", tmp_path / "map")
    assert done.status == 2
    assert "other: its beginning is not in the map so far" in done.err
    assert done.err.count("\n") == 1
    assert not (tmp_path / "map").exists()


def test_a_recording_of_another_room_of_the_same_size_is_refused(tmp_path: Path) -> None:
    rig, around = builtin_rig("rotary-array"), np.array(AROUND_A_TABLE)
    rooms = [World(name="room", polylines=(SMALL_ROOM, *map(box, boxes))) for boxes in (TABLE, CUPBOARDS)]
    folders = [
        written(tmp_path / f"room{number}", list(drive), rig=rig, away=AWAY)
        for number, room in enumerate(rooms)
        for drive in [Simulation(world=room, rig=rig, route=Route(map_from_base=around), seed=number)]
    ]
    done = echoplan("map", *folders, "--out", tmp_path / "map")
    assert done.status == 2
    assert re.search(r"room1: its beginning is not in the map so far: echoes and map agree to only \d\d % \(", done.err)


def test_only_joint_maps_several(recordings: list[Path], tmp_path: Path) -> None:
    done = echoplan("map", *recordings, "--method", "rcd", "--out", tmp_path / "map")
    assert (done.status, done.err) == (
        2,
        "echoplan: --method: it maps one recording only; use joint\n",
    )


def test_recordings_of_other_sensors_are_refused(recordings: list[Path], tmp_path: Path) -> None:
    succeed("simulate", "square", "--rig", "ring-16", "--out", tmp_path / "ring")
    done = echoplan("map", recordings[0], tmp_path / "ring", "--out", tmp_path / "map")
    assert done.status == 2
    assert "its sensors are not those of one" in done.err


@pytest.fixture(scope="module")
def first(recordings: list[Path]) -> Path:
    """The map of the first recording alone."""
    out = recordings[0].parent / "first"
    succeed("map", recordings[0], "--out", out)
    return out


@pytest.fixture(scope="module")
def gone_on(recordings: list[Path], first: Path) -> Path:
    """The map of the second recording, which goes on from that of the first."""
    out = first.parent / "second"
    printed = succeed("map", recordings[1], "--start", first, "--out", out)
    assert "Changed when two was recorded: nothing" in " ".join(printed.split())
    return out


def test_a_map_that_goes_on_from_a_map_is_that_of_both_recordings(mapped: Path, gone_on: Path) -> None:
    both, after = read_map(mapped), read_map(gone_on)
    assert len(after.walls) == len(both.walls)
    for one, other in zip(both.walls, after.walls, strict=True):
        assert one.endpoints_xy == pytest.approx(other.endpoints_xy, abs=1e-4)
        assert np.sqrt(np.diag(one.covariance)) == pytest.approx(np.sqrt(np.diag(other.covariance)), rel=0.05)


def test_its_poses_are_those_of_its_own_recording(recordings: list[Path], flat: ep.Simulation, gone_on: Path) -> None:
    found, true = read_map(gone_on), flat.truth.poses[9:]
    assert len(found.poses) == len(read_recording(recordings[1]))
    assert np.hypot(*(found.poses - true)[:, :2].T).max() < 0.003


def test_the_run_names_the_map_from_which_it_goes_on(first: Path, gone_on: Path) -> None:
    assert tomllib.loads((gone_on / "run.toml").read_text(encoding="utf-8"))["run"]["start"] == str(first)
    assert "Changes" in (gone_on / "report.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("options", "name", "words"),
    [
        (["--method", "rcd"], "first", "--start: rcd cannot go on from a map; use joint"),
        (["--poses", "trust"], "first", "--poses: the poses of a recording that goes on from another one"),
        ([], "nowhere", "nowhere"),
        ([], "first/map.svg", "map.svg: it is no map; name the folder of a map, or its map.json"),
    ],
)
def test_what_cannot_go_on_is_refused_in_one_line(
    recordings: list[Path], first: Path, tmp_path: Path, options: list[str], name: str, words: str
) -> None:
    start = first.parent / name
    done = echoplan("map", recordings[1], "--start", start, *options, "--out", tmp_path / "map")
    assert done.status == 2
    assert words in done.err
    assert done.err.count("\n") == 1
    assert not (tmp_path / "map").exists()


def test_a_recording_of_other_sensors_cannot_go_on_from_a_map(first: Path, tmp_path: Path) -> None:
    succeed("simulate", "square", "--rig", "ring-16", "--out", tmp_path / "ring")
    done = echoplan("map", tmp_path / "ring", "--start", first, "--out", tmp_path / "map")
    assert (done.status, done.err.count("\n")) == (2, 1)
    assert "ring: its sensors are not those of the map of --start; map it alone, or correct its rig.toml" in done.err


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        ("missing", "it is missing"),
        ("version", "it is of another version"),
        ("map", "it is of another map than map.json, or one of them was changed"),
    ],
)
def test_a_map_without_a_usable_prior_is_refused(
    recordings: list[Path], first: Path, tmp_path: Path, damage: str, words: str
) -> None:
    start = tmp_path / "start"
    shutil.copytree(first, start)
    if damage == "map":
        (start / "map.json").write_text((start / "map.json").read_text(encoding="utf-8") + " ", encoding="utf-8")
    else:
        (start / "prior.npz").unlink()
    if damage == "version":
        write_arrays(start / "prior.npz", {"version": np.array([99.0])})
    done = echoplan("map", recordings[1], "--start", start, "--out", tmp_path / "map")
    assert (done.status, done.err.count("\n")) == (2, 1)
    assert f"prior.npz: {words}" in done.err


# A room with a recess, two places of a cupboard in it, and where the robot stands on two days.
ROOM = Polyline(points_xy=np.array([[0, 0], [5, 0], [5, 4], [1.2, 4], [1.2, 3], [0.0, 3.0]]), closed=True)
IN_THE_OPEN = ([1.4, 1.4], [3.0, 2.2])
AROUND = [[1.6, 0.7], [3.2, 1.2], [4.4, 0.6], [4.3, 2.5], [3.6, 3.4], [2.4, 3.2], [1.7, 2.7], [0.7, 1.6]]
AROUND += [[1.9, 0.5], [3.4, 1.5]]
# Its front is part of the line of another wall, and many stations detect it on the first day.
IN_LINE = ([2.0, 3.0], [3.2, 0.6])
BEFORE = [[0.6, 0.7], [1.5, 1.0], [2.3, 0.8], [2.4, 1.6], [2.2, 2.3], [2.6, 2.4], [3.4, 2.2], [4.3, 2.6], [3.4, 3.4]]
BEFORE += [[4.2, 1.2], [1.0, 2.2]]
AFTER = [[0.7, 0.8], [1.4, 1.1], [2.25, 1.5], [2.5, 2.2], [3.4, 2.6], [4.3, 2.5], [4.4, 3.4], [1.0, 2.1]]


@pytest.mark.parametrize(
    ("places", "routes"), [(IN_THE_OPEN, (AROUND, AROUND)), (IN_LINE, (BEFORE, AFTER))], ids=["in the open", "in line"]
)
def test_a_cupboard_that_was_moved_is_reported(
    tmp_path: Path, places: tuple[list[float], list[float]], routes: tuple[list[list[float]], list[list[float]]]
) -> None:
    shape, folders = np.array([[0.0, 0.0], [0.8, 0.0], [0.8, 0.5], [0.0, 0.5]]), []
    cupboards = [shape + place for place in places]
    for day, (cupboard, route) in enumerate(zip(cupboards, routes, strict=True)):
        world = World(name="room", polylines=(ROOM, Polyline(points_xy=cupboard, closed=True)))
        rig, poses = builtin_rig("rotary-array"), np.array([[*place, 0.5 * turn] for turn, place in enumerate(route)])
        drive = Simulation(world=world, rig=rig, route=Route(map_from_base=poses), seed=day)
        folders.append(written(tmp_path / f"day{day}", list(drive), rig=rig, away=day * AWAY))
    succeed("map", folders[0], "--out", tmp_path / "before")
    printed = succeed("map", folders[1], "--start", tmp_path / "before", "--out", tmp_path / "after")
    (changes,) = read_map(tmp_path / "after").changes
    for pieces, cupboard in ((changes.gone_walls, cupboards[0]), (changes.new_walls, cupboards[1])):
        assert pieces
        assert all(Polygon(cupboard).exterior.distance(Point(ends.mean(axis=0))) < 0.02 for ends in pieces)
    assert "gone: a wall of" in " ".join(printed.split())
    assert "new: a wall of" in " ".join(printed.split())
