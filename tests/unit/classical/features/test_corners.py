import numpy as np
import pytest

from echoplan.classical.features import (
    AssociationSettings,
    Junction,
    Span,
    associate_corners,
    corner_of,
    crossing_covariance,
    junctions,
)
from echoplan.geometry import intersections
from echoplan.model import CornerKind, Wall
from helpers import scenes

GATES = AssociationSettings()
HUB = (1.4, 0.7)


def meetings() -> list[Junction]:
    """Two corners at the ends of one wall: (0, 0) and (3, 0)."""
    south = Span(line=np.array([-np.pi / 2, 0.0]), low=0.3, high=2.7)
    east = Span(line=np.array([0.0, 3.0]), low=0.4, high=1.5)
    west = Span(line=np.array([np.pi, 0.0]), low=-1.5, high=-0.4)
    return sorted(junctions([south, east, west], max_extension=1.0), key=lambda each: float(each.position_xy[0]))


def wall(angle: float, offset: float, covariance: np.ndarray) -> Wall:
    ends = np.array([[0.0, 0.0], [1.0, 1.0]])
    return Wall(normal_angle=angle, offset=offset, endpoints_xy=ends, covariance=covariance)


def test_a_corner_echo_belongs_to_the_junction_of_its_walls() -> None:
    at_west = scenes.observed_circle((0.0, 0.0, 0.0), HUB)
    at_east = scenes.observed_circle((3.0, 0.0, 0.0), HUB)
    assert associate_corners(meetings(), [at_east, at_west], GATES) == [(at_west,), (at_east,)]


@pytest.mark.parametrize("elsewhere", [(1.5, 1.5), (2.9, 0.0), (3.4, 0.7)])
def test_an_echo_from_where_no_walls_meet_belongs_to_no_corner(elsewhere: tuple[float, float]) -> None:
    assert associate_corners(meetings(), [scenes.observed_circle((*elsewhere, 0.0), HUB)], GATES) == [(), ()]


def test_a_corner_echo_may_come_from_anywhere_in_its_window() -> None:
    beside = float(np.arctan2(-0.7, 1.6)) + 0.3

    def counts(sigma: float) -> list[int]:
        distance = float(np.hypot(1.6, 0.7))
        seen = scenes.observed(HUB, bearing=beside, distance=distance, degrees=(0.9, 0.1, 0.0), bearing_sigma=sigma)
        return [len(each) for each in associate_corners(meetings(), [seen], GATES)]

    assert counts(0.1) == [0, 1]
    assert counts(0.01) == [0, 0]


def test_of_two_corners_that_fit_the_one_whose_distance_fits_better_gets_the_echo() -> None:
    # Seen from straight between them both are as far; the echo is 4 mm nearer to the eastern one's distance.
    hub = (1.498, 0.5)
    distance = float(np.hypot(3.0 - hub[0], 0.5)) - 0.001
    vague = scenes.observed(hub, bearing=-np.pi / 2, distance=distance, degrees=(1.0, 0.0, 0.0), bearing_sigma=1.0)
    assert [len(each) for each in associate_corners(meetings(), [vague], GATES)] == [0, 1]


def test_without_junctions_no_corner_echo_is_associated() -> None:
    assert associate_corners([], [scenes.observed_circle((0.0, 0.0, 0.0), HUB)], GATES) == []


def test_a_corner_has_a_position_and_counts_its_observations() -> None:
    covariance = np.diag([1e-4, 1e-6])
    walls = (wall(-np.pi / 2, 0.0, covariance), wall(0.0, 3.0, covariance))
    (meeting,) = [each for each in meetings() if each.position_xy[0] > 1]
    observations = tuple(
        scenes.observed_circle((3.0, 0.0, 0.0), HUB, sweep=sweep, degrees=(0.8, 0.2, 0.0)) for sweep in (0, 1, 1)
    )
    corner = corner_of(meeting, walls, observations)
    assert corner.position_xy == pytest.approx([3.0, 0.0])
    assert corner.kind is CornerKind.CONCAVE
    assert (corner.pings, corner.stations) == (120, 2)
    assert corner.class_probabilities.corner == pytest.approx(0.8)
    inferred = corner_of(meeting, walls, ())
    assert (inferred.pings, inferred.stations) == (0, 0)
    assert inferred.class_probabilities.corner == 1.0


def test_the_covariance_of_a_crossing_is_that_of_repeated_trials() -> None:
    rng = np.random.default_rng(5)
    covariance = np.array([[1e-4, 2e-5], [2e-5, 4e-5]])
    lines = np.array([[0.4, 3.0], [1.7, 2.0]])
    noise = rng.multivariate_normal(np.zeros(2), covariance, size=(2, 4000))
    points = intersections(lines[0] + noise[0], lines[1] + noise[1])
    first, second = (wall(angle, offset, covariance) for angle, offset in lines)
    assert crossing_covariance(first, second) == pytest.approx(np.cov(points.T), rel=0.1, abs=2e-5)


@pytest.mark.parametrize("turn", [0.5 * np.pi, 1.0, 0.4])
def test_the_flatter_walls_cross_the_less_sure_is_the_crossing(turn: float) -> None:
    # Through the origin, where errors of the angles move nothing.
    covariance = np.diag([1e-6, 1e-6])
    found = crossing_covariance(wall(0.0, 0.0, covariance), wall(turn, 0.0, covariance))
    assert np.trace(found) == pytest.approx(2e-6 / np.sin(turn) ** 2)
