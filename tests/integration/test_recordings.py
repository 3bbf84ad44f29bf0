"""Recordings that others made are read to the last bit, survive a round trip, and are mapped."""

from dataclasses import replace
from functools import cache
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

from echoplan.evaluation import EvaluationSettings, MatchingSettings, evaluate
from echoplan.geometry import directions, wrap
from echoplan.io import read_recording, read_truth, write_recording, write_truth
from echoplan.joint.mapper import JointSettings
from echoplan.joint.settings import PoseMode
from echoplan.methods import METHODS, map_sweeps
from echoplan.model import FeatureMap, Recording, Rig, Sensor, Sweep
from echoplan.preprocessing.measurements import join_measurements, measurements_of
from echoplan.preprocessing.rays import share_of_ramps

DATA = Path(__file__).parents[2] / ".." / "shared" / "data"
NAMES = [
    *("arena-a", "arena-b", "corridor"),
    *(f"rooms/{name}" for name in ("paper", "room00", "room01", "room02", "oblique00", "oblique01", "drift00")),
    *(f"rooms/{name}" for name in ("drift01", "warm00", "single00", "ring00", "noisy00", "hcsr04_00")),
]


@pytest.fixture(params=NAMES)
def folder(request: pytest.FixtureRequest) -> Path:
    path = DATA / str(request.param)
    if not path.is_dir():
        pytest.skip(f"the recording {request.param} is not here")
    return path


def hand_turned(path: Path) -> Recording:
    """One HC-SR04 turned by hand: pairs of a compass bearing, clockwise, and a range."""
    rows = np.genfromtxt(path, delimiter=",", names=True)
    sensor = Sensor(sensor_id=0, half_aperture=0.26, min_range=0.02, max_range=4.0, resolution=0.003)
    sweep = Sweep(
        index=0,
        stamps_ns=np.arange(len(rows)) * 100_000_000,
        sensor_ids=np.zeros(len(rows), dtype=np.int64),
        servo_angles=-np.radians(rows["bearing_deg_cw"]),
        ranges=rows["sonar_m"],
        map_from_base=np.zeros((len(rows), 3)),
    )
    return Recording(name=path.stem, rig=Rig(name="turned by hand", sensors=(sensor,)), sweeps=(sweep,))


@cache
def map_of_arena(name: str, *, faced: bool, poses: PoseMode) -> FeatureMap:
    """The map that joint makes of an arena, with the headings as recorded or without; several tests ask about it."""
    recording = read_recording(DATA / name)
    kept = np.array([1.0, 1.0, 1.0 if faced else 0.0])
    sweeps = [replace(sweep, map_from_base=sweep.map_from_base * kept) for sweep in recording]
    return map_sweeps(METHODS["joint"].build(recording.rig, JointSettings(poses=poses)), sweeps)


# One of each kind; benchmarks/recordings.py and ``echoplan compare`` map all of them.
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", ["arena-b", "hcsr04-lidar/KalmanFilter.csv", "hcsr04-lidar/noKalmanFilter.csv"])
def test_every_method_maps_what_others_recorded(name: str, method: str) -> None:
    path = DATA / name
    if not path.exists():
        pytest.skip(f"the recording {name} is not here")
    recording = read_recording(path) if path.is_dir() else hand_turned(path)
    if (name, method) == ("arena-b", "joint"):
        found = map_of_arena(name, faced=True, poses=PoseMode.AUTO)
    else:
        found = map_sweeps(METHODS[method].build(recording.rig), recording)
    assert len(found.poses) == len(list(recording))
    assert np.isfinite(found.poses).all()
    assert all(np.isfinite([wall.normal_angle, wall.offset]).all() for wall in found.walls)


# Each map of an arena takes half a minute of CPU, so only some combinations are tested.
@pytest.mark.parametrize(
    ("name", "poses", "faced"),
    [
        ("arena-a", PoseMode.AUTO, True),
        ("arena-a", PoseMode.AUTO, False),
        ("arena-b", PoseMode.AUTO, True),
        ("arena-b", PoseMode.CORRECT, False),
    ],
)
def test_walls_of_an_arena_are_found_even_if_headings_were_not_recorded(
    name: str, poses: PoseMode, *, faced: bool
) -> None:
    if not (DATA / name).is_dir():
        pytest.skip(f"the recording {name} is not here")
    found, truth = map_of_arena(name, faced=faced, poses=poses), read_truth(DATA / name / "truth.json")
    walls = evaluate(found, truth, EvaluationSettings(matching=MatchingSettings(min_stations=1))).matches.walls
    assert walls.tally.found >= 0.85 * walls.tally.wanted
    assert walls.tally.right >= 0.9 * walls.tally.estimates
    # They stand along the axes that their waypoints were measured in.
    assert np.mean([each.distance for each in walls.right]) < 0.021
    assert np.degrees(np.mean([each.angle for each in walls.right])) < 0.1


def test_walls_of_an_arena_are_accurate_though_every_waypoint_is_off_by_five_centimetres() -> None:
    folder = DATA / "arena-b"
    if not folder.is_dir():
        pytest.skip("the recording arena-b is not here")
    recording, truth = read_recording(folder), read_truth(folder / "truth.json")
    rng, off = np.random.default_rng(10), 0.05
    ways = off * directions(rng.uniform(-np.pi, np.pi, len(list(recording))))
    elsewhere = np.column_stack([ways - ways.mean(axis=0), np.zeros(len(ways))])
    sweeps = [
        replace(sweep, map_from_base=(sweep.map_from_base + step) * [1.0, 1.0, 0.0])
        for sweep, step in zip(recording, elsewhere, strict=True)
    ]
    found = map_sweeps(METHODS["joint"].build(recording.rig), sweeps)
    walls = evaluate(found, truth, EvaluationSettings(matching=MatchingSettings(min_stations=1))).matches.walls
    assert walls.tally.found >= 0.85 * walls.tally.wanted
    assert np.degrees(np.mean([each.angle for each in walls.right])) < 1.7


