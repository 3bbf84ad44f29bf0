import numpy as np
import pytest

from echoplan.classical.features import Span, junctions, settle
from echoplan.model import CornerKind

# The room lies in the first quadrant; normals point out of it.
SOUTH = Span(line=np.array([-np.pi / 2, 0.0]), low=0.3, high=2.6)
EAST = Span(line=np.array([0.0, 3.0]), low=0.4, high=1.5)
# A wall along y = 2 detected from above, and one along x = 1 from the left: they meet around a corner at (1, 2).
LEDGE = Span(line=np.array([-np.pi / 2, -2.0]), low=1.2, high=2.0)
JAMB = Span(line=np.array([0.0, 1.0]), low=1.0, high=1.9)


def test_neighbours_meet_where_their_lines_cross() -> None:
    (corner,) = junctions([SOUTH, EAST], max_extension=1.0)
    assert corner.position_xy == pytest.approx([3.0, 0.0])
    assert corner.extension == pytest.approx(0.4 + 0.4)
    assert corner.longest == pytest.approx(0.4)
    assert corner.kind is CornerKind.CONCAVE
    assert (corner.first_at_high, corner.second_at_high) == (True, False)


def test_walls_that_face_away_from_each_other_meet_around_an_edge() -> None:
    (corner,) = junctions([LEDGE, JAMB], max_extension=1.0)
    assert corner.kind is CornerKind.CONVEX
    assert corner.position_xy == pytest.approx([1.0, 2.0])


def test_too_long_an_extension_is_no_meeting() -> None:
    assert junctions([SOUTH, EAST], max_extension=0.3) == []


def test_parallel_walls_never_meet() -> None:
    north = Span(line=np.array([np.pi / 2, 2.0]), low=-2.0, high=-1.0)
    assert junctions([SOUTH, north], max_extension=10.0) == []


def test_a_crossing_inside_a_wall_is_no_corner() -> None:
    across = Span(line=np.array([0.0, 1.5]), low=0.1, high=1.0)
    assert junctions([SOUTH, across], max_extension=1.0) == []


def test_each_end_meets_its_nearest_neighbour_only() -> None:
    beyond = Span(line=np.array([0.0, 3.4]), low=0.4, high=1.5)
    meetings = junctions([SOUTH, EAST, beyond], max_extension=2.0)
    assert [(each.first, each.second) for each in meetings] == [(0, 1), (0, 2)]
    assert settle(meetings) == meetings[:1]
    assert settle(meetings[::-1]) == meetings[1:]


def test_a_span_knows_its_points() -> None:
    assert EAST.point_xy(0.4) == pytest.approx([3.0, 0.4])
    assert SOUTH.middle_xy == pytest.approx([1.45, 0.0])
