from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.geometry import intersections
from echoplan.joint.map_extraction.openings import Gap
from echoplan.joint.map_extraction.segment import End
from echoplan.joint.optimisation.manhattan import ManhattanPrior
from echoplan.joint.search.corner_echoes import CornerEcho, Echoes
from echoplan.model import Corner, CornerKind, Cylinder, Wall
from helpers.expectations import ROOM, corner, cylinder, edge, feature, wall
from helpers.outlines import SURE, segment, survey

COLUMN = cylinder(0.2, 0.9, 0.1)


def test_walls_end_at_their_vertices() -> None:
    east, north, *_ = survey().walls([])
    assert east.endpoints_xy == pytest.approx(np.array([[2.0, -1.5], [2.0, 1.5]]))
    assert north.endpoints_xy == pytest.approx(np.array([[2.0, 1.5], [-2.0, 1.5]]))


def test_only_walls_count_as_members_of_the_manhattan_prior() -> None:
    drawn = survey(feature(COLUMN, llr_by_station=[9.0, 6.0, 4.0, -1.0]))
    assert drawn.right_angles() == {}
    square = ManhattanPrior(np.array([True, True, False, True, True]), 0.003)
    assert replace(drawn, manhattan_prior=square).right_angles() == {"walls": 3, "sigma": 0.003, "along_axes": False}


def test_a_wall_without_vertices_ends_where_it_was_detected() -> None:
    east, *_ = survey(joined=False).walls([])
    assert east.endpoints_xy == pytest.approx(np.array([[2.0, -1.2], [2.0, 1.2]]))


def test_a_wall_of_one_detected_point_is_six_centimetres_long() -> None:
    east, *_ = survey(joined=False, detected_to=0.0).walls([])
    assert east.length == pytest.approx(0.06)
    assert east.endpoints_xy.mean(axis=0) == pytest.approx([2.0, 0.0])


def test_no_wall_is_drawn_across_the_path_of_the_robot() -> None:
    path_xy = np.array([[1.0, 0.01], [3.0, 0.01], [3.0, 1.3], [1.0, 1.3]])
    short = replace(survey(joined=False, detected_to=0.0), path_xy=path_xy).walls([])[0]
    assert short.endpoints_xy == pytest.approx(np.array([[2.0, -0.03], [2.0, 0.009]]))
    met = replace(survey(detected_to=1.2), path_xy=path_xy[2:]).walls([])[0]
    assert met.endpoints_xy == pytest.approx(np.array([[2.0, -1.5], [2.0, 1.299]]))


def test_a_wall_has_the_line_pings_and_stations_of_its_landmark() -> None:
    east, north, *_ = survey().walls([])
    assert (north.normal_angle, north.offset) == pytest.approx((np.pi / 2, 1.5))
    assert (east.pings, north.pings) == (40, 41)
    # Stations with a log-likelihood ratio above five.
    assert east.stations == 2


def test_a_wall_without_inferred_length_has_the_class_of_its_landmark() -> None:
    for east in (survey(joined=False).walls([])[0], survey(detected_to=1.5).walls([])[0]):
        assert east.inferred.tolist() == [0.0, 0.0]
        chances = (east.class_probabilities.wall, east.class_probabilities.corner, east.class_probabilities.cylinder)
        assert chances == pytest.approx((0.8, 0.15, 0.05))


def test_the_covariance_of_a_wall_is_its_block_of_the_solution() -> None:
    found = survey()
    place = found.solution.layout.feature(1)
    block = found.solution.covariance[place, place]
    assert found.walls([])[1].covariance == pytest.approx(block, rel=1e-9)


def test_every_covariance_is_symmetric_and_positive_definite() -> None:
    found = survey(feature(COLUMN), feature(edge(0.0, -0.9), llr_by_station=[9.0] * 4))
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
    # They are undetected, and each wall extends to them with a probability of 0.9.
    assert [each.class_probabilities.corner for each in corners] == pytest.approx([0.9 + 0.1 / 3] * 4)


