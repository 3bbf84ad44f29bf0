from dataclasses import replace

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.classification.hypotheses import Hypothesis
from echoplan.classification.past import Past
from echoplan.mapping.joint.outline.faces import Face, FaceSettings, find_faces
from echoplan.mapping.joint.search.echoes import CornerEcho, Echoes
from expectations import corner, cylinder, feature, wall

STEP = np.radians(3.0)
EAST = feature(wall(0.0, 1.0), extent=(-1.0, 1.0))
BEHIND = feature(cylinder(2.5, 0.0, 0.1))
SILENT = Echoes()
# A sound path crosses the wall for each of these degrees; fewer than 25 degrees of them may be chance.
ENOUGH = 9


def heard(feet: FloatArray, crossings: FloatArray) -> Hypothesis:
    """The wall x = 1 that sent sound back from these places, and that sound went through there."""
    past = Past(number=1, feet=np.sort(feet), crossings=np.sort(crossings), pings=len(feet))
    return replace(EAST, past=past)


def with_gap(low: float, high: float) -> FloatArray:
    """Feet all along the wall but there."""
    feet = np.round(np.arange(-1.0, 1.001, 0.02), 6)
    kept: FloatArray = feet[(feet <= low + 1e-9) | (feet >= high - 1e-9)]
    return kept


def cut(feet: FloatArray, crossings: FloatArray, *others: Hypothesis, echoes: Echoes = SILENT) -> list[Face]:
    """The faces of the wall x = 1."""
    known = [heard(feet, crossings), BEHIND, *others]
    found = find_faces(known, echoes, step=STEP, settings=FaceSettings())
    return [each for each in found if each.owner == 0]


def spans(faces: list[Face]) -> list[tuple[float, float]]:
    return [(round(each.low, 6), round(each.high, 6)) for each in faces]


def test_a_gap_that_sound_went_through_makes_two_walls() -> None:
    faces = cut(with_gap(-0.3, 0.3), np.linspace(-0.2, 0.2, ENOUGH))
    assert spans(faces) == [(-1.0, -0.3), (0.3, 1.0)]
    assert [each.pings for each in faces] == [36, 36]
    assert all(each.wall.reflector is EAST.reflector for each in faces)


def test_a_gap_that_nothing_went_through_is_wall_that_was_not_heard() -> None:
    assert spans(cut(with_gap(-0.3, 0.3), np.zeros(0))) == [(-1.0, 1.0)]


def test_a_few_pings_through_a_gap_may_be_chance() -> None:
    assert spans(cut(with_gap(-0.3, 0.3), np.linspace(-0.2, 0.2, ENOUGH - 1))) == [(-1.0, 1.0)]


def test_what_grazes_the_ends_of_a_gap_did_not_go_through() -> None:
    assert spans(cut(with_gap(-0.3, 0.3), np.repeat([-0.29, 0.29], ENOUGH))) == [(-1.0, 1.0)]


def test_sound_through_what_was_heard_as_wall_cuts_nothing() -> None:
    assert spans(cut(with_gap(-0.3, 0.3), np.linspace(0.5, 0.8, 40))) == [(-1.0, 1.0)]


@pytest.mark.parametrize(("width", "parts"), [(0.10, 1), (0.14, 2)])
def test_no_sound_goes_through_a_gap_narrower_than_a_beam(width: float, parts: int) -> None:
    faces = cut(with_gap(-width / 2, width / 2), np.linspace(-0.02, 0.02, 20))
    assert len(faces) == parts


def test_a_wall_with_two_doorways_is_three_walls() -> None:
    feet = np.concatenate([np.linspace(-1.0, -0.6, 20), np.linspace(-0.2, 0.2, 20), np.linspace(0.6, 1.0, 20)])
    crossings = np.concatenate([np.linspace(-0.5, -0.3, ENOUGH), np.linspace(0.3, 0.5, ENOUGH)])
    assert spans(cut(feet, crossings)) == [(-1.0, -0.6), (-0.2, 0.2), (0.6, 1.0)]


