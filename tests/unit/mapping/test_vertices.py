import numpy as np
import pytest

from echoplan.mapping.faces import Echoes, Face
from echoplan.mapping.vertices import Vertex, VertexSettings, find_vertices
from echoplan.model import CornerKind
from expectations import feature, wall

SILENT = Echoes(counts={}, corners_xy=np.zeros((0, 2)))


def face(
    normal_angle: float, offset: float, ends: tuple[float, float], *, owner: int = 0, crossings: tuple[float, ...] = ()
) -> Face:
    """A face by its line and its ends along it."""
    line = feature(wall(normal_angle, offset))
    through, silent = np.array(crossings), np.zeros(0)
    return Face(owner=owner, wall=line, low=ends[0], high=ends[1], crossings=through, silences=silent, pings=50)


def met(*faces: Face, echoes: Echoes = SILENT, **settings: float) -> list[Vertex]:
    return find_vertices(faces, echoes, VertexSettings.model_validate(settings))


def east(ends: tuple[float, float] = (-0.8, 0.8), **changed: object) -> Face:
    """The wall x = 1; places along it are y."""
    return face(0.0, 1.0, ends, **changed)  # type: ignore[arg-type]


def north(ends: tuple[float, float] = (-0.8, 0.8), **changed: object) -> Face:
    """The wall y = 1; places along it are -x."""
    return face(np.pi / 2, 1.0, ends, **({"owner": 1} | changed))  # type: ignore[arg-type]


def test_a_room_has_as_many_corners_as_walls() -> None:
    around = [face(turn, 1.0, (-0.8, 0.8), owner=k) for k, turn in enumerate((0.0, np.pi / 2, np.pi, -np.pi / 2))]
    vertices = met(*around)
    assert sorted(np.round(each.position_xy).tolist() for each in vertices) == [[-1, -1], [-1, 1], [1, -1], [1, 1]]
    assert all(each.kind is CornerKind.CONCAVE for each in vertices)
    assert not any(each.heard for each in vertices)


def test_a_vertex_knows_which_ends_of_its_faces_meet() -> None:
    (vertex,) = met(east(), north())
    assert vertex.position_xy == pytest.approx([1.0, 1.0])
    assert vertex.faces == (0, 1)
    assert vertex.upper == (True, False)
    assert vertex.cost == pytest.approx(0.4)


def test_faces_of_a_box_meet_in_a_convex_corner() -> None:
    (vertex,) = met(east((1.1, 1.9)), north((-1.9, -1.1)))
    assert vertex.kind is CornerKind.CONVEX
    assert vertex.upper == (False, True)
    assert vertex.position_xy == pytest.approx([1.0, 1.0])


def test_faces_that_turn_their_backs_to_each_other_do_not_meet() -> None:
    # One lies before the other, but the other behind it: no body has both.
    assert met(east((-0.8, 0.8)), north((-1.9, -1.1))) == []


@pytest.mark.parametrize(("turn", "count"), [(15.0, 0), (25.0, 1)])
def test_faces_that_hardly_turn_go_on_rather_than_meet(turn: float, count: int) -> None:
    # Both reach to within 10 cm of their crossing at (1, 0).
    slanted = face(np.radians(turn), np.cos(np.radians(turn)), (0.1 - np.sin(np.radians(turn)), 0.8))
    assert len(met(east((-0.8, -0.1)), slanted)) == count


def test_a_crossing_amid_a_face_is_no_end_of_it() -> None:
    assert met(east((-0.8, 1.3)), north()) == []
    assert len(met(east((-0.8, 1.05)), north())) == 1


