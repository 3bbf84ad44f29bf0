"""What counts as gone and as new between two maps."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import ArrayLike

from echoplan.arrays import FloatArray
from echoplan.geometry import lines_through
from echoplan.mapping.changes import Looks, contradicts, find_changes, outdated
from echoplan.model import Changes, Cylinder, FeatureMap, Wall

# Views from stations in the west to the wall in the east, of an earlier and a later recording; what stands in them.
VIEW = np.array([[[0.0, 0.0], [4.0, 0.0]], [[0.0, 0.2], [4.0, 0.2]]])
LATER = np.array([[[0.0, 0.05], [4.0, 0.05]], [[0.0, 0.15], [4.0, 0.15]]])
EAST = [[4.0, -1.0], [4.0, 1.0]]
NOWHERE = np.zeros((0, 2))
BOX = [[2.0, -0.5], [2.0, 0.5]]


def wall(ends: ArrayLike) -> Wall:
    ends_xy = np.asarray(ends, dtype=np.float64)
    angle, offset = lines_through(ends_xy[0], ends_xy[1]).tolist()
    return Wall(normal_angle=angle, offset=offset, endpoints_xy=ends_xy, covariance=1e-6 * np.eye(2))


def pillar(x: float, y: float) -> Cylinder:
    return Cylinder(center_xy=np.array([x, y]), radius=0.1, covariance=1e-6 * np.eye(3))


def room(*walls: ArrayLike, cylinders: tuple[Cylinder, ...] = ()) -> FeatureMap:
    return FeatureMap(method="joint", walls=tuple(map(wall, walls)), cylinders=cylinders)


def detections(feature_map: FeatureMap) -> FloatArray:
    """Views from close to its walls to places all along them."""
    shares = np.linspace(0.0, 1.0, 20)[:, None]
    ends = [each.endpoints_xy for each in feature_map.walls]
    feet = np.concatenate([np.zeros((0, 2)), *(first + shares * (last - first) for first, last in ends)])
    return np.stack([feet - 0.01, feet], axis=1)


def changes(
    before: FeatureMap,
    after: FeatureMap,
    *,
    earlier: FloatArray = VIEW,
    later: FloatArray = LATER,
    paths: tuple[FloatArray, FloatArray] = (NOWHERE, NOWHERE),
    missed: tuple[float, float] = (0.0, 0.0),
) -> Changes:
    return find_changes(
        before,
        after,
        earlier=looks(before, earlier, path=paths[0], misses=missed[0]),
        later=looks(after, later, path=paths[1], misses=missed[1]),
    )


def looks(feature_map: FeatureMap, views: FloatArray, *, path: FloatArray, misses: float) -> Looks:
    return Looks(np.concatenate([detections(feature_map), views]), path, lambda walls: np.full(len(walls), misses))


def test_nothing_changes_between_equal_maps() -> None:
    assert not changes(room(EAST, BOX), room(EAST, BOX))


def test_a_wall_through_which_the_robot_measures_now_is_gone() -> None:
    found = changes(room(EAST, BOX), room(EAST))
    assert np.array_equal(found.gone_walls, [BOX])
    assert not any((found.new_walls, found.gone_cylinders, found.new_cylinders))


def test_a_wall_through_which_it_measured_before_is_new() -> None:
    found = changes(room(EAST), room(EAST, BOX))
    assert np.array_equal(found.new_walls, [BOX])
    assert not found.gone_walls


def test_a_single_view_through_a_wall_does_not_make_it_new_or_gone() -> None:
    assert not changes(room(EAST), room(EAST, BOX), earlier=VIEW[:1])
    assert not changes(room(EAST, BOX), room(EAST), later=LATER[:1])


def test_two_views_from_one_place_count_once() -> None:
    twice, between = np.concatenate([LATER[:1], LATER[:1]]), room(EAST, BOX)
    twice[1] += [[1e-4, 0.0], [0.0, 0.05]]
    # A view that is too short to lead through anything is not one of them.
    short = np.array([[[3.9, 0.0], [4.0, 0.0]]])
    assert not changes(between, room(EAST), later=np.concatenate([short, twice]))
    assert changes(between, room(EAST), later=np.concatenate([short, twice, LATER[1:]])).gone_walls


def test_a_wall_where_no_station_detected_it_is_neither_gone_nor_new() -> None:
    maps = room(EAST, BOX), room(EAST)
    nothing = Looks(VIEW, NOWHERE, lambda walls: np.full(len(walls), -99.0))
    assert not find_changes(*maps, earlier=nothing, later=nothing)
    assert not find_changes(*maps[::-1], earlier=nothing, later=nothing)


def test_a_short_wall_is_new_if_no_part_of_it_was_there_before() -> None:
    short = [[2.0, -0.05], [2.0, 0.1]]
    assert np.array_equal(changes(room(EAST), room(EAST, short), missed=(-36.0, 0.0)).new_walls, [short])
    # A wall that is 15 cm longer than before is not.
    longer = [[2.0, -1.0], [2.0, 0.1]]
    assert not changes(room(EAST, [[2.0, -1.0], [2.0, -0.05]]), room(EAST, longer), missed=(-36.0, 0.0))


def test_a_wall_through_which_no_view_leads_is_not_gone() -> None:
    assert not changes(room(EAST, BOX), room(EAST), later=np.zeros((0, 2, 2)))


def test_a_wall_that_three_stations_miss_is_gone_or_new() -> None:
    nobody, maps = np.zeros((0, 2, 2)), (room(EAST, BOX), room(EAST))
    found = [changes(*maps, later=nobody, missed=(0.0, each)) for each in (-36.0, -35.0)]
    assert [len(each.gone_walls) for each in found] == [1, 0]
    found = [changes(*maps[::-1], earlier=nobody, missed=(each, 0.0)) for each in (-36.0, -35.0)]
    assert [len(each.new_walls) for each in found] == [1, 0]


def test_one_view_through_a_wall_weighs_half_of_what_makes_it_gone_or_new() -> None:
    maps = room(EAST, BOX), room(EAST)
    found = [changes(*maps, later=LATER[:1], missed=(0.0, each)) for each in (-18.0, -17.0)]
    assert [len(each.gone_walls) for each in found] == [1, 0]
    found = [changes(*maps[::-1], earlier=VIEW[:1], missed=(each, 0.0)) for each in (-18.0, -17.0)]
    assert [len(each.new_walls) for each in found] == [1, 0]


@pytest.mark.parametrize(
    ("path", "drove_through"),
    [
        ([[1.0, 0.2], [3.0, 0.2]], True),
        ([[1.0, 0.2], [1.8, 0.2], [1.0, 0.0]], False),
        ([[1.0, 0.2], [np.nan, np.nan], [3.0, 0.2]], False),
    ],
    ids=["through", "before", "two recordings"],
)
def test_what_the_robot_drove_through_is_gone_or_new(path: ArrayLike, *, drove_through: bool) -> None:
    nobody, driven = np.zeros((0, 2, 2)), np.array(path)
    post = pillar(2.0, 0.2)
    empty, full = room(EAST), room(EAST, BOX, cylinders=(post,))
    found = changes(full, empty, earlier=nobody, later=nobody, paths=(NOWHERE, driven))
    assert (len(found.gone_walls), len(found.gone_cylinders)) == (drove_through, drove_through)
    found = changes(empty, full, earlier=nobody, later=nobody, paths=(driven, NOWHERE))
    assert (len(found.new_walls), len(found.new_cylinders)) == (drove_through, drove_through)
    assert not changes(full, empty, later=nobody, paths=(driven, NOWHERE))


def test_a_wall_where_nobody_looked_before_is_not_new() -> None:
    assert not changes(room(EAST), room(EAST, BOX), earlier=np.zeros((0, 2, 2)))


def test_the_end_of_a_wall_is_gone_only_if_the_robot_measured_through_it() -> None:
    long, short = [[2.0, -2.0], [2.0, 2.0]], [[2.0, -2.0], [2.0, -0.5]]
    most = [[2.0, -2.0], [2.0, 1.0]]
    assert not changes(room(EAST, long), room(EAST, most), later=np.zeros((0, 2, 2)))
    assert changes(room(EAST, long), room(EAST, short)).gone_walls


@pytest.mark.parametrize(("sigma", "count"), [(np.nan, 1), (0.1, 1), (0.6, 0)])
def test_an_uncertain_end_of_a_wall_is_neither_gone_nor_new(sigma: float, count: int) -> None:
    # The walls differ by 1 m.
    short = room(EAST, [[2.0, -2.0], [2.0, -0.5]])
    rough = replace(wall([[2.0, -2.0], [2.0, 0.5]]), endpoint_sigmas=np.array([np.nan, sigma]))
    long = replace(short, walls=(wall(EAST), rough))
    assert len(changes(long, short).gone_walls) == count
    assert len(changes(short, long).new_walls) == count


def test_what_was_only_inferred_is_neither_gone_nor_new() -> None:
    # The piece that differs is the one that the views cross.
    short = wall([[2.0, -2.0], [2.0, -0.5]])
    long = wall([[2.0, -2.0], [2.0, 0.5]])
    guessed = replace(long, inferred=np.array([0.0, 1.0]))
    maps = [replace(room(EAST), walls=(wall(EAST), each)) for each in (short, long, guessed)]
    assert changes(maps[1], maps[0]).gone_walls
    assert changes(maps[0], maps[1]).new_walls
    assert not changes(maps[2], maps[0])
    assert not changes(maps[0], maps[2])
    # All of a wall may be inferred in a file that was written by hand.
    assert not changes(replace(maps[1], walls=(replace(long, inferred=np.array([3.0, 3.0])),)), maps[0])


def test_later_views_begin_at_no_earlier_station_and_the_later_path_after_the_earlier_one() -> None:
    first, second = np.array([[0.0, 0.0], [1.0, 0.0]]), np.array([[np.nan, np.nan], [0.0, 1.0]])
    for views, path in ((VIEW, first), (VIEW[:0], NOWHERE)):
        both = looks(room(), np.concatenate([views, LATER]), path=np.concatenate([path, second]), misses=0.0)
        later = looks(room(), views, path=path, misses=0.0).later(both)
        assert np.array_equal(later.views_xy, LATER)
        assert np.array_equal(later.path_xy, second, equal_nan=True)


def test_a_recording_that_measures_through_most_walls_is_of_another_place() -> None:
    # Both views go through the box, and end at the wall in the east.
    both = np.concatenate([VIEW, LATER])
    assert contradicts(room(BOX), both)
    assert not contradicts(room(EAST, BOX), both)
    assert not contradicts(room(EAST), both)
    assert not contradicts(room(BOX), np.zeros((0, 2, 2)))


def test_only_the_piece_that_differs_is_reported() -> None:
    found = changes(room(EAST, [[2.0, -2.0], [2.0, 2.0]]), room(EAST, [[2.0, 1.0], [2.0, 2.0]]))
    assert len(found.gone_walls) == 1
    assert np.allclose(np.sort(found.gone_walls[0][:, 1]), [-2.0, 0.95])


def test_small_differences_are_no_changes() -> None:
    assert not changes(room(EAST, BOX), room(EAST, [[2.03, -0.5], [2.03, 0.5]]))
    assert not changes(room(EAST, BOX), room(EAST, [[2.0, -0.4], [2.0, 0.4]]))


def test_views_through_one_side_of_a_body_count_for_all_its_sides() -> None:
    # Two views lead through the front, none through the side.
    front, side = [[2.0, -0.05], [2.0, 0.3]], [[2.0, 0.3], [2.3, 0.3]]
    assert len(changes(room(EAST), room(EAST, front, side)).new_walls) == 2
    assert not changes(room(EAST), room(EAST, side))


THIRD = np.array([[[0.0, 0.1], [4.0, 0.1]]])
THROUGH_THREE_TIMES = np.concatenate([LATER, THIRD])


def out_of_date(
    before: FeatureMap, *, later: FloatArray, detected: FeatureMap, misses: float = 0.0
) -> list[FloatArray]:
    """The walls of a map that are there no more, of which later stations detect some."""
    earlier = looks(before, VIEW, path=NOWHERE, misses=0.0)
    found = outdated(before, earlier=earlier, later=looks(detected, later, path=NOWHERE, misses=misses))
    return [each.endpoints_xy for each in found]


@pytest.mark.parametrize(
    ("later", "misses", "is_out_of_date"),
    [
        (LATER, 0.0, False),
        (THROUGH_THREE_TIMES, 0.0, True),
        (LATER, -17.0, False),
        (LATER, -18.0, True),
        (LATER[:0], -53.0, False),
        (LATER[:0], -54.0, True),
    ],
)
def test_what_all_recordings_speak_for_is_out_of_date_if_more_speaks_against_it(
    later: FloatArray, misses: float, *, is_out_of_date: bool
) -> None:
    found = out_of_date(room(EAST, BOX), later=later, detected=room(EAST), misses=misses)
    assert np.array_equal(found, [BOX] if is_out_of_date else [])


def test_what_a_later_station_detects_is_never_out_of_date() -> None:
    assert not out_of_date(room(EAST, BOX), later=THROUGH_THREE_TIMES, detected=room(EAST, BOX))


def test_what_no_earlier_station_detected_is_never_out_of_date() -> None:
    before = room(EAST, BOX)
    earlier, later = (looks(room(EAST), each, path=NOWHERE, misses=0.0) for each in (VIEW, THROUGH_THREE_TIMES))
    assert not outdated(before, earlier=earlier, later=later)


def test_views_through_ends_that_were_only_inferred_count_too() -> None:
    inferred = replace(wall([[2.0, -1.5], [2.0, 0.5]]), inferred=np.array([0.0, 0.6]))
    before = FeatureMap(method="joint", walls=(wall(EAST), inferred))
    views = THROUGH_THREE_TIMES + np.array([0.0, 0.2])
    assert len(out_of_date(before, later=views, detected=room(EAST))) == 1


def test_a_view_that_ends_where_a_wall_was_only_inferred_does_not_detect_it() -> None:
    # A side of a cupboard was drawn up to the wall behind it, which is detected there.
    side = replace(wall([[2.0, 0.1], [4.0, 0.1]]), inferred=np.array([0.0, 0.4]))
    before = FeatureMap(method="joint", walls=(wall(EAST), side))
    views = np.array([[[3.0, y], [3.0, 4.0]] for y in (-1.0, -1.1, -1.2)])
    assert len(out_of_date(before, later=views, detected=room(EAST))) == 1


def test_views_through_one_side_of_a_body_make_all_its_sides_out_of_date() -> None:
    side = [[2.0, -0.5], [2.8, -0.5]]
    found = out_of_date(room(EAST, BOX, side), later=THROUGH_THREE_TIMES, detected=room(EAST))
    assert np.array_equal(found, [BOX, side])


def test_a_map_without_walls_has_none_out_of_date() -> None:
    assert not out_of_date(room(), later=LATER[:0], detected=room())


def test_the_wall_that_a_view_ends_at_is_not_crossed() -> None:
    assert not changes(room(BOX), room(EAST, BOX))


# Views that lead through one of two pillars each.
LOW, HIGH = VIEW, VIEW + np.array([0.0, 0.5])
HERE, THERE = pillar(1.0, 0.6), pillar(3.0, 0.1)


def test_cylinders_are_gone_and_new() -> None:
    found = changes(room(EAST, cylinders=(HERE,)), room(EAST, cylinders=(THERE,)), earlier=LOW, later=HIGH)
    assert [each.center_xy.tolist() for each in found.gone_cylinders] == [[1.0, 0.6]]
    assert [each.center_xy.tolist() for each in found.new_cylinders] == [[3.0, 0.1]]


def test_a_false_cylinder_through_which_its_own_recording_looks_is_neither_gone_nor_new() -> None:
    both = np.concatenate([LOW, HIGH])
    assert not changes(room(EAST, cylinders=(HERE,)), room(EAST, cylinders=(THERE,)), earlier=both, later=both)


def test_a_cylinder_beside_all_views_is_neither_gone_nor_new() -> None:
    found = changes(room(EAST, cylinders=(pillar(1.0, 2.0),)), room(EAST, cylinders=(pillar(3.0, -2.0),)))
    assert not found


def test_empty_maps_have_no_changes() -> None:
    assert not changes(room(), room())