def test_a_corner_has_the_pings_and_stations_of_its_double_echoes() -> None:
    detected = Echoes(pairs={(0, 1): CornerEcho(pings=31, stations=3, detections=200.0)})
    by_place = {tuple(np.round(each.position_xy, 6)): each for each in survey(echoes=detected).corners()}
    assert (by_place[2.0, 1.5].pings, by_place[2.0, 1.5].stations) == (31, 3)
    assert {each.pings for place, each in by_place.items() if place != (2.0, 1.5)} == {0}


def test_the_covariance_of_a_corner_is_propagated_from_its_walls() -> None:
    found = survey()
    layout, step = found.solution.layout, 1e-6
    for vertex, drawn in zip(found.vertices, found.corners(), strict=True):
        lines = np.array([found.features[each].line for each in vertex.segments])
        jacobian = np.zeros((2, 4))
        for column in range(4):
            nudge = np.zeros((2, 2))
            nudge.flat[column] = step
            jacobian[:, column] = (intersections(*(lines + nudge)) - intersections(*(lines - nudge))) / (2 * step)
        places = np.concatenate([np.arange(layout.size)[layout.feature(each)] for each in vertex.segments])
        expected = jacobian @ found.solution.covariance[np.ix_(places, places)] @ jacobian.T
        assert drawn.covariance == pytest.approx(expected, rel=1e-5)


def test_a_detected_corner_has_the_stations_of_its_landmark() -> None:
    detected = feature(corner(1.99, 1.49), llr_by_station=[9.0, 9.0, 9.0, 0.0])
    (drawn,) = [each for each in survey(detected).corners() if each.stations]
    # It is drawn where its walls meet, and only once.
    assert drawn.position_xy == pytest.approx([2.0, 1.5])
    assert drawn.stations == 3
    assert drawn.class_probabilities is SURE


def test_a_lone_corner_is_drawn_where_it_was_detected() -> None:
    inner, outer = (feature(kind(0.4, -0.9), llr_by_station=[9.0] * 4) for kind in (corner, edge))
    square = ManhattanPrior(np.array([True] * 4 + [False]), 0.003)
    for lone, kind in ((inner, CornerKind.CONCAVE), (outer, CornerKind.CONVEX)):
        drawn = replace(survey(lone), manhattan_prior=square).corners()[-1]
        assert drawn.position_xy == pytest.approx([0.4, -0.9])
        assert (drawn.kind, drawn.stations) == (kind, 4)


def test_a_corner_without_walls_carries_the_model_error_of_a_corner() -> None:
    found = survey(feature(edge(0.4, -0.9), llr_by_station=[9.0] * 4))
    place = found.solution.layout.feature(4)
    expected = found.solution.covariance[place, place] + found.settings.lone_corner_sigma**2 * np.eye(2)
    assert found.corners()[-1].covariance == pytest.approx(expected, rel=1e-9)


def test_a_corner_in_the_middle_of_a_wall_is_the_crossing_of_its_walls() -> None:
    # A partition along x = 0.4 ends at the wall y = 1.5; the echo seems to come from 9 mm beside the corner.
    detected = feature(corner(0.405, 1.4925), llr_by_station=[9.0] * 4)
    partition = segment(0.0, 0.4, (0.3, 1.4), owner=4)
    found = survey(detected, walls=[*ROOM, wall(0.0, 0.4)], pieces={4: [partition]})
    found = replace(found, manhattan_prior=ManhattanPrior(np.array([True] * 5 + [False]), 0.003))
    (drawn,) = [each for each in found.corners() if each.stations]
    assert drawn.position_xy == pytest.approx([0.4, 1.5])
    assert drawn.kind is CornerKind.CONCAVE
    # The wall y = 1.5 has its angle at place 2 and its offset at 3, the partition at 8 and 9.
    lines = found.solution.covariance[np.ix_([8, 9, 2, 3], [8, 9, 2, 3])]
    slopes = np.array([[-1.5, 1.0, 0.0, 0.0], [0.0, 0.0, 0.4, 1.0]])
    assert drawn.covariance == pytest.approx(slopes @ lines @ slopes.T, rel=1e-6)


