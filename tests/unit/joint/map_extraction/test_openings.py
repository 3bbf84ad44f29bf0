"""Gaps in the walls of a room of 4 x 3 m, and between the two faces of a wall."""

from collections.abc import Sequence

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.joint.map_extraction.openings import Gap, merged_faces, openings_of, unobserved_of
from echoplan.joint.map_extraction.segment import End, Segment
from echoplan.model import Opening, UnobservedStretch
from helpers.expectations import ROOM, wall
from helpers.outlines import segment, survey

NOWHERE = np.zeros((0, 2))


def gap(
    line: tuple[float, float],
    ends: tuple[float, float],
    *,
    sigma: float = 0.03,
    walls: tuple[int, ...] = (0, 1),
    is_open: bool = True,
    passed: bool = False,
) -> Gap:
    """Return a gap with normally distributed ends."""
    jambs = End.normal(ends[0], sigma), End.normal(ends[1], sigma)
    return Gap(walls=walls, line=np.array(line), jambs=jambs, is_free=is_open, is_open=is_open, passed=passed)


# A door of 0.8 m in a wall 0.2 m thick: places along its western face are y, along its eastern face -y.
WEST = gap((0.0, 2.0), (-0.4, 0.4))


def other_face(ends: tuple[float, float] = (-0.4, 0.4), offset: float = -2.2, **changed: float | bool) -> Gap:
    """Return the gap in the other face of the wall."""
    return gap((np.pi, offset), ends, walls=(2, 3), **changed)  # type: ignore[arg-type]


def test_both_faces_of_a_wall_give_one_opening_midway_with_a_smaller_sigma() -> None:
    alone = [openings_of(merged_faces([each]))[0] for each in (WEST, other_face((-0.41, 0.39)))]
    (both,) = openings_of(merged_faces([WEST, other_face((-0.41, 0.39))]))
    assert both.endpoints_xy == pytest.approx(np.array([[2.1, -0.395], [2.1, 0.405]]), abs=0.002)
    assert both.width_sigma < 0.8 * min(each.width_sigma for each in alone)
    assert both.walls == (0, 1, 2, 3)


def test_the_sigma_of_the_width_combines_both_jambs() -> None:
    (alone,) = openings_of([WEST])
    assert alone.width_sigma == pytest.approx(0.03 * np.sqrt(2.0), rel=0.02)
    assert alone.width == pytest.approx(0.8)


@pytest.mark.parametrize(
    "other",
    [
        other_face(offset=-1.8),
        other_face(offset=-2.5),
        gap((0.0, 2.2), (-0.4, 0.4)),
        gap((np.pi - np.radians(12.0), -2.2), (-0.4, 0.4)),
        other_face((0.1, 0.9)),
    ],
    ids=["faces each other", "too thick", "same side", "askew", "hardly opposite"],
)
def test_gaps_of_different_walls_are_not_merged(other: Gap) -> None:
    assert len(merged_faces([WEST, other])) == 2


@pytest.mark.parametrize("turn", [-0.5, 0.25, 0.5])
def test_faces_that_are_not_quite_parallel_give_one_opening(turn: float) -> None:
    # A door 6 m along the wall, in faces whose directions differ by a fraction of a degree.
    middle, angle = np.array([2.2, 6.4]), np.pi + np.radians(turn)
    normal, along = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    east = gap((angle, float(middle @ normal)), (float(middle @ along) - 0.4, float(middle @ along) + 0.4))
    (both,) = openings_of(merged_faces([gap((0.0, 2.0), (6.0, 6.8)), east]))
    assert both.endpoints_xy == pytest.approx(np.array([[2.1, 6.0], [2.1, 6.8]]), abs=0.005)


def test_a_face_that_is_not_known_to_be_open_gives_only_its_offset() -> None:
    for order in ([WEST, other_face((-0.2, 0.6), is_open=False)], [other_face((-0.2, 0.6), is_open=False), WEST]):
        (both,) = openings_of(merged_faces(order))
        assert both.endpoints_xy == pytest.approx(np.array([[2.1, -0.4], [2.1, 0.4]]), abs=1e-6)


def test_an_opening_is_passed_if_either_face_is() -> None:
    assert [each.passed for each in openings_of(merged_faces([WEST, other_face(passed=True)]))] == [True]
    assert [each.passed for each in openings_of(merged_faces([WEST, other_face()]))] == [False]


def pieces(low: float = -0.4, high: float = 0.4, *, chance: float = 0.0, known: bool = True) -> list[Segment]:
    """Return the wall x = 2 in two pieces, with jambs known to 2 cm and a wall probability between them."""
    ends = (End.normal(low, 0.02), End.normal(high, 0.02)) if known else (None, None)
    return [
        segment(0.0, 2.0, (-1.2, low), free=0.5 * (low + high), chance=chance, known=(None, ends[0])),
        segment(0.0, 2.0, (high, 1.2), free=0.5 * (low + high), chance=chance, known=(ends[1], None)),
    ]


