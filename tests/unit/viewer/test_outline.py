import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.model import Opening, Wall
from echoplan.viewer.outline import body_pieces, jamb_strokes, label_turn, wall_bodies, wall_depths
from helpers.drawings import gapped_map
from helpers.maps import ROOM, wall

INSIDE = np.array([[1.0, 1.0], [1.0, 2.0]])
NOBODY = np.zeros((0, 2))
FLOOR = wall([0.0, 0.0], [4.0, 0.0])


def box(*, clockwise: bool = False) -> list[Wall]:
    """The walls of a room of 4 m by 3 m."""
    corners = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]])
    corners = corners[::-1] if clockwise else corners
    return [wall(start, end) for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True)]


def body(*walls: Wall, stations_xy: FloatArray = INSIDE, thickness: float = 0.1) -> FloatArray:
    """The body of the first of some walls."""
    return wall_bodies(walls, stations_xy, thickness=thickness)[0]


def wedge(degrees: float) -> list[Wall]:
    """Two walls that meet at the origin under an angle, to be detected from between them."""
    half = np.radians(degrees) / 2
    return [wall([0.0, 0.0], [3 * np.cos(turn), 3 * np.sin(turn)]) for turn in (half, -half)]


def area(corners: FloatArray) -> float:
    """Area of a polygon by the shoelace formula."""
    x, y = corners.T
    return abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1))) / 2


def test_no_walls_have_no_bodies() -> None:
    assert wall_bodies([], INSIDE, thickness=0.1) == []
    assert wall_bodies([], NOBODY, thickness=0.1) == []


def test_a_wall_alone_has_a_rectangle_behind_the_face_that_was_detected() -> None:
    np.testing.assert_allclose(body(FLOOR), [[0.0, 0.0], [4.0, 0.0], [4.0, -0.1], [0.0, -0.1]], atol=1e-12)


def test_the_same_wall_detected_from_the_other_side_has_its_body_on_this_one() -> None:
    np.testing.assert_allclose(body(FLOOR, stations_xy=-INSIDE)[2:, 1], 0.1)


def test_it_does_not_matter_which_way_a_wall_runs_or_its_normal_points() -> None:
    other = Wall(
        normal_angle=FLOOR.normal_angle + np.pi,
        offset=-FLOOR.offset,
        endpoints_xy=FLOOR.endpoints_xy[::-1],
        covariance=FLOOR.covariance,
    )
    np.testing.assert_allclose(body(other)[2:, 1], -0.1)
    np.testing.assert_allclose(body(wall([4.0, 0.0], [0.0, 0.0]))[2:, 1], -0.1)


def test_stations_beside_a_wall_do_not_outvote_one_opposite_to_it() -> None:
    beside = np.array([[5.0, -1.0], [6.0, -1.0], [-3.0, -2.0]])
    np.testing.assert_allclose(body(FLOOR, stations_xy=np.vstack([beside, [2.0, 1.0]]))[2:, 1], -0.1)


def test_a_box_that_is_detected_from_all_around_has_its_bodies_inside() -> None:
    # Most stations stand south of it, opposite to its north face as well, but they detect the south one.
    around = np.array([[1.0, -1.0], [2.0, -1.0], [3.0, -1.0], [2.0, 4.0], [-1.0, 1.0], [5.0, 1.0]])
    for each in wall_bodies(box(), around, thickness=0.1):
        assert (each >= -1e-9).all()
        assert (each <= np.array([4.0, 3.0]) + 1e-9).all()


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_which_stations_are_opposite_depends_on_the_ends_of_the_wall_wherever_it_lies(side: float) -> None:
    far_off = wall([10.0, 5.0], [14.0, 5.0])
    beside = np.array([[9.0, 5.0 - side], [15.0, 5.0 - side]])
    stations = np.vstack([beside, [12.0, 5.0 + side]])
    np.testing.assert_allclose(body(far_off, stations_xy=stations)[2:, 1], 5.0 - 0.1 * side)


def test_where_no_station_is_opposite_the_majority_decides_the_side() -> None:
    beside = np.array([[5.0, -1.0], [6.0, -1.0], [-3.0, 2.0]])
    np.testing.assert_allclose(body(FLOOR, stations_xy=beside)[2:, 1], 0.1)


