import math
from dataclasses import replace

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.ping_scores import NO_PING_SCORES
from echoplan.joint.likelihood.track_history import NO_HISTORY
from echoplan.joint.map_extraction.round_walls import chords
from helpers.expectations import round_wall

COVARIANCE = np.diag([1e-6, 4e-6, 9e-6])
NOWHERE = np.zeros((0, 2))


def detected(*bearings: float) -> Hypothesis:
    """A round wall of 2 m that was detected in some directions [degrees]."""
    history = replace(NO_HISTORY, feet=np.radians(np.sort(bearings)), pings=90, supporting=7)
    return Hypothesis(
        reflector=round_wall(1.0, -0.5, 2.0), ping_scores=NO_PING_SCORES, llr_by_station=np.zeros(0), history=history
    )


def bearings_of(points_xy: FloatArray) -> FloatArray:
    """Bearings from the centre [degrees]."""
    away = points_xy - (1.0, -0.5)
    return np.degrees(np.arctan2(away[..., 1], away[..., 0]))


def test_a_wall_detected_all_around_is_closed() -> None:
    walls = list(chords(detected(*range(-180, 180, 30)), COVARIANCE, path_xy=NOWHERE))
    assert len(walls) == 24
    for one, other in zip(walls, [*walls[1:], walls[0]], strict=True):
        assert one.endpoints_xy[1] == pytest.approx(other.endpoints_xy[0])


def test_what_was_not_detected_is_not_drawn() -> None:
    walls = list(chords(detected(150.0, 170.0, -170.0, -150.0, 0.0, 20.0), COVARIANCE, path_xy=NOWHERE))
    drawn = bearings_of(np.array([each.endpoints_xy for each in walls]))
    assert sorted(np.round(drawn[:, 0] % 360.0)) == [0.0, 10.0, 150.0, 165.0, 180.0, 195.0]
    assert sorted(np.round(drawn[:, 1] % 360.0)) == [10.0, 20.0, 165.0, 180.0, 195.0, 210.0]


@pytest.mark.parametrize("bearings", [(), (40.0,), (40.0, 190.0)])
def test_single_points_are_not_drawn(bearings: tuple[float, ...]) -> None:
    assert list(chords(detected(*bearings), COVARIANCE, path_xy=NOWHERE)) == []


def test_there_is_no_wall_where_the_robot_drove() -> None:
    wall = detected(*range(-180, 180, 30))
    path_xy = np.array([[1.0, -0.5], [4.0, -0.6], [4.0, 3.0]])
    driven = list(chords(wall, COVARIANCE, path_xy=path_xy))
    closed = list(chords(wall, COVARIANCE, path_xy=NOWHERE))
    assert len(driven) == len(closed) - 1
    assert not any(abs(each.normal_angle) < math.radians(7.0) for each in driven)


def test_chords_lie_on_the_wall_in_the_mean() -> None:
    (wall,) = chords(detected(0.0, 15.0), COVARIANCE, path_xy=NOWHERE)
    share = np.linspace(0.0, 1.0, 2001)[:, None]
    points = (1.0 - share) * wall.endpoints_xy[0] + share * wall.endpoints_xy[1]
    away = np.hypot(*(points - (1.0, -0.5)).T)
    assert away.mean() == pytest.approx(2.0, abs=1e-4)
    assert np.abs(away - 2.0).max() < 0.5 * 2.0 * (1.0 - math.cos(math.radians(7.5))) * 1.4


def test_the_covariance_of_a_chord_contains_the_turn_of_the_wall() -> None:
    (wall,) = chords(detected(0.0, 15.0), COVARIANCE, path_xy=NOWHERE)
    assert wall.normal_angle == pytest.approx(math.radians(7.5))
    assert math.sqrt(wall.covariance[0, 0]) == pytest.approx(math.radians(15.0) / math.sqrt(12.0))
    # About its middle, a chord is as uncertain as centre and radius, and by its sagitta.
    middle = wall.endpoints_xy.mean(axis=0) @ (-math.sin(wall.normal_angle), math.cos(wall.normal_angle))
    about = np.array([-middle, 1.0])
    expected = np.array([math.cos(wall.normal_angle), math.sin(wall.normal_angle), 1.0]) ** 2 @ np.diag(COVARIANCE)
    sagitta = 2.0 * (1.0 - math.cos(math.radians(7.5)))
    assert about @ wall.covariance @ about == pytest.approx(expected + sagitta**2 / 12.0, rel=0.01)
    assert (wall.pings, wall.stations) == (90, 7)
