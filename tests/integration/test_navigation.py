"""Maps for path planners, from echoes to the files that Nav2 and MRPT read."""

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from echoplan.arrays import IntArray
from echoplan.evaluation import score_grid, true_grid
from echoplan.grids import grid_from_map
from echoplan.io import write_grid
from echoplan.joint.mapper import JointMapper
from echoplan.methods import map_sweeps
from echoplan.model import OccupancyGrid
from echoplan.simulation import Simulation
from echoplan.sources import open_source
from helpers.planning import TWO_ROOMS, path_exists

MRPT = Path(__file__).parents[2] / "benchmarks" / "mrpt"


def nav2_cells(path: Path) -> IntArray:
    """Read a map as map_io.cpp of nav2_map_server does in trinary mode: 100 occupied, 0 free, -1 unknown."""
    entries = dict(re.findall(r"^(\w+): (.+)$", path.read_text(encoding="utf-8"), flags=re.MULTILINE))
    assert (entries["mode"], entries["negate"]) == ("trinary", "0")
    _, size, depth, data = (path.parent / entries["image"]).read_bytes().split(b"\n", 3)
    columns, rows = map(int, size.split())
    shades = np.frombuffer(data, dtype=np.uint8).reshape(rows, columns) / float(depth)
    occupancy = 1.0 - shades
    cells = np.full((rows, columns), -1)
    cells[occupancy < float(entries["free_thresh"])] = 0
    cells[occupancy > float(entries["occupied_thresh"])] = 100
    # The first row of the picture is the top of the map.
    return np.flipud(cells)


def trinary(grid: OccupancyGrid) -> IntArray:
    """Cells as a planner should get them."""
    return np.select([grid.values == 1.0, grid.values == 0.0], [100, 0], -1)


def test_nav2_reads_the_cells_of_the_map(tmp_path: Path) -> None:
    grid = grid_from_map(TWO_ROOMS)
    write_grid(tmp_path / "map.yaml", grid)
    assert set(np.unique(trinary(grid)).tolist()) == {-1, 0, 100}
    assert np.array_equal(nav2_cells(tmp_path / "map.yaml"), trinary(grid))


def test_mrpt_reads_the_cells_of_the_map(tmp_path: Path) -> None:
    if shutil.which("cmake") is None:
        pytest.skip("cmake is not installed")
    build = tmp_path / "build"
    configured = subprocess.run(["cmake", "-S", str(MRPT), "-B", str(build)], check=False, capture_output=True)
    if configured.returncode:
        pytest.skip("MRPT or a C++ compiler is not installed (Debian: libmrpt-maps-dev g++)")
    subprocess.run(["cmake", "--build", str(build), "--target", "cells"], check=True, capture_output=True)
    grid = grid_from_map(TWO_ROOMS)
    write_grid(tmp_path / "map.yaml", grid)
    command = [str(build / "cells"), str(tmp_path / "map.yaml")]
    head, *rows = subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()
    assert [float(each) for each in head.split()] == pytest.approx([0.05, *grid.origin_xy], abs=1e-6)
    cells = np.array([[{"#": 100, " ": 0, "?": -1}[cell] for cell in row] for row in rows])
    assert np.array_equal(cells, trinary(grid))


def test_a_robot_finds_its_way_through_the_doors_of_a_flat_and_none_out_of_it() -> None:
    flat = open_source("sim:two-room-flat,seed=1")
    assert isinstance(flat, Simulation)
    sweeps = tuple(flat)
    found = map_sweeps(JointMapper(flat.rig), sweeps)
    for grid in (grid_from_map(found, rig=flat.rig, sweeps=sweeps), grid_from_map(found)):
        assert path_exists(grid, found.poses[0, :2], found.poses[-1, :2])
        # Beyond the middle of the outer wall on each side of the flat.
        outside = [[-0.2, 2.5], [1.5, 4.2], [7.2, 2.5], [2.5, -0.2]]
        assert not any(path_exists(grid, found.poses[0, :2], point, radius=0.0) for point in outside)
        assert score_grid(grid, flat.truth, reach=float(flat.rig.max_ranges.max())).free < 0.05
        true = true_grid(flat.truth, grid).values
        assert np.mean(true[grid.values == 0.0] == 0.0) > 0.95
