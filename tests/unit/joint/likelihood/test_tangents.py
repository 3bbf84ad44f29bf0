import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.geometry import directions
from echoplan.joint.likelihood.tangents import tangents
from helpers.expectations import round_wall

STATIONS = [np.array([0.9, 0.4]), np.array([0.31, -0.2]), np.array([-1.3, -0.9]), np.array([0.3, -0.2])]


def touched(walls: FloatArray, extents: FloatArray) -> FloatArray:
    """Return the middle of each extent [m], shape (4, 2)."""
    normals, along = directions(walls[:, 1]), directions(walls[:, 1] + np.pi / 2)
    points: FloatArray = walls[:, 2:3] * normals + extents.mean(axis=1)[:, None] * along
    return points


@pytest.mark.parametrize("station", STATIONS)
def test_tangents_touch_the_round_wall(station: FloatArray) -> None:
    walls, extents = tangents(round_wall(0.3, -0.2, 2.0), station)
    away = touched(walls, extents) - (0.3, -0.2)
    assert np.hypot(*away.T) == pytest.approx([2.0] * 4)
    assert np.sum(away * directions(walls[:, 1]), axis=1) == pytest.approx([2.0] * 4)


@pytest.mark.parametrize("station", STATIONS)
def test_sound_returns_from_the_nearest_and_the_farthest_point(station: FloatArray) -> None:
    points = touched(*tangents(round_wall(0.3, -0.2, 2.0), station))
    beyond = np.hypot(*(station - (0.3, -0.2)))
    assert np.hypot(*(points - station).T)[:2] == pytest.approx([2.0 - beyond, 2.0 + beyond])


@pytest.mark.parametrize("station", STATIONS)
def test_sound_returns_after_two_reflections(station: FloatArray) -> None:
    walls, extents = tangents(round_wall(0.3, -0.2, 2.0), station)
    points = touched(walls, extents)
    for normal, here, there in zip(directions(walls[2:, 1]), points[2:], points[:1:-1], strict=True):
        coming, going = here - station, there - here
        mirrored = coming - 2.0 * (coming @ normal) * normal
        assert mirrored / np.hypot(*mirrored) == pytest.approx(going / np.hypot(*going), abs=1e-9)