def test_robots_faced_the_same_way_whichever_was_recorded() -> None:
    if not (DATA / "arena-a").is_dir():
        pytest.skip("the recording arena-a is not here")
    recording = read_recording(DATA / "arena-a")
    headings = [map_of_arena("arena-a", faced=faced, poses=PoseMode.AUTO).poses[:, 2] for faced in (True, False)]
    given = np.array([sweep.station[2] for sweep in recording])
    apart, before = (np.degrees(wrap(each - np.median(each))) for each in (headings[1] - headings[0], given))
    assert np.abs(before).max() > 6.0
    assert np.abs(apart).max() < 4.0


@pytest.mark.parametrize("name", [*NAMES, "hcsr04-lidar/KalmanFilter.csv", "hcsr04-lidar/noKalmanFilter.csv"])
def test_no_recording_of_sound_is_taken_for_rays(name: str) -> None:
    path = DATA / name
    if not path.exists():
        pytest.skip(f"the recording {name} is not here")
    recording = read_recording(path) if path.is_dir() else hand_turned(path)
    measurements = join_measurements([measurements_of(sweep, recording.rig) for sweep in recording])
    assert share_of_ramps(measurements) < 0.01


@pytest.fixture(scope="module")
def corridor() -> FeatureMap:
    """The first stretch of a corridor."""
    if not (DATA / "corridor").is_dir():
        pytest.skip("the recording corridor is not here")
    recording = read_recording(DATA / "corridor")
    mapper = METHODS["joint"].build(recording.rig, JointSettings(poses=PoseMode.AUTO))
    return map_sweeps(mapper, islice(recording, 140))


def test_the_sides_of_a_corridor_are_parallel_and_as_far_apart_as_lines_fitted_by_hand(corridor: FeatureMap) -> None:
    left, right = (
        max((wall for wall in corridor.walls if abs(wall.normal_angle - angle) < 0.1), key=lambda wall: wall.stations)
        for angle in (np.pi / 2, -np.pi / 2)
    )
    assert left.offset + right.offset == pytest.approx(2.12, abs=0.03)
    assert np.degrees(left.normal_angle - right.normal_angle) == pytest.approx(180.0, abs=0.5)


def test_only_odometry_gives_the_position_along_a_corridor(corridor: FeatureMap) -> None:
    found = corridor.parameters["found"]
    assert isinstance(found, dict)
    assert found["undetermined"]
    for way in found["undetermined"]:
        # The ellipse may lean a little: what counts is how wide it is along the corridor and across it.
        cosine, sine = np.cos(way["direction"]), np.sin(way["direction"])
        along = np.hypot(way["along"] * cosine, way["across"] * sine)
        across = np.hypot(way["along"] * sine, way["across"] * cosine)
        assert along > 4 * across


def test_a_recording_is_what_its_rows_say(folder: Path) -> None:
    recording = read_recording(folder)
    rows = np.genfromtxt(folder / "pings.csv", delimiter=",", names=True)
    sweeps = list(recording)
    assert len(sweeps) == len(recording) == len(np.unique(rows["sweep"]))
    np.testing.assert_array_equal(np.concatenate([sweep.ranges for sweep in sweeps]), rows["range"])
    np.testing.assert_array_equal(np.concatenate([sweep.servo_angles for sweep in sweeps]), rows["servo"])
    np.testing.assert_array_equal(np.concatenate([sweep.sensor_ids for sweep in sweeps]), rows["sensor"])
    np.testing.assert_array_equal(np.concatenate([sweep.stamps_ns for sweep in sweeps]), np.rint(1e9 * rows["t"]))
    poses = np.stack([rows["x"], rows["y"], rows["yaw"]], axis=1)
    np.testing.assert_array_equal(np.concatenate([sweep.map_from_base for sweep in sweeps]), poses)


def test_a_recording_survives_a_round_trip(folder: Path, tmp_path: Path) -> None:
    recording = read_recording(folder)
    write_recording(tmp_path / "copy", recording)
    again = read_recording(tmp_path / "copy")
    assert again.rig.sensors == recording.rig.sensors
    for one, other in zip(recording, again, strict=True):
        assert (one.index, one.stamps_ns.tolist(), one.sensor_ids.tolist()) == (
            other.index,
            other.stamps_ns.tolist(),
            other.sensor_ids.tolist(),
        )
        for name in ("servo_angles", "ranges", "map_from_base"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_a_truth_survives_a_round_trip(folder: Path, tmp_path: Path) -> None:
    if not (folder / "truth.json").exists():
        pytest.skip("this place was not surveyed")
    truth = read_truth(folder / "truth.json")
    write_truth(tmp_path / "truth.json", truth)
    again = read_truth(tmp_path / "truth.json")
    for name in ("walls_xy", "walls_detected_by", "cylinders", "cylinders_detected_by", "poses", "given"):
        np.testing.assert_array_equal(getattr(truth, name), getattr(again, name))
    assert again.temperature == truth.temperature
    assert len(truth.poses) == len(read_recording(folder))
