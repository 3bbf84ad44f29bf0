import math

import numpy as np
import pytest

from echoplan.acoustics.predicted_echo import predict_echo, shape_of
from echoplan.acoustics.views import in_view, views_of
from echoplan.arrays import FloatArray
from helpers.expectations import REACH, SONAR, corner, cylinder, edge, round_wall, wall

LEAST = -4.0
REFLECTORS = [wall(0.3, 1.5), wall(2.0, -0.2), cylinder(0.4, 1.0, 0.1), corner(2.0, 1.5), edge(0.3, 0.9)]
REFLECTORS += [round_wall(0.3, -0.2, 2.4), round_wall(0.6, 0.5, 1.2)]


def pings(count: int) -> FloatArray:
    """Sensors all over a room, looking everywhere."""
    rng = np.random.default_rng(11)
    places, turns = rng.uniform(-1.5, 1.5, (count, 2)), rng.uniform(-math.pi, math.pi, count)
    return np.column_stack([places, np.cos(turns), np.sin(turns)])


@pytest.mark.parametrize("reflector", REFLECTORS)
def test_no_ping_that_could_detect_a_reflector_is_left_out(reflector: FloatArray) -> None:
    tables, shape = SONAR.tabulated(), shape_of(reflector)
    views = views_of(tables, shape, LEAST, REACH)
    detected = 0
    for ping in pings(3000):
        place = (float(ping[0]), float(ping[1]), float(ping[2]), float(ping[3]))
        depth, excess, _ = predict_echo(tables, shape, place)
        if excess > LEAST and 0.0 < depth <= REACH:
            detected += 1
            assert in_view(views, shape, place)
    assert detected > 5


@pytest.mark.parametrize("reflector", REFLECTORS)
def test_most_pings_that_cannot_detect_it_are_left_out(reflector: FloatArray) -> None:
    tables, shape = SONAR.tabulated(), shape_of(reflector)
    views = views_of(tables, shape, LEAST, REACH)
    inside = [in_view(views, shape, (float(x), float(y), float(u), float(v))) for x, y, u, v in pings(2000)]
    audible = [
        predict_echo(tables, shape, (float(x), float(y), float(u), float(v)))[1] > LEAST for x, y, u, v in pings(2000)
    ]
    assert sum(inside) < sum(audible) + 0.05 * len(audible)


def test_views_narrow_with_depth() -> None:
    views = views_of(SONAR.tabulated(), shape_of(wall(0.0, 2.0)), LEAST, REACH)
    assert (np.diff(views.cosines) >= 0.0).all()
    assert views.cosines[-1] > views.cosines[1]


def test_nothing_behind_or_beyond_the_reach_is_in_view() -> None:
    shape = shape_of(wall(0.0, 2.0))
    views = views_of(SONAR.tabulated(), shape, LEAST, REACH)
    assert in_view(views, shape, (1.0, 0.0, 1.0, 0.0))
    assert not in_view(views, shape, (2.5, 0.0, 1.0, 0.0))
    assert not in_view(views, shape, (1.0, 0.0, -1.0, 0.0))
    assert not in_view(views, shape, (2.0 - REACH - 0.1, 0.0, 1.0, 0.0))