def test_a_crumb_beside_a_doorway_is_no_wall() -> None:
    feet = np.concatenate([np.linspace(-1.0, -0.3, 100), [0.3, 0.31, 0.32]])
    assert spans(cut(feet, np.linspace(-0.2, 0.2, ENOUGH))) == [(-1.0, -0.3)]
    six = np.concatenate([np.linspace(-1.0, -0.3, 200), np.linspace(0.3, 0.35, 6)])
    assert spans(cut(six, np.linspace(-0.2, 0.2, ENOUGH))) == [(-1.0, -0.3), (0.3, 0.35)]


NORTH = feature(wall(np.pi / 2, 0.3), extent=(-0.5, 0.5))
SQUARE = Echoes(pairs={(0, 2): CornerEcho(pings=5, heard=30.0, gain=-29.0)})


def test_beyond_a_corner_that_was_heard_there_is_another_wall() -> None:
    # North and east meet at (1, 0.3); both walls reach their corner, so what is heard beyond is no part of it.
    assert spans(cut(with_gap(-0.3, 0.3), np.zeros(0), NORTH, echoes=SQUARE)) == [(-1.0, -0.3), (0.3, 1.0)]


def test_a_corner_that_was_heard_as_such_cuts_whatever_makes_it() -> None:
    # As where a block stands out from a wall, and nobody stood before its sides.
    heard = Echoes(corners_xy=np.array([[1.01, 0.29]]))
    assert len(cut(with_gap(-0.3, 0.3), np.zeros(0), NORTH, echoes=heard)) == 2
    assert spans(cut(with_gap(-0.3, 0.3), np.zeros(0), echoes=heard)) == [(-1.0, -0.3), (0.3, 1.0)]


@pytest.mark.parametrize(("length", "parts"), [(0.05, 1), (0.10, 2)])
@pytest.mark.parametrize("end", [0.3, 0.27])
def test_what_was_heard_at_a_corner_alone_does_not_go_on_from_there(length: float, parts: int, end: float) -> None:
    # As from a station straight before the corner of a room, of whose far wall nobody heard the middle.
    heard = Echoes(corners_xy=np.array([[1.0, end + 0.01]]))
    feet = np.concatenate([np.linspace(-1.0, -0.3, 30), np.linspace(end, end + length, 20)])
    assert len(cut(feet, np.zeros(0), echoes=heard)) == parts
    assert len(cut(np.sort(-feet), np.zeros(0), echoes=Echoes(corners_xy=heard.corners_xy * [1.0, -1.0]))) == parts


def test_nobody_knows_whether_a_wall_goes_on_behind_what_may_stand_against_it() -> None:
    cupboard = feature(wall(0.0, 0.4), extent=(-0.2, 0.2))
    assert spans(cut(with_gap(-0.3, 0.3), np.zeros(0), cupboard)) == [(-1.0, -0.3), (0.3, 1.0)]


@pytest.mark.parametrize(
    ("gap", "other"),
    [
        (0.3, wall(0.0, -0.1)),
        (0.3, wall(0.0, 0.98)),
        (0.3, wall(0.0, 1.3)),
        (0.3, wall(np.radians(15.0), 0.4)),
        (0.3, wall(np.pi, -0.4)),
        (0.15, wall(0.0, 0.4)),
    ],
    ids=["far before it", "as good as in it", "behind it", "askew", "facing it", "narrow gap"],
)
def test_behind_anything_else_a_wall_goes_on(gap: float, other: FloatArray) -> None:
    assert len(cut(with_gap(-gap, gap), np.zeros(0), feature(other, extent=(-0.1, 0.1)))) == 1


def test_what_stands_against_a_wall_elsewhere_does_not_cut_it() -> None:
    aside = feature(wall(0.0, 0.4), extent=(0.5, 0.8))
    assert len(cut(with_gap(-0.3, 0.3), np.zeros(0), aside)) == 1