@pytest.mark.parametrize(
    ("high", "echoes", "count"),
    [
        (-0.4, SILENT, 1),
        (-0.6, SILENT, 0),
        (-0.6, Echoes(counts={(0, 1): 5}, corners_xy=np.zeros((0, 2))), 1),
        (-0.6, Echoes(counts={(0, 1): 4}, corners_xy=np.zeros((0, 2))), 0),
        (-0.6, Echoes(counts={}, corners_xy=np.array([[1.02, 1.0]])), 1),
        (-0.6, Echoes(counts={}, corners_xy=np.array([[1.04, 1.0]])), 0),
        (-1.1, Echoes(counts={(0, 1): 99}, corners_xy=np.array([[1.0, 1.0]])), 0),
    ],
    ids=["near", "far", "far, heard in pairs", "hardly heard", "heard as such", "heard beside", "too far"],
)
def test_a_corner_that_was_heard_reaches_farther(high: float, echoes: Echoes, count: int) -> None:
    vertices = met(east((-1.9, high)), north(), echoes=echoes)
    assert len(vertices) == count
    assert all(each.heard == (echoes is not SILENT) for each in vertices)


@pytest.mark.parametrize(("length", "count"), [(0.3, 0), (0.4, 1)])
def test_no_face_grows_to_more_than_thrice_its_length_to_a_corner_nobody_heard(length: float, count: int) -> None:
    short = north((-0.3, -0.3 + length))
    assert len(met(east(), short)) == count
    assert len(met(east(), short, echoes=Echoes(counts={(0, 1): 5}, corners_xy=np.zeros((0, 2))))) == 1


def test_nobody_hears_convex_corners_and_so_faces_may_grow_to_them() -> None:
    assert len(met(east((1.1, 1.9)), north((-1.8, -1.7)))) == 1


@pytest.mark.parametrize(("extension", "heard"), [(0.9, True), (1.1, False)])
def test_walls_that_are_not_square_hear_each_other_from_near_by_only(extension: float, *, heard: bool) -> None:
    slanted = face(np.radians(70), 1.0, (-0.65, 0.5), owner=1)
    apex = (1.0 - np.cos(np.radians(70))) / np.sin(np.radians(70))
    (vertex,) = met(
        east((-1.9, apex - extension)), slanted, echoes=Echoes(counts={(0, 1): 20}, corners_xy=np.zeros((0, 2)))
    )
    assert vertex.heard == heard


def test_the_echo_of_a_pair_makes_no_convex_corner_heard() -> None:
    echoes = Echoes(counts={(0, 1): 20}, corners_xy=np.zeros((0, 2)))
    (vertex,) = met(east((1.1, 1.9)), north((-1.9, -1.1)), echoes=echoes)
    assert not vertex.heard


def test_where_sound_went_through_the_extension_nothing_meets() -> None:
    through = (0.85, 0.88, 0.91, 0.94)
    assert met(east(crossings=through), north()) == []
    assert len(met(east(crossings=through[:3]), north())) == 1
    assert len(met(east(crossings=(-0.5, -0.4, 0.0, 0.1)), north())) == 1


def test_each_end_meets_once_and_the_nearest_wins() -> None:
    nearer = face(np.pi / 2, 0.9, (-0.8, 0.8), owner=2)
    vertices = met(east(), north(), nearer)
    assert [each.faces for each in vertices] == [(0, 2)]


def test_a_corner_that_was_heard_wins_against_a_nearer_one() -> None:
    nearer = face(np.pi / 2, 0.9, (-0.8, 0.8), owner=2)
    echoes = Echoes(counts={}, corners_xy=np.array([[1.0, 1.0]]))
    vertices = met(east(), north(), nearer, echoes=echoes)
    assert [each.faces for each in vertices] == [(0, 1)]


def test_both_ends_of_a_face_may_meet_others() -> None:
    west = face(np.pi, 1.0, (-0.8, 0.8), owner=2)
    vertices = met(east(), north(), west)
    assert sorted(each.faces for each in vertices) == [(0, 1), (1, 2)]
    assert [each.upper[each.faces.index(1)] for each in sorted(vertices, key=lambda each: each.faces)] == [False, True]


def test_one_face_meets_nothing() -> None:
    assert met(east()) == []
    assert met() == []
