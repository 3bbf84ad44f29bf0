import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.classical.points import Cloud, circle_covariance, find_circles, fit_taubin
from echoplan.classical.points.circles import CircleSettings
from echoplan.geometry import directions

SETTINGS = CircleSettings()
CIRCLE = np.array([1.0, -2.0, 0.15])


def rim(start: float = 0.0, stop: float = 3.0, *, count: int = 30) -> FloatArray:
    """Points on the rim of the circle."""
    points: FloatArray = CIRCLE[:2] + CIRCLE[2] * directions(np.linspace(start, stop, count))
    return points


def cloud_of(points: FloatArray) -> Cloud:
    return Cloud(points_xy=points, weights=np.ones(len(points)))


def test_a_circle_comes_back_from_a_part_of_its_rim() -> None:
    (circle,) = find_circles(cloud_of(rim(0.0, 2.0)), SETTINGS)
    assert circle.parameters == pytest.approx(CIRCLE)


def test_what_lies_off_the_rim_is_left_out() -> None:
    inside = CIRCLE[:2] + np.array([[0.02, 0.01], [0.08, 0.0]])
    (circle,) = find_circles(cloud_of(np.concatenate([rim(0.0, 5.0, count=60), inside])), SETTINGS)
    assert circle.parameters == pytest.approx(CIRCLE, abs=1e-6)
    assert circle.members.max() == 59


def test_each_knot_has_a_circle_of_its_own() -> None:
    beside = rim() + np.array([1.0, 0.0])
    circles = find_circles(cloud_of(np.concatenate([rim(), beside])), SETTINGS)
    assert sorted(circle.parameters[0] for circle in circles) == pytest.approx([1.0, 2.0])


@pytest.mark.parametrize(
    "points",
    [rim(0.0, 0.9), rim(count=5), rim() * [1.0, 0.0], np.ones((9, 2)), np.ones((1, 2)), np.zeros((0, 2))],
    ids=["a short arc", "few points", "a line", "one place", "one point", "nothing"],
)
def test_too_little_is_no_circle(points: FloatArray) -> None:
    assert find_circles(cloud_of(points), SETTINGS) == []


@pytest.mark.parametrize("limits", [{"max_radius": 0.1}, {"min_radius": 0.2}])
def test_a_circle_must_be_of_a_likely_size(limits: dict[str, float]) -> None:
    assert find_circles(cloud_of(rim()), CircleSettings(**limits)) == []


def test_the_fit_is_hardly_biased_where_the_arc_is_short() -> None:
    rng = np.random.default_rng(6)
    radii = []
    for _ in range(300):
        fitted = fit_taubin(cloud_of(rim(0.0, 2.0, count=60) + rng.normal(0, 0.003, size=(60, 2))))
        assert fitted is not None
        radii.append(fitted[2])
    assert np.mean(radii) == pytest.approx(0.15, abs=0.002)


def test_the_stated_covariance_holds_for_points_that_err_by_themselves() -> None:
    rng = np.random.default_rng(7)
    settings, squares = CircleSettings(common_sigma=1e-9, band=0.005), []
    for _ in range(300):
        cloud = cloud_of(rim(0.0, 4.0, count=60) + rng.normal(0, 0.003, size=(60, 2)))
        fitted = fit_taubin(cloud)
        assert fitted is not None
        covariance = circle_covariance(cloud, fitted, settings)
        assert covariance is not None
        squares.append((fitted - CIRCLE) @ np.linalg.solve(covariance, fitted - CIRCLE))
    assert np.mean(squares) == pytest.approx(3.0, rel=0.2)


def test_points_in_one_direction_leave_a_circle_undetermined() -> None:
    assert circle_covariance(cloud_of(np.repeat(rim(count=1), 6, axis=0)), CIRCLE, SETTINGS) is None
