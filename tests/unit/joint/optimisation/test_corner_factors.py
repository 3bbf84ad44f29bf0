import numpy as np
import pytest

from echoplan.geometry import directions, intersections
from echoplan.joint.optimisation.corner_factors import crossing_jacobian

PAIRS = [
    ((0.0, 2.0), (np.pi / 2, 1.5)),
    ((0.3, 4.0), (1.9, -0.7)),
    ((-2.5, 1.0), (2.9, 0.2)),
    ((1.0, 0.5), (1.4, 0.6)),
]


@pytest.mark.parametrize("pair", PAIRS)
def test_the_jacobian_of_a_crossing_equals_finite_differences(
    pair: tuple[tuple[float, float], tuple[float, float]],
) -> None:
    lines = np.array(pair)
    found = crossing_jacobian(lines, intersections(*lines))
    step = 1e-6
    for column in range(4):
        nudge = np.zeros((2, 2))
        nudge.flat[column] = step
        ahead, behind = (intersections(*(lines + sign * nudge)) for sign in (1, -1))
        assert found[:, column] == pytest.approx((ahead - behind) / (2 * step), rel=1e-6, abs=1e-6)


def test_shifting_a_wall_moves_its_corner_along_the_other_wall() -> None:
    lines = np.array([(0.3, 4.0), (1.9, -0.7)])
    by_offset = crossing_jacobian(lines, intersections(*lines))[:, 1]
    assert by_offset @ directions(1.9) == pytest.approx(0.0, abs=1e-12)
    assert by_offset @ directions(0.3) == pytest.approx(1.0)


def test_a_corner_moves_farther_for_a_smaller_angle_between_walls() -> None:
    def reach(turn: float) -> float:
        lines = np.array([(0.0, 1.0), (turn, 1.0)])
        return float(np.linalg.norm(crossing_jacobian(lines, intersections(*lines))[:, 1]))

    assert reach(np.radians(90)) == pytest.approx(1.0)
    assert reach(np.radians(30)) == pytest.approx(2.0)
