import numpy as np
import pytest
from pydantic import ValidationError

from echoplan.evaluation import MatchingSettings, match_map
from echoplan.evaluation.matching import match_corners, match_cylinders, match_walls
from echoplan.model import Truth, Wall
from helpers import maps

SETTINGS = MatchingSettings()


def tilted(degrees: float, *, middle: tuple[float, float] = (3.0, 0.0)) -> Wall:
    """A wall of half a metre about a point, turned out of the x axis."""
    along = 0.25 * np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
    return maps.wall(middle - along, middle + along)


def matched(*walls: Wall) -> list[tuple[int, int]]:
    """True wall and estimate of every right match."""
    return [(match.truth, match.estimate) for match in match_walls(walls, maps.ROOM, SETTINGS).right]


def test_a_wall_is_off_by_the_distance_of_its_midpoint_and_by_its_angle() -> None:
    # From (1, 0.03) to (4, 0.07): its middle is 5 cm above the bottom wall, its slope 0.04 in 3.
    (match,) = match_walls([maps.wall((1, 0.03), (4, 0.07))], maps.ROOM, SETTINGS).right
    assert (match.truth, match.estimate) == (0, 0)
    assert match.distance == pytest.approx(0.05)
    assert match.angle == pytest.approx(np.arctan(0.04 / 3))


def test_angles_are_measured_from_an_oblique_wall_as_from_any() -> None:
    # True: 30 degrees; estimated: 36 degrees, about its middle.
    true, middle = np.array([np.cos(np.pi / 6), np.sin(np.pi / 6)]), np.array([2.0, 1.0])
    oblique = Truth(walls_xy=np.array([[middle - true, middle + true]]), walls_detected_by=np.array([4]))
    (match,) = match_walls([tilted(36, middle=(2.0, 1.0))], oblique, SETTINGS).right
    assert np.degrees(match.angle) == pytest.approx(6.0)
    assert match.distance == pytest.approx(0.0, abs=1e-12)


def test_a_wall_has_no_sense_of_direction() -> None:
    there, back = ((0.02, 0.4), (0.02, 2.0)), ((0.02, 2.0), (0.02, 0.4))
    assert matched(maps.wall(*there)) == matched(maps.wall(*back)) == [(5, 0)]


@pytest.mark.parametrize("degrees", [9.9, -9.9, 170.1])
def test_a_wall_within_ten_degrees_of_the_true_one_matches(degrees: float) -> None:
    assert matched(tilted(degrees)) == [(0, 0)]


@pytest.mark.parametrize("degrees", [10.1, -10.1, 90.0])
def test_a_wall_beyond_ten_degrees_does_not(degrees: float) -> None:
    assert matched(tilted(degrees)) == []


@pytest.mark.parametrize(("middle", "found"), [((3, 0.099), [(0, 0)]), ((3, -0.099), [(0, 0)]), ((3, 0.101), [])])
def test_the_midpoint_must_lie_within_ten_centimetres_of_the_line(
    middle: tuple[float, float], found: list[tuple[int, int]]
) -> None:
    assert matched(tilted(0, middle=middle)) == found


@pytest.mark.parametrize(("x", "found"), [(-0.09, [(0, 0)]), (5.09, [(0, 0)]), (-0.11, []), (5.11, [])])
def test_the_foot_of_the_midpoint_may_lie_ten_centimetres_beyond_the_ends(
    x: float, found: list[tuple[int, int]]
) -> None:
    assert matched(tilted(0, middle=(x, 0.0))) == found


def test_of_two_faces_of_a_board_the_nearer_is_matched() -> None:
    board = Truth(walls_xy=np.array([[[0, 0], [2, 0]], [[2, 0.12], [0, 0.12]]]), walls_detected_by=np.array([3, 3]))
    matching = match_walls([maps.wall((0.5, 0.07), (1.5, 0.07))], board, SETTINGS)
    assert [(match.truth, round(match.distance, 9)) for match in matching.right] == [(1, 0.05)]


def test_of_several_walls_for_one_the_nearest_stands_and_the_others_are_duplicates() -> None:
    off = [tilted(0, middle=(1, 0.06)), tilted(0, middle=(2, -0.02)), tilted(0, middle=(3, 0.04))]
    matching = match_walls(off, maps.ROOM, SETTINGS)
    assert [match.estimate for match in matching.right] == [1]
    assert [match.estimate for match in matching.duplicate] == [2, 0]
    assert (matching.tally.right, matching.tally.duplicate, matching.tally.spurious) == (1, 2, 0)