def between(
    east: Sequence[Segment], path_xy: FloatArray = NOWHERE
) -> tuple[tuple[Opening, ...], tuple[UnobservedStretch, ...]]:
    """Return openings and unobserved stretches of a room whose wall x = 2 is in pieces."""
    gaps = survey(pieces={0: east}).gaps(path_xy)
    return openings_of(gaps), unobserved_of(gaps)


def test_a_free_gap_between_two_known_jambs_is_an_opening() -> None:
    (door,), unobserved = between(pieces())
    assert door.endpoints_xy == pytest.approx(np.array([[2.0, -0.4], [2.0, 0.4]]))
    assert (door.walls, door.passed, unobserved) == ((0, 1), False, ())
    assert door.width_sigma == pytest.approx(0.02 * np.sqrt(2.0), rel=0.02)


@pytest.mark.parametrize("known", [True, False])
def test_a_gap_without_evidence_is_an_unobserved_stretch(*, known: bool) -> None:
    openings, (stretch,) = between(pieces(chance=0.3, known=known))
    assert openings == ()
    assert stretch.endpoints_xy == pytest.approx(np.array([[2.0, -0.4], [2.0, 0.4]]))
    assert stretch.walls == (0, 1)


def test_a_free_gap_with_unknown_ends_is_no_opening() -> None:
    assert between(pieces(known=False)) == ((), ())


@pytest.mark.parametrize(("chance", "unobserved"), [(0.0, 0), (0.3, 1)], ids=["free", "nobody looked"])
def test_a_gap_at_a_concave_corner_is_no_opening(chance: float, unobserved: int) -> None:
    # The wall y = 0.5 abuts on x = 2 from inside, so nothing passes around that corner into the gap above it.
    abutting = wall(np.pi / 2, 0.5)
    found = survey(
        walls=[*ROOM, abutting],
        pieces={0: pieces(0.4, 1.0, chance=chance), 4: [segment(np.pi / 2, 0.5, (-1.9, -0.8), owner=4)]},
    )
    (between_pieces,) = found.gaps(NOWHERE)
    assert between_pieces.ends == pytest.approx([0.5, 1.0])
    assert between_pieces.is_free == (chance == 0.0)
    assert openings_of([between_pieces]) == ()
    assert len(unobserved_of([between_pieces])) == unobserved


@pytest.mark.parametrize(
    ("path_xy", "passed"),
    [
        ([[1.0, 0.0], [3.0, 0.2]], True),
        ([[3.0, 0.0], [1.0, -0.3]], True),
        ([[1.0, 0.0], [1.8, 0.2]], False),
        ([[1.0, 0.6], [3.0, 0.6]], False),
        ([[1.0, -0.3], [1.0, 2.0], [3.0, 2.0], [3.0, 0.0]], False),
        ([[1.0, 0.0]], False),
    ],
    ids=["through", "back", "not as far", "beside a jamb", "around", "one place"],
)
def test_an_opening_is_passed_if_the_path_leads_through_it(path_xy: list[list[float]], *, passed: bool) -> None:
    (door,), _ = between(pieces(), np.array(path_xy))
    assert door.passed == passed


@pytest.mark.parametrize(("width", "count"), [(0.45, 0), (0.55, 1), (1.5, 1)])
def test_a_gap_narrower_than_half_a_metre_is_no_opening(width: float, count: int) -> None:
    openings, unobserved = between(pieces(-0.5 * width, 0.5 * width))
    assert (len(openings), unobserved) == (count, ())


@pytest.mark.parametrize(("path_xy", "count"), [(NOWHERE, 0), (np.array([[1.0, 0.0], [3.0, 0.0]]), 1)])
def test_a_gap_behind_an_object_is_an_opening_only_if_the_robot_drove_through(path_xy: FloatArray, count: int) -> None:
    front = segment(0.0, 1.4, (-0.2, 0.2), owner=4)
    found = survey(walls=[*ROOM, wall(0.0, 1.4)], pieces={0: pieces(), 4: [front]})
    assert len(openings_of(found.gaps(path_xy))) == count


@pytest.mark.parametrize("chance", [0.0, 0.3], ids=["free", "nobody looked"])
@pytest.mark.parametrize(("ends", "count"), [((-0.35, 0.35), 0), ((-0.35, -0.1), 1)], ids=["most of it", "a part"])
def test_a_gap_filled_by_a_wall_of_another_landmark_is_none(
    chance: float, ends: tuple[float, float], count: int
) -> None:
    other = segment(0.0, 2.02, ends, owner=4)
    found = survey(walls=[*ROOM, wall(0.0, 2.02)], pieces={0: pieces(chance=chance), 4: [other]})
    assert len(found.gaps(NOWHERE)) == count


def test_a_gap_of_less_than_five_centimetres_is_none() -> None:
    assert between(pieces(0.0, 0.04)) == ((), ())
