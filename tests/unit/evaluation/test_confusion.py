import numpy as np
import pytest

from echoplan.arrays import IntArray
from echoplan.evaluation import MAP_CLASSES, TRUE_CLASSES, evaluate
from echoplan.evaluation.confusion import no_confusion
from echoplan.model import Corner, Cylinder, Truth, Wall
from helpers import maps

# Of the room, these are wanted: five walls, four corners, one cylinder.
ALL_MISSED = {("wall", "missed"): 5, ("corner", "missed"): 4, ("cylinder", "missed"): 1}


def confusion(*features: Wall | Corner | Cylinder, truth: Truth = maps.ROOM) -> IntArray:
    return evaluate(maps.drawn(*features), truth).confusion


def counts(matrix: IntArray) -> dict[tuple[str, str], int]:
    """What is not zero, by its names."""
    return {(TRUE_CLASSES[row], MAP_CLASSES[column]): int(matrix[row, column]) for row, column in np.argwhere(matrix)}


def test_rows_are_the_truth_and_columns_the_map() -> None:
    assert TRUE_CLASSES == ("wall", "corner", "cylinder", "none")
    assert MAP_CLASSES == ("wall", "corner", "cylinder", "missed")


def test_an_empty_map_misses_all_that_is_wanted() -> None:
    assert counts(confusion()) == ALL_MISSED


def test_what_is_right_is_on_the_diagonal() -> None:
    matrix = confusion(maps.wall((1, 0), (2, 0)), maps.corner((5, 0)), maps.cylinder((3.5, 0.6), 0.1))
    assert counts(matrix) == {
        ("wall", "wall"): 1,
        ("corner", "corner"): 1,
        ("cylinder", "cylinder"): 1,
        ("wall", "missed"): 4,
        ("corner", "missed"): 3,
    }


@pytest.mark.parametrize(
    ("feature", "cell"),
    [
        (maps.cylinder((3.0, 0.25), 0.16), ("wall", "cylinder")),  # its surface 9 cm off the bottom wall
        (maps.corner((3.0, -0.09)), ("wall", "corner")),
        (maps.cylinder((5.2, -0.2), 0.15), ("corner", "cylinder")),  # its surface 13 cm off the vertex
        (maps.wall((4.9, -0.1), (5.1, 0.1)), ("corner", "wall")),  # across a corner, at 45 degrees
        (maps.corner((3.5, 0.8)), ("cylinder", "corner")),  # 10 cm off the surface
        (maps.wall((3.3, 0.45), (3.7, 0.45)), ("cylinder", "wall")),
    ],
)
def test_an_estimate_of_the_wrong_class_is_counted_where_it_truly_lies_and_that_is_not_missed(
    feature: Wall | Corner | Cylinder, cell: tuple[str, str]
) -> None:
    missed = (cell[0], "missed")
    expected = {**ALL_MISSED, cell: 1, missed: ALL_MISSED[missed] - 1}
    assert counts(confusion(feature)) == {name: count for name, count in expected.items() if count}


@pytest.mark.parametrize(
    ("feature", "name"),
    [
        (maps.cylinder((3.0, 0.27), 0.16), "cylinder"),  # 11 cm off the bottom wall
        (maps.corner((4.0, 1.0)), "corner"),
        (maps.wall((1, 1), (1, 1.5)), "wall"),
    ],
)
def test_what_matches_nothing_true_is_in_the_row_of_none(feature: Wall | Corner | Cylinder, name: str) -> None:
    assert counts(confusion(feature)) == {**ALL_MISSED, ("none", name): 1}


def test_a_ghost_on_a_wall_that_was_found_counts_beside_the_wall() -> None:
    matrix = confusion(maps.wall((1, 0), (2, 0)), maps.cylinder((3.0, 0.1), 0.1))
    assert counts(matrix) == {**ALL_MISSED, ("wall", "missed"): 4, ("wall", "wall"): 1, ("wall", "cylinder"): 1}


def test_an_object_that_few_stations_detect_can_be_misclassified_but_not_missed() -> None:
    assert counts(confusion(maps.cylinder((0.05, 1.0), 0.1))) == {**ALL_MISSED, ("wall", "cylinder"): 1}


def test_every_estimate_in_an_empty_truth_is_in_the_row_of_none() -> None:
    matrix = confusion(maps.wall((1, 0), (2, 0)), maps.corner((5, 0)), truth=maps.NOWHERE)
    assert counts(matrix) == {("none", "wall"): 1, ("none", "corner"): 1}


def test_no_confusion_is_four_by_four_zeros() -> None:
    assert no_confusion().tolist() == [[0] * 4] * 4
