import numpy as np
import pytest

from echoplan.joint.map_extraction.corners import CornerSettings, Vertex, find_vertices
from echoplan.joint.map_extraction.segment import Segment
from echoplan.joint.search.corner_echoes import CornerEcho, Echoes
from echoplan.model import CornerKind
from helpers.constants import settings_with
from helpers.outlines import segment

SILENT = Echoes()
# A corner that should have been detected and was not.
MISSED = Echoes(pairs={(0, 1): CornerEcho(gain=-6.0)})


def corner_echoes(**detected: float) -> Echoes:
    """Return the echoes of the corner of segments 0 and 1."""
    return Echoes(pairs={(0, 1): CornerEcho(**detected)})  # type: ignore[arg-type]


def vertices_of(*segments: Segment, echoes: Echoes = SILENT, **settings: float) -> list[Vertex]:
    return find_vertices(segments, echoes, settings_with(CornerSettings, **settings))


def east(ends: tuple[float, float] = (-0.8, 0.8), **changed: object) -> Segment:
    """Return the wall x = 1; places along it are y."""
    return segment(0.0, 1.0, ends, **changed)  # type: ignore[arg-type]


def north(ends: tuple[float, float] = (-0.8, 0.8), **changed: object) -> Segment:
    """Return the wall y = 1; places along it are -x."""
    return segment(np.pi / 2, 1.0, ends, **({"owner": 1} | changed))  # type: ignore[arg-type]


def test_a_room_has_as_many_corners_as_walls() -> None:
    around = [segment(turn, 1.0, (-0.8, 0.8), owner=k) for k, turn in enumerate((0.0, np.pi / 2, np.pi, -np.pi / 2))]
    vertices = vertices_of(*around)
    assert sorted(np.round(each.position_xy).tolist() for each in vertices) == [[-1, -1], [-1, 1], [1, -1], [1, 1]]
    assert all(each.kind is CornerKind.CONCAVE for each in vertices)
    assert not any(each.detected for each in vertices)


def test_a_vertex_holds_the_ends_of_its_segments() -> None:
    (vertex,) = vertices_of(east(), north())
    assert vertex.position_xy == pytest.approx([1.0, 1.0])
    assert vertex.segments == (0, 1)
    assert vertex.upper == (True, False)
    assert vertex.cost == pytest.approx(0.4)


def test_segments_of_a_box_meet_in_a_convex_corner() -> None:
    (vertex,) = vertices_of(east((1.1, 1.9)), north((-1.9, -1.1)))
    assert vertex.kind is CornerKind.CONVEX
    assert vertex.upper == (False, True)
    assert vertex.position_xy == pytest.approx([1.0, 1.0])


def test_segments_that_cannot_be_of_one_body_do_not_meet() -> None:
    # One lies before the other, but the other behind it: no body has both faces.
    assert vertices_of(east((-0.8, 0.8)), north((-1.9, -1.1))) == []


@pytest.mark.parametrize(("turn", "count"), [(15.0, 0), (25.0, 1)])
def test_nearly_parallel_segments_do_not_meet(turn: float, count: int) -> None:
    # Both reach to within 10 cm of their crossing at (1, 0).
    slanted = segment(np.radians(turn), np.cos(np.radians(turn)), (0.1 - np.sin(np.radians(turn)), 0.8))
    assert len(vertices_of(east((-0.8, -0.1)), slanted)) == count


def test_a_crossing_in_the_middle_of_a_segment_is_no_vertex() -> None:
    assert vertices_of(east((-0.8, 1.3)), north()) == []
    assert len(vertices_of(east((-0.8, 1.05)), north())) == 1


@pytest.mark.parametrize(
    ("high", "echoes", "count"),
    [
        (0.6, MISSED, 1),
        (0.4, MISSED, 0),
        (0.4, corner_echoes(gain=-4.0), 1),
        (-1.9, SILENT, 1),
        (-2.1, SILENT, 0),
        (-2.1, corner_echoes(pings=99, gain=99.0), 0),
    ],
    ids=["missed, but near", "missed", "hardly missed", "hidden", "too far", "detected, but too far"],
)
def test_segments_are_extended_to_a_right_angled_corner_unless_it_was_missed(
    high: float, echoes: Echoes, count: int
) -> None:
    assert len(vertices_of(east((-2.9, high)), north(), echoes=echoes)) == count


