from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from echoplan.acoustics.expectation import Kind
from echoplan.arrays import FloatArray
from echoplan.classification.hypotheses import Hypothesis
from echoplan.classification.past import Past
from echoplan.geometry import intersections
from echoplan.mapping.joint.adjustment.adjustment import AdjustmentSettings, Beliefs, Features, adjust
from echoplan.mapping.joint.adjustment.edges import edges_of
from echoplan.mapping.joint.adjustment.squareness import Squareness
from echoplan.mapping.joint.adjustment.state import State
from echoplan.mapping.joint.outline.segment import Segment
from echoplan.mapping.joint.outline.survey import Survey, SurveySettings
from echoplan.mapping.joint.outline.vertices import VertexSettings, find_vertices
from echoplan.mapping.joint.search.echoes import CornerEcho, Echoes
from echoplan.model import ClassProbabilities, Corner, CornerKind, Cylinder, Wall
from expectations import NOISE, REACH, ROOM, SONAR, corner, cylinder, edge, feature, hearing, listening

COLUMN = cylinder(0.2, 0.9, 0.1)
SILENT = Echoes()
SURE = ClassProbabilities(wall=0.8, corner=0.15, cylinder=0.05)


def past_of(known: Hypothesis, number: int, pings: int) -> Past:
    """What stations whose gain is above five said."""
    return Past(number=number, speaking=int((known.gains > 5.0).sum()), pings=pings, probabilities=SURE)


def survey(
    *others: Hypothesis,
    walls: Sequence[FloatArray] | FloatArray = ROOM,
    heard_to: float = 1.2,
    joined: bool = True,
    echoes: Echoes = SILENT,
    chance: float = 1.0,
) -> Survey:
    """The survey of a room of 4 x 3 m that was heard but for the corners."""
    known = [*(feature(each, gains=[9.0, 6.0, 4.0, -1.0]) for each in walls), *others]
    reflectors = np.array([each.reflector for each in known]).reshape(-1, 4)
    extents = np.tile([-REACH, REACH], (len(known), 1))
    features = Features(
        reflectors=reflectors,
        extents=extents,
        shadows=np.zeros((len(known), 4)),
        doubts=np.zeros((len(known), 4)),
        ends=edges_of(reflectors, extents),
    )
    truth = [*ROOM, *(each for each in reflectors if each[0] == Kind.CYLINDER)]
    beliefs = Beliefs(noise=NOISE, offset_sigma=0.0015, walk_gain=SONAR.walk_gain, has_servo=False, scale_sigma=0.03)
    start = State(features=features, model=SONAR)
    adjusted = adjust(hearing(listening(), truth), start, beliefs, AdjustmentSettings())
    known = [
        replace(each, past=past_of(each, number, int((adjusted.owners == number).sum())))
        for number, each in enumerate(known)
    ]
    segments = [
        Segment(
            owner=number,
            wall=each,
            low=-heard_to,
            high=heard_to,
            ends=(None, None),
            pings=40 + number,
            start=-3.0,
            chances=np.full(300, chance),
        )
        for number, each in enumerate(known)
        if each.is_wall
    ]
    return Survey(
        features=known,
        adjusted=adjusted,
        segments=segments,
        vertices=find_vertices(segments, echoes, VertexSettings()) if joined else [],
        squareness=None,
        settings=SurveySettings(),
    )


def test_walls_end_at_their_vertices() -> None:
    east, north, *_ = survey().walls([])
    assert east.endpoints_xy == pytest.approx(np.array([[2.0, -1.5], [2.0, 1.5]]))
    assert north.endpoints_xy == pytest.approx(np.array([[2.0, 1.5], [-2.0, 1.5]]))


def test_walls_drawn_to_right_angles_are_counted_and_other_members_are_not() -> None:
    drawn = survey(feature(COLUMN, gains=[9.0, 6.0, 4.0, -1.0]))
    assert drawn.right_angles() == {}
    square = Squareness(np.array([True, True, False, True, True]), 0.003)
    assert replace(drawn, squareness=square).right_angles() == {"walls": 3, "sigma": 0.003, "along_axes": False}


def test_a_wall_without_vertices_ends_where_it_was_heard_to_end() -> None:
    east, *_ = survey(joined=False).walls([])
    assert east.endpoints_xy == pytest.approx(np.array([[2.0, -1.2], [2.0, 1.2]]))


def test_a_wall_of_which_one_point_was_heard_is_six_centimetres_long() -> None:
    east, *_ = survey(joined=False, heard_to=0.0).walls([])
    assert east.length == pytest.approx(0.06)
    assert east.endpoints_xy.mean(axis=0) == pytest.approx([2.0, 0.0])


def test_a_wall_is_the_line_of_its_feature_with_what_speaks_for_it() -> None:
    east, north, *_ = survey().walls([])
    assert (north.normal_angle, north.offset) == pytest.approx((np.pi / 2, 1.5))
    assert (east.pings, north.pings) == (40, 41)
    # Stations whose gain is above five.
    assert east.stations == 2