@pytest.mark.parametrize("stations_xy", [NOBODY, np.array([[1.0, 1.0], [1.0, -1.0]])])
def test_where_stations_do_not_decide_the_normal_does(stations_xy: FloatArray) -> None:
    normal = FLOOR.normal_xy[1]
    np.testing.assert_allclose(body(FLOOR, stations_xy=stations_xy)[2:, 1], 0.1 * normal, atol=1e-12)
    assert normal == pytest.approx(-1.0)


def test_without_stations_a_normal_that_was_turned_round_turns_the_body_round() -> None:
    turned = Wall(
        normal_angle=FLOOR.normal_angle + np.pi,
        offset=-FLOOR.offset,
        endpoints_xy=FLOOR.endpoints_xy,
        covariance=FLOOR.covariance,
    )
    np.testing.assert_allclose(body(turned, stations_xy=NOBODY)[2:, 1], 0.1)


@pytest.mark.parametrize("clockwise", [False, True])
def test_walls_of_a_room_meet_in_mitres(clockwise: bool) -> None:  # noqa: FBT001 - both ways round
    bodies = wall_bodies(box(clockwise=clockwise), INSIDE, thickness=0.1)
    backs = np.concatenate([each[2:] for each in bodies])
    outer = {(-0.1, -0.1), (4.1, -0.1), (4.1, 3.1), (-0.1, 3.1)}
    assert {tuple(point) for point in backs.round(9).tolist()} == outer
    assert sum(area(each) for each in bodies) == pytest.approx(4.2 * 3.2 - 4.0 * 3.0)


def test_the_faces_stay_where_they_were_detected() -> None:
    walls = box()
    for one, each in zip(walls, wall_bodies(walls, INSIDE, thickness=0.1), strict=True):
        np.testing.assert_array_equal(each[:2], one.endpoints_xy)


def test_around_an_edge_the_backs_meet_within_the_wall() -> None:
    walls = [wall(start, end) for start, end in ROOM.walls_xy]
    bodies = wall_bodies(walls, np.array([[1.0, 1.0], [3.0, 0.7]]), thickness=0.1)
    # The edge at (2, 1.5) stands out into the L, so its body lies in the notch, beyond both faces.
    for number in (2, 3):
        assert [2.1, 1.6] in bodies[number].round(9).tolist()


def test_walls_whose_ends_are_a_hand_apart_do_not_meet() -> None:
    bodies = wall_bodies([FLOOR, wall([4.1, 0.0], [4.1, 3.0])], INSIDE, thickness=0.1)
    np.testing.assert_allclose(bodies[0][2], [4.0, -0.1], atol=1e-12)


def test_walls_that_meet_to_a_rounding_do() -> None:
    bodies = wall_bodies([FLOOR, wall([4.0004, 0.0], [4.0, 3.0])], INSIDE, thickness=0.1)
    np.testing.assert_allclose(bodies[0][2], [4.1, -0.1], atol=1e-3)


def test_walls_in_one_line_that_meet_end_square() -> None:
    bodies = wall_bodies([FLOOR, wall([4.0, 0.0], [6.0, 0.0])], INSIDE, thickness=0.1)
    np.testing.assert_allclose(bodies[0][2], [4.0, -0.1], atol=1e-12)


@pytest.mark.parametrize("degrees", [40, 60, 90, 120, 170])
def test_a_mitre_is_as_long_as_the_thickness_over_the_sine_of_half_the_angle(degrees: float) -> None:
    first, second = wall_bodies(wedge(degrees), np.array([[1.0, 0.0]]), thickness=0.1)
    np.testing.assert_allclose(first[3], [-0.1 / np.sin(np.radians(degrees) / 2), 0.0], atol=1e-9)
    np.testing.assert_allclose(second[3], first[3], atol=1e-9)


@pytest.mark.parametrize("degrees", [10, 38])
def test_a_mitre_that_would_be_a_spike_is_cut_off(degrees: float) -> None:
    first, _ = wall_bodies(wedge(degrees), np.array([[1.0, 0.0]]), thickness=0.1)
    assert np.hypot(*first[3]) == pytest.approx(0.1)


def test_a_thin_wall_is_thin() -> None:
    assert area(body(FLOOR, thickness=0.02)) == pytest.approx(0.08)


def test_a_wall_without_inferred_ends_is_one_observed_piece() -> None:
    whole = wall_bodies(box(), INSIDE, thickness=0.1)[0]
    observed, inferred = body_pieces(whole, np.zeros(2))
    np.testing.assert_array_equal(observed, [whole])
    assert inferred == []


