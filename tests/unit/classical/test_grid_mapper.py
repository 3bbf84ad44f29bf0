from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from pydantic import ValidationError

from echoplan.arrays import BoolArray, FloatArray
from echoplan.classical.grid_mapper import GridMapper
from echoplan.classical.grids import CanvasSettings
from echoplan.errors import InvalidValueError
from echoplan.evaluation import evaluate
from echoplan.geometry import directions
from echoplan.methods import METHODS
from echoplan.model import Sweep, Truth
from helpers import scenes

GRIDS = [method for name, method in METHODS.items() if name.startswith("grid-")]
WIDTH, DEPTH = 3.0, 2.0
STATIONS = [(0.7, 0.6), (1.5, 1.0), (2.4, 0.7), (2.2, 1.5), (0.8, 1.4)]
ROOM = np.array([[0.0, 0.0], [WIDTH, 0.0], [WIDTH, DEPTH], [0.0, DEPTH]])
TRUTH = Truth(walls_xy=np.stack([ROOM, np.roll(ROOM, -1, axis=0)], axis=1), walls_detected_by=np.full(4, 5))


@pytest.fixture(params=GRIDS, ids=[method.name for method in GRIDS])
def build(request: pytest.FixtureRequest) -> Callable[[], GridMapper]:
    """Each method of grids in turn."""

    def made() -> GridMapper:
        mapper = request.param.build(scenes.rig()).mapper
        assert isinstance(mapper, GridMapper)
        return mapper

    return made


def rough_sweep(station: tuple[float, float], *, index: int = 0) -> Sweep:
    """What the array reads of walls that scatter sound: the nearest point within the beam, at any incidence."""
    bearings = np.radians(np.arange(360) - 45.0)
    origins = station + scenes.ARM * directions(bearings)
    rays = bearings[:, None] + np.linspace(-0.6, 0.6, 61)
    return scenes.sweep_of(depths(origins, rays).min(axis=1), index=index, pose=(*station, 0.0))


def some_of(sweep: Sweep, chosen: slice | BoolArray) -> Sweep:
    """Some of the pings of a sweep."""
    return Sweep(
        index=sweep.index,
        stamps_ns=sweep.stamps_ns[chosen],
        sensor_ids=sweep.sensor_ids[chosen],
        servo_angles=sweep.servo_angles[chosen],
        ranges=sweep.ranges[chosen],
        map_from_base=sweep.map_from_base[chosen],
    )


def depths(origins_xy: FloatArray, rays: FloatArray) -> FloatArray:
    """How far it is from points in the room to its walls."""
    x, y = (origins_xy[:, axis, None] for axis in (0, 1))
    with np.errstate(divide="ignore"):
        along = np.where(np.cos(rays) > 0, WIDTH - x, -x) / np.cos(rays)
        across = np.where(np.sin(rays) > 0, DEPTH - y, -y) / np.sin(rays)
    return np.minimum(along, across)


def test_a_rough_room_is_empty_inside_and_walled_about(build: Callable[[], GridMapper]) -> None:
    mapper = build()
    for index, station in enumerate(STATIONS):
        mapper.add(rough_sweep(station, index=index))
    grid = mapper.grid
    centers = grid.centers_xy
    inside = ((centers > 0.3) & (centers < [WIDTH - 0.3, DEPTH - 0.3])).all(axis=-1)
    outside = ((centers < -0.15) | (centers > [WIDTH + 0.15, DEPTH + 0.15])).any(axis=-1)
    # What takes walls for mirrors does not assume that a beam which came through met nothing.
    assert (grid.values[inside] < 0.5).mean() > (0.5 if mapper.method == "grid-muriel" else 0.95)
    assert (grid.values[outside] >= 0.5).mean() > 0.9
    walls = evaluate(mapper.result(), TRUTH).matches.walls
    assert walls.tally.found == 4
    assert max(match.distance for match in walls.right) < 0.06


def test_without_valid_readings_the_map_is_unknown(build: Callable[[], GridMapper]) -> None:
    sweep = rough_sweep(STATIONS[0])
    for reading in (np.nan, -np.inf):
        mapper = build()
        assert mapper.grid.values.tolist() == [[0.5]]
        mapper.add(replace(sweep, ranges=np.full(len(sweep), reading)))
        mapper.add(some_of(sweep, slice(0)))
        assert mapper.grid.values.tolist() == [[0.5]]
        assert mapper.result().walls == ()


def test_silence_calls_no_cell_occupied(build: Callable[[], GridMapper]) -> None:
    mapper = build()
    sweep = rough_sweep(STATIONS[0])
    mapper.add(replace(sweep, ranges=np.full(len(sweep), np.inf)))
    assert mapper.grid.values.max() <= 0.5