def test_walls_hear_each_other_across_a_passage_and_do_not_meet_there() -> None:
    # What was heard of north ends 0.1 m before east; sound went by there.
    through = replace(NORTH, extent=(-0.9, 0.5), past=Past(crossings=np.linspace(-0.96, -0.94, 4)))
    assert len(cut(with_gap(-0.3, 0.3), np.zeros(0), through, echoes=SQUARE)) == 1
    few = replace(through, past=Past(crossings=np.linspace(-0.96, -0.94, 3)))
    assert len(cut(with_gap(-0.3, 0.3), np.zeros(0), few, echoes=SQUARE)) == 2


@pytest.mark.parametrize(
    ("feet", "other", "echoes"),
    [
        (with_gap(-0.3, 0.3), NORTH, SILENT),
        (with_gap(-0.3, 0.3), NORTH, Echoes(pairs={(0, 2): CornerEcho(pings=1)})),
        (with_gap(-0.3, 0.3), NORTH, Echoes(pairs={(0, 2): CornerEcho(pings=5, heard=30.0, gain=-31.0)})),
        (with_gap(-0.3, 0.3), NORTH, Echoes(corners_xy=np.array([[1.0, 0.36]]))),
        (with_gap(-0.3, 0.3), NORTH, Echoes(corners_xy=np.array([[1.04, 0.29]]))),
        (with_gap(-0.1, 0.3), NORTH, SQUARE),
        (with_gap(-0.3, 0.2), NORTH, SQUARE),
        (with_gap(-0.3, 0.3), feature(wall(np.radians(80), 0.3), extent=(-0.5, 0.5)), SQUARE),
        (with_gap(-0.3, 0.3), feature(wall(np.pi / 2, 0.3), extent=(0.2, 0.5)), SQUARE),
    ],
    ids=[
        "unheard",
        "once",
        "missed by others",
        "corner elsewhere",
        "corner beside the wall",
        "narrow gap",
        "corner not in the gap",
        "oblique",
        "too far away",
    ],
)
def test_without_such_a_corner_in_a_wide_gap_a_wall_stays_whole(
    feet: FloatArray, other: Hypothesis, echoes: Echoes
) -> None:
    assert len(cut(feet, np.zeros(0), other, echoes=echoes)) == 1


def shape(normal_angle: float, offset: float, low: float, high: float, pings: int = 10) -> Hypothesis:
    """A wall that was heard between two places along it by so many pings."""
    past = Past(number=pings, feet=np.linspace(low, high, 30), pings=pings)
    return replace(feature(wall(normal_angle, offset), extent=(low, high)), past=past)


def drawn_beside(other: Hypothesis) -> list[int]:
    """Numbers of the walls that are drawn of another one and the wall x = 1."""
    east = shape(0.0, 1.0, -1.0, 1.0, pings=99)
    return [each.owner for each in find_faces([other, east], SILENT, step=STEP, settings=FaceSettings())]


@pytest.mark.parametrize(
    "other",
    [shape(0.0, 1.015, 0.2, 0.6), shape(np.radians(4.0), 0.99, -0.1, 0.05), shape(0.0, 1.0, 0.9, 1.05)],
    ids=["behind", "askew", "at the end"],
)
def test_of_two_walls_between_which_there_is_no_room_one_is_drawn(other: Hypothesis) -> None:
    assert drawn_beside(other) == [1]


@pytest.mark.parametrize(
    "other",
    [
        shape(0.0, 1.03, 0.2, 0.6),
        shape(np.radians(4.0), 0.96, 0.2, 0.9),
        shape(0.0, 1.0, 0.9, 1.5),
        shape(np.pi, -1.01, -0.6, -0.2),
        shape(np.pi / 2, 0.5, -1.01, -0.99),
    ],
    ids=["behind", "askew", "past the end", "other side", "across"],
)
def test_of_two_walls_that_are_apart_both_are_drawn(other: Hypothesis) -> None:
    assert drawn_beside(other) == [0, 1]


