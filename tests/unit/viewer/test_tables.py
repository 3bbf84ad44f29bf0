from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from echoplan.model import ClassProbabilities, Corner, CornerKind, Cylinder, Table, Wall
from echoplan.viewer.tables import corner_table, cylinder_table, opening_table, wall_table
from echoplan.viewer.wording import SIGMA
from helpers.drawings import gapped_map

WALL = Wall(
    normal_angle=-np.pi / 2,
    offset=-2.0,
    endpoints_xy=np.array([[-1.0, 2.0], [2.5, 2.0]]),
    covariance=np.diag([0.0, 0.004**2]),
    class_probabilities=ClassProbabilities(wall=0.87, cylinder=0.12, corner=0.01),
    pings=412,
    stations=6,
)
CORNER = Corner(
    position_xy=np.array([-0.25, 3.1234]),
    kind=CornerKind.CONVEX,
    # Its long axis lies between the directions of the coordinates.
    covariance=np.array([[2.5e-6, 1.5e-6], [1.5e-6, 2.5e-6]]),
    class_probabilities=ClassProbabilities(corner=0.6, wall=0.4),
    pings=12,
    stations=3,
)
CYLINDER = Cylinder(
    center_xy=np.array([3.2, 1.0]),
    radius=0.1,
    covariance=np.diag([0.004**2, 0.002**2, 0.0015**2]),
    class_probabilities=ClassProbabilities(cylinder=0.755, corner=0.245),
    pings=30,
    stations=4,
)


def row(table: Table, number: int = 0) -> dict[str, str]:
    """A row by the heads of its columns."""
    return dict(zip(table.columns, table.rows[number], strict=True))


@pytest.mark.parametrize(
    ("tabulate", "title"),
    [(wall_table, "Walls"), (opening_table, "Openings"), (corner_table, "Corners"), (cylinder_table, "Cylinders")],
)
def test_nothing_found_is_a_table_without_rows(tabulate: Callable[[Sequence[Any]], Table], title: str) -> None:
    table = tabulate([])
    assert table.title == title
    assert table.rows == ()
    assert len(set(table.columns)) == len(table.columns)


def test_every_row_of_a_wall_has_lengths_in_metres_and_deviations_in_millimetres() -> None:
    assert row(wall_table([WALL])) == {
        "wall": "0",
        "length (m)": "3.500",
        "normal (°)": "-90.0",
        "offset (m)": "-2.000",
        f"{SIGMA} across (mm)": "4.0",
        "wall (%)": "87",
        "pings": "412",
        "stations": "6",
    }


def test_walls_are_numbered_as_in_the_map() -> None:
    table = wall_table([WALL, replace(WALL, pings=7)])
    assert [each[0] for each in table.rows] == ["0", "1"]
    assert row(table, 1)["pings"] == "7"


def test_the_deviation_of_a_wall_is_that_in_its_middle() -> None:
    turning = replace(WALL, covariance=np.diag([0.01**2, 0.0]))
    # The middle is 0.75 m along the line from the foot of the origin.
    assert row(wall_table([turning]))[f"{SIGMA} across (mm)"] == "7.5"


def test_a_corner_has_its_place_its_kind_and_the_deviation_along_its_long_axis() -> None:
    assert row(corner_table([CORNER])) == {
        "corner": "0",
        "x (m)": "-0.250",
        "y (m)": "3.123",
        "kind": "convex",
        f"{SIGMA} (mm)": "2.0",
        "corner (%)": "60",
        "pings": "12",
        "stations": "3",
    }


def test_a_cylinder_has_its_place_its_radius_and_the_deviations_of_both() -> None:
    assert row(cylinder_table([CYLINDER])) == {
        "cylinder": "0",
        "x (m)": "3.200",
        "y (m)": "1.000",
        "radius (m)": "0.100",
        f"{SIGMA} centre (mm)": "4.0",
        f"{SIGMA} radius (mm)": "1.5",
        "cylinder (%)": "76",
        "pings": "30",
        "stations": "4",
    }


def test_the_radius_does_not_make_the_centre_less_sure() -> None:
    vague = replace(CYLINDER, covariance=np.diag([0.004**2, 0.002**2, 9.0]))
    written = row(cylinder_table([vague]))
    assert (written[f"{SIGMA} centre (mm)"], written[f"{SIGMA} radius (mm)"]) == ("4.0", "3000.0")


def test_a_feature_that_no_ping_speaks_for_has_noughts_and_no_blanks() -> None:
    bare = Corner(position_xy=np.zeros(2), kind=CornerKind.CONCAVE, covariance=np.zeros((2, 2)))
    assert corner_table([bare]).rows == (("0", "0.000", "0.000", "concave", "0.0", "100", "0", "0"),)


def test_an_opening_has_its_width_with_the_95_percent_interval_its_middle_and_its_evidence() -> None:
    table = opening_table(gapped_map().openings)
    assert row(table) == {
        "opening": "0",
        "width, 95 % (m)": "0.900 ± 0.039",
        "x (m)": "1.450",
        "y (m)": "0.000",
        "walls": "0, 1",
        "evidence": "driven through",
    }
    assert row(table, 1)["evidence"] == "seen through"