@pytest.mark.parametrize(
    ("echoes", "detected"),
    [
        (corner_echoes(pings=5), True),
        (corner_echoes(pings=4), False),
        (corner_echoes(gain=6.0), True),
        (corner_echoes(gain=4.0), False),
        (Echoes(corners_xy=np.array([[1.02, 1.0]])), True),
        (Echoes(corners_xy=np.array([[1.04, 1.0]])), False),
    ],
    ids=["in pairs", "hardly in pairs", "by all", "hardly by all", "as such", "beside"],
)
def test_a_corner_is_detected_by_multipath_or_as_a_landmark(echoes: Echoes, *, detected: bool) -> None:
    (vertex,) = vertices_of(east(), north(), echoes=echoes)
    assert vertex.detected == detected


def slanted(length: float) -> tuple[Segment, Segment]:
    """Return two segments 70 degrees apart, one of which must grow by 60 cm to meet the other."""
    apex = (1.0 - np.cos(np.radians(70))) / np.sin(np.radians(70))
    return east((apex - 0.6 - length, apex - 0.6)), segment(np.radians(70), 1.0, (-0.65, 0.5), owner=1)


@pytest.mark.parametrize(("length", "count"), [(0.28, 0), (0.32, 1)])
def test_extension_to_an_undetected_oblique_corner_is_limited_by_the_segment_length(length: float, count: int) -> None:
    assert len(vertices_of(*slanted(length))) == count
    assert len(vertices_of(*slanted(length), echoes=corner_echoes(pings=5))) == 1


def test_a_segment_ends_at_the_first_detected_corner_on_its_line() -> None:
    def on_the_way(x: float, y: float) -> Echoes:
        return Echoes(corners_xy=np.array([[x, y]]))

    assert vertices_of(east((-0.8, 0.1)), north(), echoes=on_the_way(1.01, 0.5)) == []
    assert len(vertices_of(east((-0.8, 0.1)), north(), echoes=on_the_way(1.04, 0.5))) == 1
    assert len(vertices_of(east((-0.8, 0.1)), north(), echoes=on_the_way(1.0, -0.5))) == 1


def test_segments_are_extended_to_undetected_convex_corners() -> None:
    assert len(vertices_of(east((1.1, 1.9)), north((-1.8, -1.7)))) == 1


@pytest.mark.parametrize(("extension", "detected"), [(0.9, True), (1.1, False)])
def test_oblique_corners_are_detected_only_with_a_short_extension(extension: float, *, detected: bool) -> None:
    slanted = segment(np.radians(70), 1.0, (-0.65, 0.5), owner=1)
    apex = (1.0 - np.cos(np.radians(70))) / np.sin(np.radians(70))
    (vertex,) = vertices_of(east((-1.9, apex - extension)), slanted, echoes=corner_echoes(pings=20))
    assert vertex.detected == detected


def test_double_echoes_detect_no_convex_corner() -> None:
    echoes = corner_echoes(pings=20)
    (vertex,) = vertices_of(east((1.1, 1.9)), north((-1.9, -1.1)), echoes=echoes)
    assert not vertex.detected


def test_segments_do_not_meet_beyond_a_free_cell() -> None:
    assert vertices_of(east(free=0.9, chance=0.04), north()) == []
    assert len(vertices_of(east(free=0.9, chance=0.06), north())) == 1
    assert len(vertices_of(east(free=0.0, chance=0.0), north())) == 1


def test_a_segment_of_one_point_is_extended_to_a_corner() -> None:
    assert len(vertices_of(east((0.8, 0.8)), north((-0.8, -0.8)))) == 1


def test_each_end_belongs_to_the_nearest_vertex_only() -> None:
    nearer = segment(np.pi / 2, 0.9, (-0.8, 0.8), owner=2)
    vertices = vertices_of(east(), north(), nearer)
    assert [each.segments for each in vertices] == [(0, 2)]


def test_a_detected_corner_is_preferred_to_a_nearer_one() -> None:
    nearer = segment(np.pi / 2, 0.9, (-0.8, 0.8), owner=2)
    echoes = Echoes(corners_xy=np.array([[1.0, 1.0]]))
    vertices = vertices_of(east(), north(), nearer, echoes=echoes)
    assert [each.segments for each in vertices] == [(0, 1)]


def test_both_ends_of_a_segment_may_be_vertices() -> None:
    west = segment(np.pi, 1.0, (-0.8, 0.8), owner=2)
    vertices = vertices_of(east(), north(), west)
    assert {each.segments: each.upper[each.segments.index(1)] for each in vertices} == {(0, 1): False, (1, 2): True}


def test_a_single_segment_has_no_vertices() -> None:
    assert vertices_of(east()) == []
    assert vertices_of() == []