def test_a_lone_concave_corner_of_unknown_angle_is_not_drawn() -> None:
    # In an angle of 76 degrees the reading is 0.97 of the distance of the vertex: centimetres short.
    lone = feature(corner(0.4, -0.9), llr_by_station=[9.0] * 4)
    assert len(survey(lone).corners()) == 4


def test_a_lone_corner_of_two_stations_is_not_drawn() -> None:
    lone = feature(corner(0.4, -0.9), llr_by_station=[9.0, 9.0, 4.0, 0.0])
    assert len(survey(lone).corners()) == 4


def test_only_cylinders_are_drawn_as_cylinders() -> None:
    found = survey(feature(COLUMN, llr_by_station=[9.0, 9.0, 9.0, 0.0]), feature(corner(0.4, -0.9)))
    (drawn,) = found.cylinders()
    assert drawn.center_xy == pytest.approx([0.2, 0.9])
    assert drawn.radius == pytest.approx(0.1)
    assert drawn.covariance.shape == (3, 3)
    assert (drawn.pings, drawn.stations) == (int((found.solution.owners == 4).sum()), 3)
    assert drawn.pings > 10


def test_without_landmarks_the_map_is_empty() -> None:
    empty = survey(walls=np.zeros((0, 4)))
    assert (empty.walls([]), empty.corners(), empty.cylinders()) == ((), (), ())
    assert empty.gaps(np.zeros((0, 2))) == []


# The wall x = 2 as a segment from -1.2 to 0.9, which is extended to the corners at -1.5 and 1.5.
EAST = segment(0.0, 2.0, (-1.2, 0.9), free=1.21, chance=0.4)
DETECTED = Echoes(pairs={(0, 1): CornerEcho(pings=9, stations=2, detections=30.0)})


def corner_at(corners: Sequence[Corner], x: float, y: float) -> Corner:
    return min(corners, key=lambda each: float(np.hypot(*(each.position_xy - [x, y]))))


def test_the_extension_to_an_undetected_corner_is_inferred_and_lowers_the_class_probability() -> None:
    east, *_ = survey(pieces={0: [EAST]}).walls([])
    assert east.inferred == pytest.approx([0.3, 0.6])
    # Of three metres 0.9 m are unobserved, where all classes are equally probable.
    assert east.class_probabilities.wall == pytest.approx(0.7 * 0.8 + 0.3 / 3)
    assert east.class_probabilities.corner == pytest.approx(0.7 * 0.15 + 0.3 / 3)


def test_an_extension_clipped_at_the_path_is_inferred_up_to_the_path() -> None:
    # The extension from 0.9 to the corner at 1.5 is crossed at 1.0, the one from -0.9 to -1.5 at -1.25.
    path_xy = np.array([[1.0, 1.0], [3.0, 1.0], [3.0, -1.25], [1.0, -1.25]])
    east = replace(survey(detected_to=0.9), path_xy=path_xy).walls([])[0]
    assert east.endpoints_xy == pytest.approx(np.array([[2.0, -1.249], [2.0, 0.999]]))
    assert east.inferred == pytest.approx([0.349, 0.099])
    # The robot drove between the wall and the corner, so the wall does not end there.
    assert np.isnan(east.endpoint_sigmas).all()


def test_the_extension_to_a_detected_corner_is_not_inferred() -> None:
    east, *_ = survey(pieces={0: [EAST]}, echoes=DETECTED).walls([])
    assert east.inferred == pytest.approx([0.3, 0.0])


def test_an_undetected_corner_is_as_probable_as_both_walls_reaching_it() -> None:
    silent, detected = (survey(pieces={0: [EAST]}, echoes=each).corners() for each in (Echoes(), DETECTED))
    assert corner_at(detected, 2.0, 1.5).class_probabilities.corner == 1.0
    inferred = corner_at(silent, 2.0, 1.5).class_probabilities
    assert inferred.corner == pytest.approx(0.4 + 0.6 / 3)
    assert inferred.wall == pytest.approx(0.6 / 3)


