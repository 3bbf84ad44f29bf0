import numpy as np
import pytest

from echoplan.evaluation import MapError, Outline, OutlineSettings
from echoplan.evaluation.outlines import compare_outlines
from echoplan.model import Corner, Cylinder, Truth, Wall
from helpers import maps

FLOOR = Truth(walls_xy=np.array([[[0.0, 0.0], [4.0, 0.0]]]), walls_detected_by=np.array([3]))
NO_CIRCLES, NO_SEGMENTS = np.zeros((0, 3)), np.zeros((0, 2, 2))


def error(*features: Wall | Corner | Cylinder, truth: Truth = FLOOR, min_stations: int = 2) -> MapError:
    settings = OutlineSettings(spacing=0.001)
    return compare_outlines(maps.drawn(*features), truth, min_stations=min_stations, settings=settings)


def test_a_shifted_wall_is_off_by_the_shift_all_along() -> None:
    shifted = error(maps.wall((0, 0.05), (4, 0.05)))
    assert shifted.mean == pytest.approx(0.05)
    assert shifted.median == pytest.approx(0.05)
    assert shifted.hausdorff == pytest.approx(0.05)


def test_half_a_wall_is_accurate_and_incomplete() -> None:
    # Nothing of the map is off; half of the truth is, by 0 to 2 m.
    half = error(maps.wall((0, 0), (2, 0)))
    assert half.map_to_truth.mean == pytest.approx(0.0, abs=1e-12)
    assert half.truth_to_map.mean == pytest.approx(0.5)
    assert half.mean == pytest.approx(0.25)
    assert half.truth_to_map.median == pytest.approx(0.0, abs=1e-3)
    assert half.hausdorff == pytest.approx(2.0, abs=1e-3)


def test_a_wall_too_long_is_complete_and_inaccurate() -> None:
    # Ends 1 m beyond: of 5 m one fifth is off, by 0 to 1 m.
    long = error(maps.wall((-1, 0), (4, 0)))
    assert long.map_to_truth.mean == pytest.approx(0.1)
    assert long.truth_to_map.mean == pytest.approx(0.0, abs=1e-12)
    assert long.hausdorff == pytest.approx(1.0, abs=1e-3)


def test_a_cylinder_counts_by_its_surface() -> None:
    column = Truth(
        walls_xy=NO_SEGMENTS,
        walls_detected_by=np.zeros(0, dtype=int),
        cylinders=np.array([[1.0, 2.0, 0.1]]),
        cylinders_detected_by=np.array([2]),
    )
    thick = error(maps.cylinder((1, 2), 0.13), truth=column)
    assert thick.mean == pytest.approx(0.03)
    assert thick.hausdorff == pytest.approx(0.03)
    inside = error(maps.wall((1.0, 2.0), (1.05, 2.0)), truth=column)
    assert inside.map_to_truth.maximum == pytest.approx(0.1, abs=1e-3)


def test_what_cannot_be_detected_may_be_left_out_but_is_not_wrong() -> None:
    detectable = maps.ROOM.walls_xy[:5]
    silent = maps.wall((0.0, 0.5), (0.0, 2.5))
    room: list[Wall | Cylinder] = [*(maps.wall(*ends) for ends in detectable), maps.cylinder((3.5, 0.6), 0.1)]
    assert error(*room, truth=maps.ROOM).mean == pytest.approx(0.0, abs=1e-12)
    assert error(*room, silent, truth=maps.ROOM).mean == pytest.approx(0.0, abs=1e-12)
    assert error(*room, truth=maps.ROOM, min_stations=1).truth_to_map.maximum == pytest.approx(1.5, abs=1e-3)


def test_an_empty_map_or_an_empty_truth_has_no_distance() -> None:
    for nothing in (error(), error(maps.corner((0, 0))), error(maps.wall((0, 0), (1, 0)), truth=maps.NOWHERE)):
        assert np.isnan([nothing.mean, nothing.median, nothing.hausdorff]).all()


def test_where_nothing_can_be_detected_only_the_map_is_measured() -> None:
    one_sided = error(maps.wall((0, 0.05), (4, 0.05)), min_stations=9)
    assert one_sided.map_to_truth.mean == pytest.approx(0.05)
    assert np.isnan([one_sided.mean, one_sided.median, one_sided.hausdorff]).all()


def test_samples_stand_for_equal_stretches_no_longer_than_the_spacing() -> None:
    wall = Outline(segments_xy=np.array([[[0.0, 1.0], [0.0, 2.0]]]), circles=NO_CIRCLES)
    assert wall.samples(0.4) == pytest.approx(np.array([[0, 1 + 1 / 6], [0, 1.5], [0, 2 - 1 / 6]]))
    ring = Outline(segments_xy=NO_SEGMENTS, circles=np.array([[3.0, 1.0, 0.5]]))
    assert len(ring.samples(0.1)) == 32
    spokes = ring.samples(0.1) - np.array([3.0, 1.0])
    assert np.hypot(*spokes.T) == pytest.approx(0.5)
    assert np.diff(np.unwrap(np.arctan2(spokes[:, 1], spokes[:, 0]))) == pytest.approx(2 * np.pi / 32)


def test_a_cylinder_without_a_radius_is_a_point() -> None:
    point = Outline(segments_xy=NO_SEGMENTS, circles=np.array([[3.0, 1.0, 0.0]]))
    assert point.samples(0.1).tolist() == [[3.0, 1.0]]
    assert point.distances(np.array([[3.0, 1.5], [2.0, 1.0]])).tolist() == [0.5, 1.0]


def test_points_are_infinitely_far_from_an_empty_outline() -> None:
    nothing = Outline(segments_xy=NO_SEGMENTS, circles=NO_CIRCLES)
    assert nothing.distances(np.zeros((2, 2))).tolist() == [np.inf, np.inf]
    assert nothing.samples(0.1).shape == (0, 2)


def test_many_points_are_measured_as_few_are() -> None:
    outline = Outline(segments_xy=maps.ROOM.walls_xy, circles=maps.ROOM.cylinders)
    points = np.random.default_rng(0).uniform(-1, 6, size=(9001, 2))
    halves = [outline.distances(half) for half in np.array_split(points, 90)]
    assert np.array_equal(outline.distances(points), np.concatenate(halves))


def test_a_wall_that_ends_far_away_is_sampled_less_densely() -> None:
    near, far = [[0.0, 0.0], [0.0, 3.0]], [[0.0, 0.0], [1e6, 0.0]]
    samples = Outline(segments_xy=np.array([near, far]), circles=np.zeros((0, 3))).samples(0.01)
    assert 90_000 < len(samples) <= 100_002
    assert len(Outline(segments_xy=np.array([near]), circles=np.zeros((0, 3))).samples(0.01)) == 300
