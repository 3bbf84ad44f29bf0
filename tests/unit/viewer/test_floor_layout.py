"""What a floor plan states, and where: numbers as in the tables, nothing over anything else."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from echoplan.model import FeatureMap
from echoplan.viewer.floor_layout import FloorLayout, floor_layout
from echoplan.viewer.tables import cylinder_table, opening_table, wall_table
from helpers import maps
from helpers.drawings import STATIONS, gapped_map

SQUARE = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]])


def room(corners: np.typing.ArrayLike = SQUARE) -> FeatureMap:
    """A closed room with stations inside."""
    points = np.array(corners)
    walls = [maps.wall(start, end) for start, end in zip(points, np.roll(points, -1, axis=0), strict=True)]
    middle = points.mean(axis=0)
    return maps.drawn(*walls, maps.cylinder(middle + 0.8, 0.1), poses=[[*middle, 0.0], [*(middle + 0.3), 0.0]])


def layout(found: FeatureMap) -> FloorLayout:
    return floor_layout(found, foot=32.0)


def texts(made: FloorLayout, kind: str) -> list[str]:
    return [label.text for label in made.labels if label.kind == kind]


def test_walls_openings_and_cylinders_have_the_numbers_of_the_tables() -> None:
    found = replace(gapped_map(), cylinders=(maps.cylinder([2.0, 2.0], 0.1), maps.cylinder([4.0, 2.0], 0.25)))
    made = layout(found)
    assert sorted(texts(made, "wall")) == [row[0] for row in wall_table(found.walls).rows]
    widths = {row[0]: row[1].split()[0] for row in opening_table(found.openings).rows}
    assert {text[1:].split()[0]: text.split()[1] + "0" for text in texts(made, "opening")} == widths
    radii = {row[0]: float(row[3]) for row in cylinder_table(found.cylinders).rows}
    diameters = [text.split() for text in texts(made, "cylinder")]
    assert {number[1:]: float(diameter[1:]) / 2 for number, diameter in diameters} == radii


def test_a_number_stands_beside_its_wall_on_the_side_of_the_robot() -> None:
    found = room()
    made = layout(found)
    for label in made.labels:
        if label.kind == "wall":
            face = made.sheet.on_paper(found.walls[int(label.text)].endpoints_xy)
            way = (face[1] - face[0]) / np.hypot(*(face[1] - face[0]))
            away = way[0] * (label.middle - face[0])[1] - way[1] * (label.middle - face[0])[0]
            # The room runs counter-clockwise: its inside is to the left of every wall.
            assert 0.0 < away < 5.0


def test_a_closed_room_states_its_area() -> None:
    assert texts(layout(room()), "area") == ["12.00 m\N{SUPERSCRIPT TWO}"]
    first, *rest = room().walls
    inferred = replace(room(), walls=(replace(first, inferred=np.array([0.5, 0.0])), *rest))
    assert texts(layout(inferred), "area") == ["\N{ALMOST EQUAL TO} 12.00 m\N{SUPERSCRIPT TWO}"]


def test_an_open_room_states_no_area() -> None:
    assert texts(layout(replace(room(), walls=room().walls[:3])), "area") == []


def test_the_outside_has_a_dimension_at_each_wall() -> None:
    made = layout(room())
    assert sorted(each.text for each in made.dimensions) == ["3.00", "3.00", "4.00", "4.00"]
    low, high = made.sheet.on_paper([[0.0, 0.0], [4.0, 3.0]])
    for each in made.dimensions:
        x, y = each.line.mean(axis=0)
        assert not (low[0] < x < high[0] and low[1] < y < high[1])
        length = float(np.hypot(*(each.line[1] - each.line[0]))) / made.sheet.millimetres
        assert length == pytest.approx(float(each.text))


def test_a_row_of_walls_and_openings_has_one_row_of_dimensions_and_a_second_for_all() -> None:
    made = layout(gapped_map())
    levels: dict[float, list[str]] = {}
    for each in made.dimensions:
        levels.setdefault(round(float(each.line[0, 1]), 6), []).append(each.text)
    near, far = (levels[level] for level in sorted(levels, reverse=True))
    least = "\N{GREATER-THAN OR EQUAL TO}"
    assert sorted(near) == sorted([f"{least} 1.00", "0.90", f"{least} 1.10", f"{least} 0.75", "(1.50)"])
    assert far == [f"({least} 6.00)"]


def test_lengths_have_no_sign_where_the_method_does_not_estimate_ends() -> None:
    found = maps.drawn(maps.wall([0.0, 0.0], [3.0, 0.0]), poses=[[1.0, 1.0, 0.0]])
    assert [each.text for each in layout(found).dimensions] == ["3.00"]


def test_walls_inside_the_building_have_their_dimension_inside_a_room_and_only_once() -> None:
    partition = [maps.wall([2.0, 0.0], [2.0, 2.0]), maps.wall([2.1, 2.0], [2.1, 0.0])]
    outside = room().walls
    stations = [[1.0, 1.0, 0.0], [1.2, 1.5, 0.0], [3.0, 1.0, 0.0], [3.2, 1.5, 0.0]]
    made = layout(maps.drawn(*outside, *partition, poses=stations))
    assert texts(made, "area") == ["12.00 m\N{SUPERSCRIPT TWO}"]
    assert sorted(each.text for each in made.dimensions) == ["2.00", "3.00", "3.00", "4.00", "4.00"]


def test_a_partition_is_as_thick_as_its_faces_are_apart_and_other_walls_as_drawings_have_them() -> None:
    partition = [maps.wall([2.0, 0.5], [2.0, 2.0]), maps.wall([2.25, 2.0], [2.25, 0.5])]
    stations = [[1.0, 1.0, 0.0], [3.0, 1.0, 0.0]]
    made = layout(maps.drawn(*room().walls, *partition, poses=stations))
    thick = [float(np.ptp(body, axis=0).min()) for body in made.bodies]
    assert thick == pytest.approx([0.1, 0.1, 0.1, 0.1, 0.25, 0.25])


@pytest.mark.parametrize("seed", range(4))
def test_no_dimension_or_label_lies_over_another_or_outside_the_window(seed: int) -> None:
    rng = np.random.default_rng(seed)
    starts = rng.uniform(0.0, 8.0, (40, 2))
    walls = [maps.wall(start, start + rng.normal(size=2)) for start in starts]
    columns = [maps.cylinder(center, 0.1) for center in rng.uniform(0.0, 8.0, (5, 2))]
    made = layout(maps.drawn(*walls, *columns, poses=STATIONS))
    assert len(made.footprints) > 40
    for one, other in combinations(made.footprints, 2):
        assert not one.intersects(other)
    left, low, right, high = np.array([each.bounds for each in made.footprints]).T
    window = made.sheet.window
    assert (left.min() >= window[0, 0], low.min() >= window[0, 1]) == (True, True)
    assert (right.max() <= window[1, 0], high.max() <= window[1, 1]) == (True, True)


def test_crowded_walls_lose_their_numbers_and_not_the_drawing() -> None:
    walls = [maps.wall([x, 0.0], [x + 0.02, 0.0]) for x in np.arange(0.0, 3.0, 0.03)]
    made = layout(maps.drawn(*walls, poses=[[1.0, 1.0, 0.0]]))
    assert len(made.bodies) == len(walls)
    assert 20 < len(texts(made, "wall")) < len(walls)
