import numpy as np
import pytest

from echoplan.errors import InvalidValueError
from echoplan.extraction import (
    Cluster,
    LocatedPoint,
    MdpSettings,
    compensated_distances,
    fit_parabola,
    middle_point,
    minimum_distance_point,
)
from echoplan.geometry import directions
from echoplan.model import Pings
from helpers import scenes


def test_the_parabola_is_the_least_squares_one() -> None:
    rng = np.random.default_rng(1)
    x = rng.uniform(2.0, 3.0, 40)
    y = 1.0 + 0.3 * (x - 2.4) ** 2 + rng.normal(0, 0.01, 40)
    parabola = fit_parabola(x, y)
    assert parabola is not None
    a2, a1, a0 = np.polyfit(x - parabola.center, y, 2)
    assert np.allclose(parabola.coefficients, [a0, a1, a2])


def test_the_parabola_is_solved_well_where_the_printed_normal_equations_fail() -> None:
    x = 1e4 + np.linspace(0.0, 1.0, 50)
    y = 0.5 + (x - 1e4 - 0.3) ** 2
    design = np.vander(x, 3, increasing=True)
    printed = np.linalg.solve(design.T @ design, design.T @ y)
    printed_vertex = -printed[1] / (2 * printed[2])
    parabola = fit_parabola(x, y)
    assert parabola is not None
    assert parabola.vertex == pytest.approx([1e4 + 0.3, 0.5], abs=1e-6)
    assert abs(printed_vertex - (1e4 + 0.3)) > 1e-3


def test_every_echo_of_a_wall_gives_its_distance_once_the_arm_is_taken_out() -> None:
    bearings = scenes.around(1.0, np.radians(30))
    cluster = scenes.cluster(bearings, scenes.wall_ranges(bearings, normal=1.0, distance=1.2))
    assert np.ptp(cluster.pings.ranges) > 0.006
    assert compensated_distances(cluster, normal=1.0, depth=1.15) == pytest.approx(np.full(len(bearings), 1.2))


def test_two_directions_leave_a_parabola_undetermined() -> None:
    assert fit_parabola(np.array([0.0, 0.0, 1.0]), np.array([1.0, 2.0, 3.0])) is None


def test_the_covariance_of_the_vertex_is_that_of_repeated_trials() -> None:
    rng = np.random.default_rng(2)
    x = np.linspace(-0.5, 0.5, 61)
    truth = 1.0 + 0.4 * (x - 0.1) ** 2
    fits = [fit_parabola(x, truth + rng.normal(0, 0.002, len(x))) for _ in range(400)]
    vertices = np.array([fit.vertex for fit in fits if fit is not None])
    stated = np.mean([fit.vertex_covariance for fit in fits if fit is not None], axis=0)
    assert np.sqrt(np.diag(stated)) == pytest.approx(vertices.std(axis=0), rel=0.15)


@pytest.mark.parametrize("normal", [0.0, 3.0, -2.0])
def test_a_wall_is_found_where_it_is(normal: float) -> None:
    bearings = scenes.around(normal, np.radians(35))
    walk = 0.02 * ((bearings - normal) / 0.6) ** 4
    cluster = scenes.cluster(bearings, scenes.wall_ranges(bearings, normal=normal, distance=1.2) + walk)
    point = minimum_distance_point(cluster)
    assert point is not None
    assert point.bearing == pytest.approx(normal, abs=1e-6)
    assert point.distance == pytest.approx(1.2, abs=0.003)


@pytest.mark.parametrize(("radius", "width"), [(0.1, 28), (0.0, 20)])
def test_a_curved_object_is_found_under_its_own_hypothesis(radius: float, width: int) -> None:
    bearings = scenes.around(0.4, np.radians(width))
    ranges = scenes.cylinder_ranges(bearings, normal=0.4, distance=0.9, radius=radius, arm=scenes.ARM)
    ranges = ranges + 0.01 * (bearings - 0.4) ** 2
    own = minimum_distance_point(scenes.cluster(bearings, ranges), radius=radius)
    assert own is not None
    assert own.distance == pytest.approx(0.9, abs=1e-6)
    assert own.bearing == pytest.approx(0.4, abs=1e-6)


def test_a_lopsided_cluster_still_shows_the_normal() -> None:
    bearings = scenes.around(0.0, np.radians(35))[15:]
    ranges = scenes.wall_ranges(bearings, normal=0.0, distance=1.0) + 0.05 * bearings**2
    point = minimum_distance_point(scenes.cluster(bearings, ranges))
    assert point is not None
    assert point.bearing == pytest.approx(0.0, abs=1e-6)


def test_a_flank_without_a_nearest_point_says_so() -> None:
    bearings = scenes.around(0.5, np.radians(10))
    ranges = scenes.wall_ranges(bearings, normal=0.5, distance=1.0) + 0.1 * bearings**2
    assert minimum_distance_point(scenes.cluster(bearings, ranges)) is None


def test_a_hollow_profile_has_no_nearest_point() -> None:
    bearings = scenes.around(0.0, np.radians(20))
    ranges = scenes.wall_ranges(bearings, normal=0.0, distance=1.0) - 0.1 * bearings**2
    assert minimum_distance_point(scenes.cluster(bearings, ranges)) is None