def test_the_sigma_of_a_wall_end_is_that_of_its_distribution() -> None:
    ends = End.normal(-1.2, 0.03), None
    free = segment(0.0, 2.0, (-1.2, 0.9), known=ends)
    vague = segment(0.0, 2.0, (-1.2, 0.9), known=(End.normal(-1.2, 0.3), None))
    east, other = (survey(pieces={0: [each]}, joined=False).walls([])[0] for each in (free, vague))
    assert east.endpoint_sigmas == pytest.approx([0.03, np.nan], rel=0.02, nan_ok=True)
    assert np.isnan(other.endpoint_sigmas).all()


def test_the_sigma_of_a_wall_end_at_a_vertex_is_that_of_the_vertex() -> None:
    found = survey()
    (vertex,) = [each for each in found.vertices if each.segments == (0, 1)]
    covariance = corner_at(found.corners(), 2.0, 1.5).covariance
    east, north, *_ = found.walls([])
    assert vertex.upper == (True, False)
    assert east.endpoint_sigmas[1] == pytest.approx(np.sqrt(covariance[1, 1]), rel=0.02)
    assert north.endpoint_sigmas[0] == pytest.approx(np.sqrt(covariance[0, 0]), rel=0.02)


def opening(jambs: tuple[End, End], walls: tuple[int, ...] = (0, 1), **changed: bool) -> Gap:
    """Return an opening in the line x = 2."""
    flags = {"is_free": True, "is_open": True, "passed": False} | changed
    return Gap(walls=walls, line=np.array([0.0, 2.0]), jambs=jambs, **flags)


TWO = {0: [segment(0.0, 2.0, (-1.2, -0.4)), segment(0.0, 2.0, (0.4, 1.2))]}


def ends_beside(gap: Gap) -> FloatArray:
    """Return the ends of both pieces of the wall x = 2 at a gap [m], and the sigma of the lower one [m]."""
    below, above, *_ = survey(pieces=TWO).walls([gap])
    return np.array([below.endpoints_xy[1, 1], above.endpoints_xy[0, 1], below.endpoint_sigmas[1]])


def test_walls_end_at_the_jambs_of_an_opening() -> None:
    jambs = End.normal(-0.38, 0.02), End.normal(0.43, 0.02)
    assert ends_beside(opening(jambs)) == pytest.approx([-0.38, 0.43, 0.02], rel=0.02)


def test_a_wall_within_an_opening_of_the_other_face_keeps_its_ends() -> None:
    # The nearer jamb is at -1.3, beyond the lower end of the lower piece.
    below, *_ = survey(pieces=TWO, joined=False).walls([opening((End.normal(-1.3, 0.02), End.normal(0.43, 0.02)))])
    assert below.endpoints_xy == pytest.approx(np.array([[2.0, -1.2], [2.0, -0.4]]))


def test_a_wall_is_not_shortened_to_its_inferred_length() -> None:
    # The wall is observed from -1.2 to 0.9, and inferred up to the corners at -1.5 and 1.5.
    east, *_ = survey(pieces={0: [EAST]}).walls([opening((End.normal(-0.9, 0.02), End.normal(4.0, 0.02)), (0,))])
    assert east.endpoints_xy[:, 1] == pytest.approx([-1.5, 1.5])


@pytest.mark.parametrize(
    "gap",
    [
        opening((End.normal(-0.38, 0.02), End.normal(0.43, 0.02)), is_open=False),
        opening((End.normal(-0.38, 0.5), End.normal(0.43, 0.5))),
    ],
    ids=["not open", "not known"],
)
def test_walls_beside_other_gaps_end_where_they_were_detected(gap: Gap) -> None:
    assert ends_beside(gap) == pytest.approx([-0.4, 0.4, np.nan], nan_ok=True)
