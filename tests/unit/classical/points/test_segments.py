import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.classical.points import Cloud, SegmentSettings, find_segments, fit_orthogonal, line_covariance
from echoplan.geometry import directions, signed_distances

SETTINGS = SegmentSettings()


def on_line(line: tuple[float, float], low: float, high: float, *, count: int = 40) -> FloatArray:
    """Points along a line."""
    coordinates = np.linspace(low, high, count)[:, None]
    points: FloatArray = line[1] * directions(line[0]) + coordinates * directions(line[0] + np.pi / 2)
    return points


def cloud_of(*parts: FloatArray) -> Cloud:
    points = np.concatenate(parts)
    return Cloud(points_xy=points, weights=np.ones(len(points)))


def test_collinear_points_are_one_segment() -> None:
    segments = find_segments(cloud_of(on_line((0.7, 2.0), -1.0, 1.5)), SETTINGS)
    (segment,) = segments.found
    assert segment.line == pytest.approx([0.7, 2.0])
    assert len(segment.members) == 40
    assert len(segments.rest) == 0


def test_a_gap_parts_a_line_into_two() -> None:
    cloud = cloud_of(on_line((0.7, 2.0), -2.0, -0.5), on_line((0.7, 2.0), 0.5, 2.0, count=50))
    first, second = find_segments(cloud, SETTINGS).found
    assert (len(first.members), len(second.members)) == (50, 40)
    assert len(find_segments(cloud, SegmentSettings(max_gap=1.1)).found) == 1


def test_what_lies_on_no_line_is_left() -> None:
    stray = np.array([[0.0, 0.0], [0.4, 0.7], [-0.6, 0.3]])
    segments = find_segments(cloud_of(on_line((0.7, 2.0), -1.0, 1.0), stray), SETTINGS)
    assert len(segments.found) == 1
    assert segments.rest.tolist() == [40, 41, 42]


def test_a_knot_of_points_is_no_segment_and_stays() -> None:
    rng = np.random.default_rng(2)
    knot = rng.normal([1.0, 1.0], 0.02, size=(80, 2))
    segments = find_segments(cloud_of(knot), SETTINGS)
    assert segments.found == []
    assert len(segments.rest) == 80


def test_points_of_little_weight_make_no_segment() -> None:
    points = on_line((0.7, 2.0), -1.0, 1.5)
    assert find_segments(Cloud(points_xy=points, weights=np.full(40, 0.1)), SETTINGS).found == []
    assert len(find_segments(Cloud(points_xy=points, weights=np.full(40, 0.2)), SETTINGS).found) == 1


def test_parallel_faces_of_a_box_stay_two() -> None:
    cloud = cloud_of(on_line((0.7, 2.0), -1.0, 1.0), on_line((0.7, 2.2), -1.0, 1.0))
    offsets = sorted(segment.line[1] for segment in find_segments(cloud, SETTINGS).found)
    assert offsets == pytest.approx([2.0, 2.2])


def test_a_line_through_the_origin_is_a_line() -> None:
    (segment,) = find_segments(cloud_of(on_line((2.5, 0.0), -1.0, 1.0)), SETTINGS).found
    assert abs(np.sin(segment.line[0] - 2.5)) < 1e-9
    assert segment.line[1] == pytest.approx(0.0, abs=1e-12)


def test_regression_is_by_the_distance_across() -> None:
    rng = np.random.default_rng(3)
    steep = on_line((0.02, 1.0), -1.0, 1.0) + rng.normal(0, 0.001, size=(40, 2))
    assert fit_orthogonal(cloud_of(steep)) == pytest.approx([0.02, 1.0], abs=1e-3)


def test_heavier_points_draw_the_line() -> None:
    points = np.array([[0.0, 1.0], [1.0, 1.0], [2.0, 1.0], [3.0, 1.4]])
    light = fit_orthogonal(Cloud(points_xy=points, weights=np.array([1.0, 1.0, 1.0, 1e-6])))
    assert light == pytest.approx([np.pi / 2, 1.0], abs=1e-5)


@pytest.mark.parametrize("line", [(0.4, 3.0), (-2.0, 1.0)])
def test_the_stated_covariance_holds_for_points_that_err_by_themselves(line: tuple[float, float]) -> None:
    rng = np.random.default_rng(4)
    settings = SegmentSettings(common_sigma=1e-6)
    squares = []
    for _ in range(300):
        across = rng.normal(0, 0.01, size=40)[:, None] * directions(line[0])
        cloud = cloud_of(on_line(line, 0.5, 3.0) + across)
        found = fit_orthogonal(cloud)
        error = found - line
        squares.append(error @ np.linalg.solve(line_covariance(cloud, found, settings), error))
    # Two degrees of freedom; the scatter about a fitted line is 38/40 of the true one.
    assert np.mean(squares) == pytest.approx(2.0 * 40 / 38, rel=0.15)


def test_points_of_one_stretch_make_no_line_surer() -> None:
    rng = np.random.default_rng(5)
    points = on_line((0.4, 3.0), 0.0, 2.0) + rng.normal(0, 0.01, size=(40, 2))
    once, often = cloud_of(points), cloud_of(*[points] * 10)
    line = fit_orthogonal(once)
    assert line_covariance(often, line, SETTINGS) == pytest.approx(line_covariance(once, line, SETTINGS))


def test_a_line_is_never_surer_than_what_its_ends_have_in_common() -> None:
    cloud = cloud_of(on_line((0.4, 3.0), -1.0, 1.0))
    covariance = line_covariance(cloud, np.array([0.4, 3.0]), SETTINGS)
    assert signed_distances([0.4, 3.0], cloud.points_xy) == pytest.approx(0.0, abs=1e-12)
    assert covariance == pytest.approx(np.diag([2 * (0.005 / 2) ** 2, 0.005**2 / 2]), abs=1e-12)


def test_no_points_have_no_segments() -> None:
    empty = Cloud(points_xy=np.zeros((0, 2)), weights=np.zeros(0))
    segments = find_segments(empty, SETTINGS)
    assert segments.found == []
    assert len(segments.rest) == 0
