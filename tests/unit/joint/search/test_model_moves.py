import numpy as np
import pytest

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import FloatArray
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.ping_likelihood import PingLikelihood
from echoplan.joint.search.acceptance import AcceptanceSettings, AcceptanceTest
from echoplan.joint.search.model_moves import reclassified
from helpers.expectations import NOISE, ROOM, corner, cylinder, likelihood, listening, pings_of, rescored, wall

COLUMN = cylinder(0.2, 0.9, 0.25)
# A wall that touches the cylinder where most stations detect it, which a greedy search may find first.
TOUCHING = wall(np.pi / 2, 0.66)


def detected(*truth: FloatArray, noise: float) -> PingLikelihood:
    """Return the likelihood of pings of some landmarks."""
    readings = pings_of(listening(), truth, noise=NOISE, rng=np.random.default_rng(1))
    return likelihood(readings, noise=noise)


def after_selection(estimate: PingLikelihood, *known: FloatArray) -> list[Hypothesis]:
    """Return the landmarks after class selection."""
    acceptance = AcceptanceTest(estimate.measurements, half_aperture=0.61, settings=AcceptanceSettings())
    return reclassified(estimate, rescored(estimate, known), acceptance)


def test_a_wall_that_touches_a_cylinder_becomes_the_cylinder() -> None:
    # With pose errors readings scatter by centimetres, so that the wall agrees with all stations.
    estimate = detected(*ROOM, COLUMN, noise=0.03)
    assert rescored(estimate, [*ROOM, TOUCHING])[4].llr > 12.0
    features = after_selection(estimate, *ROOM, TOUCHING)
    assert [each.kind for each in features] == [Kind.WALL] * 4 + [Kind.CYLINDER]
    # All stations are on one side, so they determine its front better than its radius.
    _, x, y, radius = features[4].reflector
    assert (x, y - radius) == pytest.approx((0.2, 0.65), abs=0.01)


def test_correct_classes_are_kept() -> None:
    truth = [*ROOM, COLUMN, corner(2.0, 1.5)]
    estimate = detected(*truth, noise=NOISE)
    assert [each.reflector.tolist() for each in after_selection(estimate, *truth)] == [row.tolist() for row in truth]


def test_a_corner_that_a_wall_explains_better_becomes_a_wall() -> None:
    # From two stations half a metre apart the specular points of the wall differ as much: no corner explains both.
    stations = listening([(0.0, 0.0), (0.0, 0.5)])
    estimate = likelihood(pings_of(stations, [wall(0.0, 2.0)], noise=NOISE, rng=np.random.default_rng(1)))
    (feature,) = after_selection(estimate, corner(2.0, 0.1))
    assert feature.is_wall
    assert feature.line == pytest.approx([0.0, 2.0], abs=0.02)


def test_a_corner_does_not_become_a_cylinder() -> None:
    estimate = detected(*ROOM, COLUMN, noise=0.03)
    vertex = corner(0.2, 0.66)
    features = after_selection(estimate, *ROOM, vertex)
    assert features[4].reflector.tolist() == vertex.tolist()


def across(x: float, y: float, degrees: float) -> FloatArray:
    """Return a wall through a point."""
    angle = np.radians(degrees)
    return wall(angle, x * np.cos(angle) + y * np.sin(angle))


@pytest.mark.parametrize(("known", "kind"), [(2, Kind.CORNER), (0, Kind.WALL)], ids=["known walls", "by itself"])
def test_a_short_wall_across_the_ends_of_known_walls_becomes_their_corner(known: int, kind: Kind) -> None:
    # Two stations detect the corner from about one direction, like a wall; the third does not detect it.
    stations = listening([(-0.6, -0.7), (-0.4, -0.5), (-1.5, 1.0)])
    walls = [wall(0.0, 2.0), wall(np.pi / 2, 1.5)]
    rng = np.random.default_rng(3)
    detected, silent = (
        pings_of(stations, truth, noise=NOISE, rng=rng) for truth in ([*walls, corner(2.0, 1.5)], walls)
    )
    estimate = likelihood(
        detected._replace(readings=np.where(stations.stations < 2, detected.readings, silent.readings))
    )
    features = after_selection(estimate, *walls[:known], across(2.0, 1.5, 40.0))
    assert features[-1].kind is kind


@pytest.mark.parametrize(("known", "kind"), [(2, Kind.CORNER), (0, Kind.WALL)], ids=["known walls", "by itself"])
def test_an_ambiguous_echo_is_a_corner_only_if_known_walls_end_there(known: int, kind: Kind) -> None:
    # All stations are on one line before it: the specular points of a wall would be at the corner.
    stations = listening([(0.4, 0.03), (0.0, -0.03), (-0.5, 0.0)])
    walls = [across(2.0, 0.0, 45.0), across(2.0, 0.0, -45.0)]
    rng = np.random.default_rng(2)
    estimate = likelihood(pings_of(stations, [corner(2.0, 0.0)], noise=NOISE, rng=rng))
    alone = rescored(estimate, [corner(2.0, 0.0)])[0].llr
    alternative = rescored(estimate, [wall(0.0, 2.0)])[0].llr
    assert alternative < alone < alternative + AcceptanceSettings().min_log_likelihood_ratio
    features = after_selection(estimate, *walls[:known], corner(2.0, 0.0))
    assert features[-1].kind is kind