def test_a_located_point_has_a_position() -> None:
    bearings = scenes.around(np.pi / 2, np.radians(30))
    ranges = scenes.wall_ranges(bearings, normal=np.pi / 2, distance=2.0) + 0.01 * (bearings - np.pi / 2) ** 2
    point = minimum_distance_point(scenes.cluster(bearings, ranges))
    assert point is not None
    assert np.allclose(point.position_xy, [0.0, 2.0], atol=1e-6)


def test_the_middle_of_a_window_stands_for_a_point() -> None:
    bearings = scenes.around(0.7, np.radians(8))
    point = middle_point(scenes.cluster(bearings, np.full(len(bearings), 1.5)), resolution=0.005)
    assert point.bearing == pytest.approx(0.7)
    assert point.distance == pytest.approx(1.5 + scenes.ARM)
    assert np.sqrt(np.diag(point.covariance)) == pytest.approx([np.radians(16), 0.005] / np.sqrt(12))


@pytest.mark.parametrize("curvature", [0.1, 0.02, 0.005])
@pytest.mark.parametrize("radius", [np.inf, 0.1, 0.0])
def test_rounds_of_compensation_settle_on_the_normal_also_where_the_arm_adds_more_than_the_echo_walks(
    curvature: float, radius: float
) -> None:
    # The least reading, from which the rounds start, lies 8 degrees beside the normal.  Taken whole, an error of the
    # start would come back b / (2 a) times as great: 0.25, 1.25 and 5 times with an arm b of 5 cm.
    bearings = scenes.around(0.0, np.radians(35))
    ranges = (
        scenes.wall_ranges(bearings, normal=0.0, distance=1.0)
        if np.isinf(radius)
        else scenes.cylinder_ranges(bearings, normal=0.0, distance=1.0, radius=radius)
    )
    ranges += curvature * bearings**2
    ranges[43] = ranges.min() - 1e-6
    point = minimum_distance_point(scenes.cluster(bearings, ranges), radius=radius)
    assert point is not None
    assert abs(point.bearing) < np.radians(0.5)
    assert point.distance == pytest.approx(1.0, abs=0.001)


def test_one_round_of_compensation_is_not_enough_for_a_start_beside_the_normal() -> None:
    arm, curvature, start = 0.05, 0.1, np.radians(8)
    bearings = scenes.around(0.0, np.radians(35))
    ranges = scenes.wall_ranges(bearings, normal=0.0, distance=1.0) + curvature * bearings**2
    ranges[43] = ranges.min() - 1e-6
    located = [minimum_distance_point(scenes.cluster(bearings, ranges), MdpSettings(iterations=n)) for n in (1, 20)]
    once, settled = (point.bearing for point in located if point is not None)
    assert (once - settled) / (start - settled) == pytest.approx(-arm / (2 * curvature), abs=0.03)


def test_readings_in_steps_are_never_surer_than_their_steps() -> None:
    bearings = scenes.around(0.0, np.radians(30))
    cluster = scenes.cluster(bearings, scenes.wall_ranges(bearings, normal=0.0, distance=1.0) + 0.05 * bearings**2)
    smooth, stepped = (minimum_distance_point(cluster, resolution=step) for step in (0.0, 0.005))
    assert smooth is not None
    assert stepped is not None
    assert stepped.covariance[0, 0] > 100 * smooth.covariance[0, 0]
    assert stepped.distance == smooth.distance


def test_the_nearest_point_of_a_plateau_is_no_less_certain_than_its_window() -> None:
    # Rounding alone gives these readings a curvature, of which the vertex would be uncertain by 10^11 rad.
    bearings = np.radians([-57.0, -56.0, -55.0, -54.0, -53.0, -52.0])
    pings = Pings(
        origins_xy=np.zeros((6, 2)),
        hubs_xy=np.zeros((6, 2)),
        bearings=bearings,
        ranges=np.full(6, 0.59) + 1e-16 * np.arange(-2, 4) ** 2,
        sensors=np.zeros(6, dtype=np.int64),
    )
    point = minimum_distance_point(Cluster(pings=pings, bearings=bearings, right=np.inf, left=np.inf), resolution=0.01)
    assert point is not None
    assert np.sqrt(point.covariance[0, 0]) <= np.radians(5.0) / np.sqrt(12) + 1e-12


def test_sensors_on_arms_of_different_lengths_give_the_same_distance() -> None:
    bearings = scenes.around(0.0, np.radians(30))
    arms = np.where(np.arange(len(bearings)) % 2, 0.05, 0.12)
    pings = Pings(
        origins_xy=arms[:, None] * directions(bearings),
        hubs_xy=np.zeros((len(bearings), 2)),
        bearings=bearings,
        ranges=1.2 - arms * np.cos(bearings),
        sensors=np.arange(len(bearings)) % 2,
    )
    cluster = Cluster(pings=pings, bearings=bearings, right=np.inf, left=np.inf)
    assert compensated_distances(cluster, normal=0.0, depth=1.1) == pytest.approx(np.full(len(bearings), 1.2))


def test_a_point_with_an_impossible_covariance_is_refused() -> None:
    with pytest.raises(InvalidValueError, match="covariance"):
        LocatedPoint(hub_xy=np.zeros(2), bearing=0.0, distance=1.0, covariance=np.diag([-1.0, 1.0]))
