"""How landmarks look, from where they stand and the other way round."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from echoplan.arrays import FloatArray
from echoplan.classical.slam import CIRCLE, LINE, Shape
from echoplan.extraction import LocatedPoint
from echoplan.geometry import wrap

HUB = np.array([0.1, -0.04])
VALUES = {"line": np.array([0.7, 2.5]), "circle": np.array([2.0, 1.5, 0.1])}
SHAPES = pytest.mark.parametrize("shape", [LINE, CIRCLE], ids=lambda shape: shape.name)

poses = st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(-7, 7)).map(np.array)


def slopes(shape: Shape, pose: FloatArray, values: FloatArray, *, step: float = 1e-6) -> FloatArray:
    """Derivatives of bearing and distance by pose and landmark, by central differences."""
    both = np.concatenate([pose, values])
    columns = []
    for shift in step * np.eye(len(both)):
        low, high = (shape.expect((both + sign * shift)[:3], (both + sign * shift)[3:], HUB).values for sign in (-1, 1))
        columns.append([float(wrap(high[0] - low[0])), high[1] - low[1]])
    return np.array(columns).T / (2 * step)


@SHAPES
@given(pose=poses)
def test_derivatives_are_those_of_the_expectation(shape: Shape, pose: FloatArray) -> None:
    values = VALUES[shape.name]
    expected = shape.expect(pose, values, HUB)
    found = np.hstack([expected.by_pose, expected.by_landmark])
    np.testing.assert_allclose(found, slopes(shape, pose, values), atol=1e-6)


@SHAPES
@given(pose=poses, bearing=st.floats(-3, 3), distance=st.floats(0.1, 4))
def test_a_landmark_is_placed_where_it_looks_as_it_was_seen(
    shape: Shape, pose: FloatArray, bearing: float, distance: float
) -> None:
    point = LocatedPoint(hub_xy=HUB, bearing=bearing, distance=distance, covariance=np.eye(2))
    values = shape.place(pose, point, 0.1)
    residual = shape.expect(pose, values, HUB).residual(point)
    np.testing.assert_allclose(residual, 0.0, atol=1e-9)


def test_a_wall_keeps_its_direction_and_a_pillar_does_not_when_one_walks_along() -> None:
    here, there = np.zeros(3), np.array([1.0, 0.0, 0.0])
    wall, pillar = np.array([np.pi / 2, 2.0]), np.array([0.0, 2.1, 0.1])
    np.testing.assert_allclose(LINE.expect(there, wall, HUB).values, LINE.expect(here, wall, HUB).values)
    assert CIRCLE.expect(there, pillar, np.zeros(2)).values == pytest.approx(
        [np.arctan2(2.1, -1), np.hypot(1, 2.1) - 0.1]
    )


def test_a_residual_takes_the_short_way_round() -> None:
    point = LocatedPoint(hub_xy=np.zeros(2), bearing=-3.1, distance=1.0, covariance=np.eye(2))
    residual = LINE.expect(np.zeros(3), np.array([3.1, 1.0]), np.zeros(2)).residual(point)
    assert residual == pytest.approx([2 * np.pi - 6.2, 0.0])