def goes_on(turn: float, offset: float, low: float, high: float, pings: int) -> Hypothesis:
    """A wall beyond the upper end of x = 1."""
    return shape(np.radians(turn), offset, low, high, pings=pings)


def drawn_after(other: Hypothesis) -> list[int]:
    """Numbers of the walls that are drawn of another one and the wall x = 1, of which much was heard."""
    east = shape(0.0, 1.0, -1.0, 1.0, pings=250)
    return [each.owner for each in find_faces([other, east], SILENT, step=STEP, settings=FaceSettings())]


def test_a_stub_that_hardly_any_ping_heard_at_the_end_of_a_wall_is_not_drawn() -> None:
    # From 15 mm before the line to 10 mm behind it, between 0.10 and 0.28 m beyond what was heard of the wall.
    assert drawn_after(goes_on(8.0, 1.158, 0.948, 1.130, 10)) == [1]


@pytest.mark.parametrize(
    "other",
    [
        goes_on(8.0, 1.158, 0.948, 1.130, 20),
        goes_on(8.0, 1.085, 0.948, 1.130, 10),
        goes_on(2.0, 1.085, 0.948, 1.130, 10),
        goes_on(20.0, 1.34, 0.7, 0.9, 10),
        goes_on(8.0, 1.148, 0.8, 1.6, 10),
    ],
    ids=["heard well", "apart", "nearly parallel", "turned", "long"],
)
def test_any_other_wall_that_goes_on_from_another_is_drawn(other: Hypothesis) -> None:
    assert drawn_after(other) == [0, 1]


def test_a_wall_that_explains_no_ping_is_as_long_as_it_was_known() -> None:
    (face,) = cut(np.zeros(0), np.zeros(0))
    assert (face.low, face.high) == EAST.extent


def test_only_walls_have_faces() -> None:
    known = [feature(corner(1.0, 1.0)), feature(cylinder(0.0, 1.0, 0.1)), EAST]
    assert [each.owner for each in find_faces(known, SILENT, step=STEP, settings=FaceSettings())] == [2]
    assert find_faces([], SILENT, step=STEP, settings=FaceSettings()) == []


def test_places_along_a_face_are_points_on_its_line() -> None:
    slanted = feature(wall(0.7, 1.2))
    face = Face(owner=0, wall=slanted, low=0.2, high=0.8, crossings=np.zeros(0), silences=np.zeros(0), pings=1)
    normal = np.array([np.cos(0.7), np.sin(0.7)])
    assert face.point(0.2) @ normal == pytest.approx(1.2)
    assert face.point(0.2) @ face.along == pytest.approx(0.2)
    assert face.middle_xy == pytest.approx(0.5 * (face.point(0.2) + face.point(0.8)))


def test_it_takes_four_pings_to_open_a_line() -> None:
    crossings = np.array([0.1, 0.2, 0.3, 0.4, 0.9])
    nowhere = np.zeros(0)
    for through, silent in ((crossings, nowhere), (nowhere, crossings)):
        face = Face(owner=0, wall=EAST, low=-1.0, high=0.0, crossings=through, silences=silent, pings=9)
        assert face.is_open(0.0, 0.5)
        assert not face.is_open(0.15, 1.0 - 0.15)
        assert not face.is_open(2.0, 3.0)


def test_a_face_has_its_share_of_the_pings_of_the_wall() -> None:
    feet = with_gap(-0.3, 0.3)
    known = replace(EAST, past=replace(heard(feet, np.linspace(-0.2, 0.2, ENOUGH)).past, pings=720))
    faces = find_faces([known, BEHIND], SILENT, step=STEP, settings=FaceSettings())
    assert [each.pings for each in faces] == [360, 360]
