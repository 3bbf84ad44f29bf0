import numpy as np
import pytest

from echoplan.geometry import directions
from echoplan.joint.map_extraction.segment import CELL, Segment
from echoplan.joint.map_extraction.surroundings import (
    Obstacles,
    before_corners,
    corners_on,
    fronts_of,
    is_across,
    is_copy,
)
from echoplan.joint.search.corner_echoes import CornerEcho, Echoes
from helpers.outlines import segment

LINE = np.array([0.0, 2.0])
EAST = segment(0.0, 2.0, (-1.0, 1.0))
NORTH = segment(np.pi / 2, 1.5, (-1.8, 1.0), owner=1)
SQUARE = Echoes(pairs={(0, 1): CornerEcho(pings=5, stations=1, detections=30.0, gain=-29.0)})


def test_an_obstacle_occludes_what_is_behind_it() -> None:
    origins, targets = np.zeros((4, 2)), np.array([[3.0, 0.0], [1.96, 0.0], [2.04, 0.0], [3.0, 2.0]])
    assert Obstacles.of([EAST]).block(origins, targets).tolist() == [True, False, False, False]
    assert Obstacles.of([EAST], margin=0.4).block(origins, targets).tolist() == [True, False, False, True]


def test_a_cylinder_occludes_within_its_margin() -> None:
    discs, aside = np.array([[1.0, 0.0, 0.1]]), np.array([[2.0, 0.0], [2.0, 0.28]])
    for margin, blocked in ((0.0, [True, False]), (0.1, [True, True])):
        assert Obstacles.of([], discs, margin).block(np.zeros((2, 2)), aside).tolist() == blocked
    assert not Obstacles.of([]).block(np.zeros((2, 2)), aside).any()


FRONT = segment(0.0, 1.4, (-0.3, 0.2), owner=1)


def test_a_parallel_segment_before_a_line_is_a_front() -> None:
    (front,) = fronts_of(LINE, [FRONT])
    assert front == pytest.approx((-0.3, 0.2))


@pytest.mark.parametrize(
    "others",
    [
        [segment(0.0, 0.9, (-0.3, 0.2))],
        [segment(0.0, 1.96, (-0.3, 0.2))],
        [segment(0.0, 2.3, (-0.3, 0.2))],
        [segment(np.radians(15.0), 1.4, (-0.3, 0.2))],
        [segment(np.pi, -1.4, (-0.3, 0.2))],
        [FRONT, segment(np.pi, -1.6, (-0.1, 0.2))],
    ],
    ids=["far before it", "as good as in it", "behind it", "askew", "facing it", "with a back"],
)
def test_nothing_else_is_a_front(others: list[Segment]) -> None:
    assert fronts_of(LINE, others) == []


@pytest.mark.parametrize("angle", [90.0, 89.9, 70.0, -89.9])
def test_a_short_segment_across_a_wall_is_no_duplicate(angle: float) -> None:
    cosine, sine = directions(np.radians(angle))
    stub = segment(np.radians(angle), 2.0 * cosine, (-2.0 * sine - 0.04, -2.0 * sine + 0.04), owner=1)
    assert stub.middle_xy == pytest.approx([2.0, 0.0])
    assert not is_copy(stub, EAST)
    assert is_copy(segment(np.radians(2.0), 2.0, (-0.04, 0.04), owner=1), EAST)


@pytest.mark.parametrize(("place", "copy"), [(-1.1, False), (-1.0, True), (0.2, True), (1.1, False)])
def test_a_segment_of_one_point_on_a_wall_is_a_duplicate(place: float, *, copy: bool) -> None:
    assert is_copy(segment(0.0, 2.01, (place, place), owner=1), EAST) == copy


def crossing(angle: float, place: float, half: float) -> Segment:
    """Return a segment whose middle lies on the line of EAST."""
    normal, along = directions(np.radians([angle, angle + 90.0]))
    middle = np.array([2.0, place])
    return segment(np.radians(angle), float(middle @ normal), (middle @ along - half, middle @ along + half), owner=1)


@pytest.mark.parametrize(
    ("other", "stub", "across"),
    [
        (EAST, crossing(50.0, 1.1, 0.03), True),
        (EAST, crossing(15.0, 1.1, 0.09), True),
        (EAST, crossing(50.0, 1.1, 0.2), False),
        (EAST, crossing(2.0, 1.1, 0.03), False),
        (EAST, crossing(50.0, 2.1, 0.03), False),
        (segment(0.0, 2.0, (-1.0, 1.0), free=1.11), crossing(50.0, 1.1, 0.03), False),
    ],
    ids=["short", "oblique", "long", "parallel", "far from its end", "in a gap"],
)
def test_a_short_segment_lies_across_a_wall_where_that_may_continue(
    other: Segment, stub: Segment, *, across: bool
) -> None:
    assert is_across(stub, other) == across


def test_the_back_of_another_object_does_not_remove_a_front() -> None:
    aside = segment(np.pi, -1.6, (-0.9, -0.5))
    assert len(fronts_of(LINE, [FRONT, aside])) == 1


def test_a_detected_corner_with_a_known_wall_ends_a_wall_on_one_side() -> None:
    for other, side in ((NORTH, 1), (segment(-np.pi / 2, 1.5, (-1.0, 1.8), owner=1), 0)):
        (corner,) = corners_on(0, EAST.wall, [EAST, other], SQUARE)
        place = 1.5 if side else -1.5
        assert corner.place == pytest.approx(place)
        assert corner.sides == (side,)
        assert corner.evidence == pytest.approx(1.0)
        assert before_corners([corner]) == pytest.approx([place - CELL if side else place + CELL])


@pytest.mark.parametrize(
    ("other", "echo"),
    [
        (NORTH, CornerEcho(pings=4, detections=30.0)),
        (NORTH, CornerEcho(pings=9, detections=30.0, gain=-31.0)),
        (segment(np.radians(80.0), 1.5, (-1.8, 1.0), owner=1), CornerEcho(pings=9, detections=30.0)),
        (segment(np.pi / 2, 1.5, (-0.9, 1.0), owner=1), CornerEcho(pings=9, detections=30.0)),
        (segment(np.pi / 2, 1.5, (-1.8, 1.0), owner=1, free=-1.9), CornerEcho(pings=9, detections=30.0)),
    ],
    ids=["hardly detected", "missed by others", "oblique", "far from it", "behind a gap"],
)
def test_no_other_pair_of_walls_makes_a_corner(other: Segment, echo: CornerEcho) -> None:
    assert corners_on(0, EAST.wall, [EAST, other], Echoes(pairs={(0, 1): echo})) == []


def test_a_lone_corner_may_be_either_end_of_a_wall_and_counts_once() -> None:
    at_corner, beside, relocalised = [2.01, 1.48], [2.04, 0.2], [2.0, 0.3]
    lone = Echoes(corners_xy=np.array([at_corner, beside, relocalised]))
    assert [each.place for each in corners_on(0, EAST.wall, [EAST], lone)] == pytest.approx([1.48, 0.3])
    both = Echoes(pairs=SQUARE.pairs, corners_xy=lone.corners_xy)
    assert [each.sides for each in corners_on(0, EAST.wall, [EAST, NORTH], both)] == [(1,), (0, 1)]
    assert len(before_corners(corners_on(0, EAST.wall, [EAST], lone))) == 0