def test_readings_that_say_nothing_change_nothing(build: Callable[[], GridMapper]) -> None:
    sweep = rough_sweep(STATIONS[0])
    spoilt = np.arange(len(sweep)) % 3 == 0
    fewer = some_of(sweep, ~spoilt)
    ranges = sweep.ranges.copy()
    ranges[spoilt] = np.resize([np.nan, -np.inf, 0.01], spoilt.sum())
    grids = []
    for reduced in (fewer, replace(sweep, ranges=ranges)):
        mapper = build()
        mapper.add(reduced)
        grids.append(mapper.grid)
    assert np.array_equal(grids[0].values, grids[1].values)


def test_one_ping_makes_a_map(build: Callable[[], GridMapper]) -> None:
    mapper = build()
    mapper.add(some_of(scenes.sweep_of(np.ones(360)), slice(1)))
    grid = mapper.grid
    assert grid.values.min() < 0.5 < grid.values.max()
    occupied = grid.centers_xy[grid.values == grid.values.max()]
    bearing = np.radians(-45.0)
    assert np.abs(np.hypot(*(occupied - scenes.ARM * directions(bearing)).T) - 1.0).max() < 0.1


@pytest.mark.parametrize("far", [1e3, 1e30])
def test_a_pose_far_away_is_refused_before_memory_is_full(build: Callable[[], GridMapper], far: float) -> None:
    mapper = build()
    mapper.add(rough_sweep(STATIONS[0]))
    with pytest.raises(InvalidValueError, match="check the poses or choose a greater resolution"):
        draw(mapper, scenes.sweep_of(np.ones(360), index=1, pose=(far, far, 0.0)))


def draw(mapper: GridMapper, sweep: Sweep) -> None:
    """Some rules draw what is added, others when they are asked."""
    mapper.add(sweep)
    assert mapper.grid.values.size


def test_finer_cells_cover_the_same_ground() -> None:
    areas = []
    for resolution in (0.1, 0.05):
        method = METHODS["grid-bayes"]
        settings = method.settings_type.model_validate({"canvas": CanvasSettings(resolution=resolution)})
        mapper = method.build(scenes.rig(), settings).mapper
        assert isinstance(mapper, GridMapper)
        mapper.add(rough_sweep(STATIONS[1]))
        areas.append(resolution**2 * (mapper.grid.values < 0.5).sum())
    assert areas[0] == pytest.approx(areas[1], rel=0.05)
    assert 3.0 < areas[1] < WIDTH * DEPTH


def test_asking_for_the_grid_changes_nothing(build: Callable[[], GridMapper]) -> None:
    asked, silent = build(), build()
    for index, station in enumerate(STATIONS[:3]):
        for mapper in (asked, silent):
            mapper.add(rough_sweep(station, index=index))
        assert asked.grid.values.size
    assert np.array_equal(asked.grid.values, silent.grid.values)
    assert asked.grid.origin_xy.tolist() == silent.grid.origin_xy.tolist()


def test_a_stricter_threshold_leaves_fewer_walls() -> None:
    found = []
    for occupied in (0.65, 0.999):
        method = METHODS["grid-muriel"]
        settings = method.settings_type.model_validate({"features": {"occupied": occupied}})
        mapper = method.build(scenes.rig(), settings).mapper
        for index, station in enumerate(STATIONS):
            mapper.add(rough_sweep(station, index=index))
        feature_map = mapper.result()
        assert feature_map.parameters["features"]["occupied"] == occupied  # type: ignore[index]
        found.append(len(feature_map.walls))
    assert found[0] > found[1]


@pytest.mark.parametrize(
    ("name", "rule", "message"),
    [
        ("grid-bayes", {"occupied": 0.5}, "greater than 0.5"),
        ("grid-bayes", {"free": 0.5}, "less than 0.5"),
        ("grid-bayes", {"thickness": 0.0}, "greater than 0"),
        ("grid-elfes", {"range_error": -0.1}, "greater than 0"),
        ("grid-elfes", {"max_range": 0.0}, "greater than 0"),
        ("grid-muriel", {"detection_probability": 1.0}, "less than 1"),
        ("grid-muriel", {"clutter_density": 0.0}, "greater than 0"),
        ("grid-cemal", {"min_relative_fit": 0.0}, "greater than 0"),
        ("grid-cemal", {"thicknes": 0.1}, "Extra inputs are not permitted"),
        ("grid-range-layer", {"phi": 0.0}, "greater than 0"),
    ],
)
def test_settings_without_a_meaning_are_refused(name: str, rule: dict[str, float], message: str) -> None:
    with pytest.raises(ValidationError, match=message):
        METHODS[name].settings_type.model_validate({"rule": rule})