def test_a_wall_that_few_stations_detect_is_right_but_not_wanted() -> None:
    matching = match_walls([maps.wall((0, 0.5), (0, 2.5)), tilted(45)], maps.ROOM, SETTINGS)
    assert matching.wanted == (0, 1, 2, 3, 4)
    assert matching.found == ()
    assert matching.spurious == (1,)
    assert matching.tally.recall == 0.0
    assert matching.tally.precision == 0.5


def test_how_many_stations_must_detect_a_wall_is_a_setting() -> None:
    walls = [maps.wall((0, 0.5), (0, 2.5))]
    assert match_walls(walls, maps.ROOM, MatchingSettings(min_stations=1)).found == (5,)
    assert match_walls(walls, maps.ROOM, MatchingSettings(min_stations=5)).wanted == (0, 4)


def test_a_wall_too_short_to_have_a_direction_is_spurious() -> None:
    assert match_walls([maps.wall((1, 0), (1 + 1e-7, 0))], maps.ROOM, SETTINGS).spurious == (0,)


def test_a_cylinder_is_off_by_its_centre_and_its_radius() -> None:
    # 3 and 4 cm off, and 2 cm too thin.
    (match,) = match_cylinders([maps.cylinder((3.53, 0.56), 0.08)], maps.ROOM, SETTINGS).right
    assert (match.truth, match.estimate) == (0, 0)
    assert match.distance == pytest.approx(0.05)
    assert match.radius_error == pytest.approx(-0.02)


def test_of_several_cylinders_for_one_the_first_stands() -> None:
    found = [maps.cylinder((3.6, 0.6), 0.1), maps.cylinder((3.5, 0.6), 0.1), maps.cylinder((3.66, 0.6), 0.1)]
    matching = match_cylinders(found, maps.ROOM, SETTINGS)
    assert [match.estimate for match in matching.right] == [0]
    assert [match.estimate for match in matching.duplicate] == [1]
    assert matching.spurious == (2,)


def test_a_corner_is_off_by_its_distance_from_the_nearest_vertex() -> None:
    matching = match_corners([maps.corner((2.06, 1.42)), maps.corner((4.0, 1.5))], maps.ROOM, SETTINGS)
    (match,) = matching.right
    assert (match.truth, match.estimate) == (2, 0)
    assert match.distance == pytest.approx(0.10)
    assert matching.spurious == (1,)


def test_several_corners_may_be_right_about_one_vertex() -> None:
    tally = match_corners([maps.corner((5.0, 0.1)), maps.corner((4.9, 0.0))], maps.ROOM, SETTINGS).tally
    assert (tally.wanted, tally.found, tally.right, tally.duplicate) == (4, 1, 2, 0)


def test_one_corner_can_find_both_vertices_of_a_narrow_face() -> None:
    # Three faces of a post 10 cm wide; the free ends of the outer two do not count.
    faces = np.array([[[0, 2], [0, 0]], [[0, 0], [0.1, 0]], [[0.1, 0], [0.1, 2]]])
    post = Truth(walls_xy=faces, walls_detected_by=np.array([4, 4, 4]))
    matching = match_corners([maps.corner((0.03, -0.01))], post, SETTINGS)
    assert len(matching.right) == 1
    assert (matching.tally.wanted, matching.tally.found) == (2, 2)


def test_only_corners_between_two_detectable_walls_are_wanted() -> None:
    assert match_corners([], maps.ROOM, SETTINGS).wanted == (2, 3, 4, 5)


def test_nothing_matches_in_an_empty_truth_or_an_empty_map() -> None:
    everything = maps.drawn(tilted(0), maps.corner((0, 0)), maps.cylinder((1, 1), 0.1))
    for matching in match_map(everything, maps.NOWHERE).by_class.values():
        assert matching.spurious == (0,)
        assert matching.wanted == ()
    for matching in match_map(maps.drawn(), maps.ROOM).by_class.values():
        assert matching.tally.estimates == 0
        assert matching.found == ()
        assert matching.wanted


def test_settings_that_cannot_be_are_refused() -> None:
    with pytest.raises(ValidationError, match="greater than 0"):
        MatchingSettings(wall_distance=0.0)
    with pytest.raises(ValidationError, match="wall_distnace"):
        MatchingSettings.model_validate({"wall_distnace": 0.1})