def test_a_wall_that_is_drawn_as_far_as_it_was_detected_is_as_surely_one_as_its_feature() -> None:
    for east in (survey(joined=False).walls([])[0], survey(heard_to=1.5).walls([])[0]):
        assert east.inferred.tolist() == [0.0, 0.0]
        chances = (east.class_probabilities.wall, east.class_probabilities.corner, east.class_probabilities.cylinder)
        assert chances == pytest.approx((0.8, 0.15, 0.05))


def test_the_covariance_of_a_wall_is_its_block_of_the_adjustment() -> None:
    found = survey()
    place = found.adjusted.unknowns.feature(1)
    block = found.adjusted.covariance[place, place]
    assert found.walls([])[1].covariance == pytest.approx(block, rel=1e-9)


def test_every_covariance_is_symmetric_and_positive_definite() -> None:
    found = survey(feature(COLUMN), feature(edge(0.0, -0.9), gains=[9.0] * 4))
    drawn: list[Wall | Corner | Cylinder] = [*found.walls([]), *found.corners(), *found.cylinders()]
    assert len(drawn) == 4 + 5 + 1
    for each in drawn:
        assert each.covariance == pytest.approx(each.covariance.T, rel=1e-9)
        assert np.linalg.eigvalsh(each.covariance).min() > 0.0


def test_a_room_of_four_walls_has_four_corners() -> None:
    corners = survey().corners()
    assert sorted(np.round(each.position_xy, 6).tolist() for each in corners) == [
        [-2.0, -1.5],
        [-2.0, 1.5],
        [2.0, -1.5],
        [2.0, 1.5],
    ]
    assert all(each.kind is CornerKind.CONCAVE for each in corners)
    assert all((each.pings, each.stations) == (0, 0) for each in corners)
    assert all(each.class_probabilities.corner == 1.0 for each in corners)


def test_a_corner_tells_who_heard_one_of_its_walls_in_the_other() -> None:
    heard = Echoes(pairs={(0, 1): CornerEcho(pings=31, stations=3, heard=200.0)})
    by_place = {tuple(np.round(each.position_xy, 6)): each for each in survey(echoes=heard).corners()}
    assert (by_place[2.0, 1.5].pings, by_place[2.0, 1.5].stations) == (31, 3)
    assert {each.pings for place, each in by_place.items() if place != (2.0, 1.5)} == {0}


def test_the_covariance_of_a_corner_is_that_of_its_walls_carried_on_by_finite_differences() -> None:
    found = survey()
    unknowns, step = found.adjusted.unknowns, 1e-6
    for vertex, drawn in zip(found.vertices, found.corners(), strict=True):
        lines = np.array([found.features[each].line for each in vertex.segments])
        slopes = np.zeros((2, 4))
        for column in range(4):
            nudge = np.zeros((2, 2))
            nudge.flat[column] = step
            slopes[:, column] = (intersections(*(lines + nudge)) - intersections(*(lines - nudge))) / (2 * step)
        places = np.concatenate([np.arange(unknowns.size)[unknowns.feature(each)] for each in vertex.segments])
        expected = slopes @ found.adjusted.covariance[np.ix_(places, places)] @ slopes.T
        assert drawn.covariance == pytest.approx(expected, rel=1e-5)


def test_a_corner_that_was_heard_tells_from_where() -> None:
    heard = feature(corner(1.99, 1.49), gains=[9.0, 9.0, 9.0, 0.0])
    (drawn,) = [each for each in survey(heard).corners() if each.stations]
    # It is drawn where its walls meet, and only once.
    assert drawn.position_xy == pytest.approx([2.0, 1.5])
    assert drawn.stations == 3
    assert drawn.class_probabilities is SURE


def test_a_corner_where_no_walls_meet_is_drawn_as_it_was_heard() -> None:
    inner, outer = (feature(kind(0.4, -0.9), gains=[9.0] * 4) for kind in (corner, edge))
    for lone, kind in ((inner, CornerKind.CONCAVE), (outer, CornerKind.CONVEX)):
        drawn = survey(lone).corners()[-1]
        assert drawn.position_xy == pytest.approx([0.4, -0.9])
        assert (drawn.kind, drawn.stations) == (kind, 4)


def test_a_lone_corner_that_two_stations_heard_is_not_drawn() -> None:
    lone = feature(corner(0.4, -0.9), gains=[9.0, 9.0, 4.0, 0.0])
    assert len(survey(lone).corners()) == 4


def test_cylinders_are_drawn_and_nothing_else_among_them() -> None:
    found = survey(feature(COLUMN, gains=[9.0, 9.0, 9.0, 0.0]), feature(corner(0.4, -0.9)))
    (drawn,) = found.cylinders()
    assert drawn.center_xy == pytest.approx([0.2, 0.9])
    assert drawn.radius == pytest.approx(0.1)
    assert drawn.covariance.shape == (3, 3)
    assert (drawn.pings, drawn.stations) == (int((found.adjusted.owners == 4).sum()), 3)
    assert drawn.pings > 10


def test_where_nothing_was_found_nothing_is_drawn() -> None:
    empty = survey(walls=np.zeros((0, 4)))
    assert (empty.walls([]), empty.corners(), empty.cylinders()) == ((), (), ())
