"""Version 1 of the formats, kept in files: what was written once must be read, and written, for ever."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from echoplan.io import (
    read_map,
    read_recording,
    read_rig,
    read_route,
    read_truth,
    read_world,
    write_map,
    write_recording,
    write_rig,
    write_route,
    write_truth,
    write_world,
)

FOLDER = Path(__file__).parent / "formats"
FORMATS: dict[str, tuple[Callable[[Path | str], Any], Callable[[Path | str, Any], None]]] = {
    "recording/rig.toml": (read_rig, write_rig),
    "world.toml": (read_world, write_world),
    "stations.csv": (read_route, write_route),
    "way.csv": (read_route, write_route),
    "truth.json": (read_truth, write_truth),
    "map.json": (read_map, write_map),
    "map-openings.json": (read_map, write_map),
}


@pytest.mark.parametrize("name", FORMATS)
def test_what_is_read_is_written_as_it_stood(name: str, tmp_path: Path) -> None:
    read, write = FORMATS[name]
    write(tmp_path / "again", read(FOLDER / name))
    assert (tmp_path / "again").read_bytes() == (FOLDER / name).read_bytes()


def test_files_may_be_selected_by_their_names(tmp_path: Path) -> None:
    for name, (read, write) in FORMATS.items():
        write(str(tmp_path / "again"), read(str(FOLDER / name)))
        assert (tmp_path / "again").read_bytes() == (FOLDER / name).read_bytes()
    write_recording(str(tmp_path), read_recording(str(FOLDER / "recording")))
    assert (tmp_path / "pings.csv").read_bytes() == (FOLDER / "recording" / "pings.csv").read_bytes()


def test_a_recording_is_written_as_it_stood(tmp_path: Path) -> None:
    write_recording(tmp_path, read_recording(FOLDER / "recording"))
    for name in ("pings.csv", "rig.toml"):
        assert (tmp_path / name).read_bytes() == (FOLDER / "recording" / name).read_bytes()


def test_a_recording_means_what_it_meant() -> None:
    first, second = read_recording(FOLDER / "recording")
    assert (first.index, second.index) == (2, 5)
    assert first.stamps_ns.tolist() == [
        1_763_700_000_025_000_000,
        1_763_700_000_025_000_000,
        1_763_700_000_050_000_010,
    ]
    assert first.sensor_ids.tolist() == [7, 9, 7]
    assert first.servo_angles[0] == -0.785398
    np.testing.assert_array_equal(first.ranges, [1.29, np.inf, -np.inf])
    np.testing.assert_array_equal(second.ranges, [np.nan, 0.1 + 0.2])
    assert second.map_from_base.tolist() == [[-2.24823, 3.27315, 11.740973], [-2.24823, 3.27315, 1e-5]]


def test_a_rig_means_what_it_meant() -> None:
    rig = read_rig(FOLDER / "recording" / "rig.toml")
    assert rig.name == 'two of "four"'
    assert rig.base_from_turret.tolist() == [0.1, -0.02, 3.0]
    second = rig.sensors[1]
    assert (second.sensor_id, second.x, second.y, second.yaw) == (9, -0.05, 0.001, 3.141593)
    assert (second.half_aperture, second.min_range, second.max_range, second.resolution) == (0.523599, 0.02, 4.0, 0.003)
    assert rig.firing is not None
    assert rig.firing.groups == ((7, 9), (9,))
    assert rig.transducer is not None
    assert rig.transducer.figure_of_merit == 30.0


def test_a_world_and_a_route_mean_what_they_meant() -> None:
    world = read_world(FOLDER / "world.toml")
    assert world.segments_xy.shape == (5, 2, 2)
    assert world.polylines[1].points_xy.tolist() == [[1.0, 1.0], [1.5, 1.25]]
    assert world.discs.tolist() == [[3.0, 1.0, 0.1]]
    way = read_route(FOLDER / "way.csv")
    assert way.map_from_base.tolist() == [[0.6, 0.7, 0.2], [1.4, -0.7, 9.42]]
    assert way.stamps_ns is not None
    assert way.stamps_ns.tolist() == [-500_000_000, 1_763_700_000_000_000_001]


def test_a_truth_and_a_map_mean_what_they_meant() -> None:
    truth = read_truth(FOLDER / "truth.json")
    assert truth.walls_xy[1].tolist() == [[4.0, 0.0], [4.0, 2.5]]
    assert truth.given[1].tolist() == [0.76, 0.24, 1.61]
    found = read_map(FOLDER / "map.json")
    assert found.frame == "odom"
    assert found.walls[0].covariance.tolist() == [[1e-6, 2e-7], [2e-7, 4e-6]]
    assert found.walls[0].class_probabilities.cylinder == 0.01
    assert found.corners[0].class_probabilities.corner == 0.75
    assert found.cylinders[0].center_xy.tolist() == [3.2, 1.0]
    assert found.sweeps.tolist() == [2, 5]


def test_openings_mean_what_they_meant() -> None:
    assert read_map(FOLDER / "map.json").openings == ()
    found = read_map(FOLDER / "map-openings.json")
    np.testing.assert_array_equal(found.walls[0].endpoint_sigmas, [np.nan, 0.015])
    assert found.walls[1].inferred.tolist() == [0.0, 0.35]
    driven, seen = found.openings
    assert driven.endpoints_xy.tolist() == [[1.5, 0.0], [2.4, 0.0]]
    assert (driven.width_sigma, driven.walls, driven.passed) == (0.02, (0, 1), True)
    assert (seen.walls, seen.passed) == ((1,), False)
    assert found.unobserved[0].endpoints_xy.tolist() == [[4.0, 0.5], [4.0, 1.25]]
    assert found.unobserved[0].walls == (2, 2)
