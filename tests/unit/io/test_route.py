"""Routes are stations or stamped ways."""

from pathlib import Path

import numpy as np
import pytest

from echoplan.arrays import IntArray
from echoplan.errors import InputError
from echoplan.io import read_route, write_route
from echoplan.model import Route


def read(tmp_path: Path, text: str) -> Route:
    path = tmp_path / "route.csv"
    path.write_text(text, encoding="utf-8")
    return read_route(path)


def test_stations_have_no_times(tmp_path: Path) -> None:
    route = read(tmp_path, "x,y,yaw\n0.5,1,-1.57\n0.75,1.25,9.42\n")
    assert route.stamps_ns is None
    assert route.map_from_base.tolist() == [[0.5, 1.0, -1.57], [0.75, 1.25, 9.42]]


def test_a_way_has_times(tmp_path: Path) -> None:
    route = read(tmp_path, "t,x,y,yaw\n1700000000.1,0.5,1,0\n1700000000.2,0.6,1,0\n")
    assert route.stamps_ns is not None
    assert route.stamps_ns.tolist() == [1_700_000_000_100_000_000, 1_700_000_000_200_000_000]


@pytest.mark.parametrize("stamps", [None, np.array([0, 1, 10**18])])
def test_a_route_survives_writing(tmp_path: Path, stamps: IntArray | None) -> None:
    poses = np.array([[0.1, -0.2, 1 / 3], [1e-9, 2.0, 7.0], [3.0, 0.0, -0.5]])
    write_route(tmp_path / "route.csv", Route(map_from_base=poses, stamps_ns=stamps))
    again = read_route(tmp_path / "route.csv")
    assert again.map_from_base.tolist() == poses.tolist()
    assert (again.stamps_ns is None) == (stamps is None)
    assert stamps is None or again.stamps_ns is None or again.stamps_ns.tolist() == stamps.tolist()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x,y\n1,2\n", r"route\.csv, line 1: the column 'yaw' is missing; the header must have x,y,yaw"),
        ("x,y,yaw\n0,0,0\n1,0,90\n", r"route\.csv, column yaw: the angles look like degrees; write radians"),
        ("x,y,yaw\n0,0,inf\n", r"line 2, column yaw: 'inf' is no number"),
        ("t,x,y,yaw\n2,0,0,0\n1,0,0,0\n", r"column t: the times of a route must increase; sort the rows by t"),
        ("x,y,yaw\n", r"it holds a header but no rows"),
        ("x,y,yaw\n0,0\n", r"line 2: the row has 2 fields, but the header 3"),
    ],
)
def test_an_invalid_route_is_refused(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        read(tmp_path, text)