def test_a_body_is_cut_square_where_its_inferred_ends_begin_and_keeps_its_mitres() -> None:
    whole = wall_bodies(box(), INSIDE, thickness=0.1)[0]
    (observed,), (before, after) = body_pieces(whole, np.array([0.5, 1.0]))
    np.testing.assert_allclose(observed, [[0.5, 0.0], [3.0, 0.0], [3.0, -0.1], [0.5, -0.1]], atol=1e-12)
    np.testing.assert_allclose(before, [[0.0, 0.0], [0.5, 0.0], [0.5, -0.1], [-0.1, -0.1]], atol=1e-12)
    np.testing.assert_allclose(after, [[3.0, 0.0], [4.0, 0.0], [4.1, -0.1], [3.0, -0.1]], atol=1e-12)


@pytest.mark.parametrize("inferred", [[4.0, 0.0], [0.0, 9.0], [2.5, 1.5], [3.0, 3.0]])
def test_a_wall_that_was_only_inferred_has_no_observed_piece(inferred: list[float]) -> None:
    observed, pieces = body_pieces(body(FLOOR), np.array(inferred))
    assert observed == []
    assert sum(area(each) for each in pieces) == pytest.approx(0.4)


@pytest.mark.parametrize("swapped", [False, True])
def test_jambs_reach_across_the_walls_beside_an_opening(swapped: bool) -> None:  # noqa: FBT001 - both ways round
    found = gapped_map()
    bodies = wall_bodies(found.walls, found.poses[:, :2], thickness=0.1)
    opening = found.openings[0]
    ends = opening.endpoints_xy[::-1] if swapped else opening.endpoints_xy
    turned = Opening(endpoints_xy=ends, width_sigma=0.0, walls=opening.walls)
    for (x, _), stroke in zip(ends, jamb_strokes(turned, bodies, thickness=0.1), strict=True):
        np.testing.assert_allclose(stroke[:, 0], x, atol=1e-12)
        np.testing.assert_allclose(sorted(stroke[:, 1]), [-0.15, 0.05], atol=1e-12)


def test_jambs_without_walls_beside_them_reach_as_far_to_both_sides() -> None:
    opening = Opening(endpoints_xy=np.array([[1.0, 0.0], [2.0, 0.0]]), width_sigma=0.0, walls=())
    np.testing.assert_allclose(np.abs(jamb_strokes(opening, [], thickness=0.1)[..., 1]), 0.1)


@pytest.mark.parametrize(
    ("end", "degrees"),
    [
        ([1, 0], 0),
        ([-1, 0], 0),
        ([0, 1], 90),
        ([0, -1], 90),
        ([1, -1], -45),
        ([-1, -1], 45),
        # Upright but for an error: read from the right on both sides of 90 degrees.
        ([0.001, 1], 89.94),
        ([-0.001, 1], 90.06),
    ],
)
def test_labels_are_read_from_below_or_from_the_right(end: list[float], degrees: float) -> None:
    assert label_turn(np.array([[0.0, 0.0], end])) == pytest.approx(degrees, abs=0.01)


def partition(thickness: float) -> list[Wall]:
    """Both faces of a partition, detected from either side."""
    return [wall([0.0, 0.0], [4.0, 0.0]), wall([3.0, -thickness], [1.0, -thickness])]


def test_a_wall_is_as_thick_as_its_faces_are_apart() -> None:
    both = np.array([[1.5, 1.0], [2.5, 1.0], [1.5, -1.0], [2.5, -1.0]])
    np.testing.assert_allclose(wall_depths(partition(0.15), both), [0.15, 0.15])
    first, second = wall_bodies(partition(0.15), both, thickness=wall_depths(partition(0.15), both))
    assert (area(first), area(second)) == pytest.approx((0.6, 0.3))


def test_the_thickness_is_unknown_where_faces_are_far_apart_or_seen_from_between() -> None:
    both = np.array([[1.5, 1.0], [2.5, 1.0], [1.5, -2.0], [2.5, -2.0]])
    assert np.isnan(wall_depths(partition(0.5), both)).all()
    between = np.array([[2.0, -0.1], [2.5, -0.1]])
    assert np.isnan(wall_depths(partition(0.3), between)).all()
    assert wall_depths([], both).shape == (0,)
