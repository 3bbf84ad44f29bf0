import re
from typing import Any

import numpy as np
import pytest

from echoplan.errors import InvalidValueError
from echoplan.model import (
    ClassProbabilities,
    Corner,
    CornerKind,
    Cylinder,
    FeatureMap,
    Opening,
    UnobservedStretch,
    Wall,
)

# The line 3x + 4y = 10.
WALL: dict[str, Any] = {
    "normal_angle": np.arctan2(4.0, 3.0),
    "offset": 2.0,
    "endpoints_xy": [[0.4, 2.2], [-2.0, 4.0]],
    "covariance": np.diag([1e-4, 4e-6]),
}
CORNER: dict[str, Any] = {"position_xy": [2.0, 1.0], "kind": "convex", "covariance": np.eye(2)}
CYLINDER: dict[str, Any] = {"center_xy": [3.2, 1.0], "radius": 0.1, "covariance": np.eye(3)}
GAP: dict[str, Any] = {"endpoints_xy": [[1.0, 0.0], [1.8, 0.0]], "walls": ()}
OPENING: dict[str, Any] = {**GAP, "width_sigma": 0.01}


def test_a_wall_has_a_length_and_a_normal() -> None:
    wall = Wall(**WALL)
    assert wall.length == pytest.approx(3.0)
    assert wall.normal_xy == pytest.approx([0.6, 0.8])
    assert wall.endpoints_xy @ wall.normal_xy == pytest.approx([2.0, 2.0])


def test_a_feature_is_sure_of_its_own_class_by_default() -> None:
    assert Wall(**WALL).class_probabilities == ClassProbabilities(wall=1.0)
    assert Corner(**CORNER).class_probabilities == ClassProbabilities(corner=1.0)
    assert Cylinder(**CYLINDER).class_probabilities == ClassProbabilities(cylinder=1.0)


def test_a_corner_takes_its_kind_by_name() -> None:
    assert Corner(**CORNER).kind is CornerKind.CONVEX


@pytest.mark.parametrize(
    ("probabilities", "message"),
    [
        ({"wall": 0.5, "corner": 0.4}, "class probabilities must sum to 1, not 0.9"),
        ({"wall": 1.000002}, "wall must be at most 1, not 1.000002"),
        ({"wall": 0.5, "corner": 0.500002}, "class probabilities must sum to 1, not 1.000002"),
        ({"wall": 1.5, "corner": -0.5}, "wall must be at most 1, not 1.5"),
        ({"corner": -0.5, "cylinder": 1.0}, "corner must be at least 0, not -0.5"),
    ],
)
def test_invalid_probabilities_are_refused(probabilities: dict[str, float], message: str) -> None:
    with pytest.raises(InvalidValueError, match=f"^{re.escape(message)}$"):
        ClassProbabilities(**probabilities)


@pytest.mark.parametrize(
    ("kind", "fields", "wrong", "message"),
    [
        (Wall, WALL, {"normal_angle": np.nan}, "normal_angle must be finite, not nan"),
        (Wall, WALL, {"offset": np.inf}, "offset must be finite, not inf"),
        (Wall, WALL, {"endpoints_xy": [[1, 2], [1, 2]]}, "the ends of a wall must differ, both are [1.0, 2.0]"),
        (Wall, WALL, {"endpoints_xy": [1, 2, 3, 4]}, "endpoints_xy must have shape (2, 2), not (4,)"),
        (Wall, WALL, {"endpoint_sigmas": [np.nan, np.inf]}, "endpoint_sigmas must be neither negative nor infinite"),
        (Wall, WALL, {"endpoint_sigmas": [-0.1, np.nan]}, "endpoint_sigmas must be neither negative nor infinite"),
        (Opening, OPENING, {"endpoints_xy": np.ones((2, 2))}, "the ends of an opening must differ"),
        (UnobservedStretch, GAP, {"endpoints_xy": np.ones((2, 2))}, "the ends of an unobserved stretch must differ"),
        (Wall, WALL, {"covariance": np.eye(3)}, "covariance must have shape (2, 2), not (3, 3)"),
        (Corner, CORNER, {"position_xy": [1, np.nan]}, "position_xy must be finite, not nan"),
        (Corner, CORNER, {"covariance": -np.eye(2)}, "covariance must have no negative eigenvalue, not "),
        (Cylinder, CYLINDER, {"radius": -0.1}, "radius must be at least 0, not -0.1"),
        (Cylinder, CYLINDER, {"center_xy": [1, 2, 3]}, "center_xy must have shape (2), not (3,)"),
        (Cylinder, CYLINDER, {"covariance": np.eye(2)}, "covariance must have shape (3, 3), not (2, 2)"),
    ],
)
def test_a_feature_that_cannot_be_is_refused(
    kind: Any, fields: dict[str, Any], wrong: dict[str, Any], message: str
) -> None:
    with pytest.raises(InvalidValueError, match=f"^{re.escape(message)}"):
        kind(**{**fields, **wrong})


def test_a_map_has_one_pose_for_each_sweep() -> None:
    with pytest.raises(InvalidValueError, match=re.escape("poses must have shape (2, 3), not (1, 3)")):
        FeatureMap(method="rcd", sweeps=[0, 1], poses=[[0.0, 0.0, 0.0]])  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("covariances", "message"),
    [
        (np.zeros((1, 3, 3)), "pose_covariances must have shape (2, 3, 3), not (1, 3, 3)"),
        (np.stack([np.eye(3), -np.eye(3)]), "pose_covariances[1] must have no negative eigenvalue"),
    ],
)
def test_all_poses_have_covariances_or_none(covariances: Any, message: str) -> None:
    with pytest.raises(InvalidValueError, match=re.escape(message)):
        FeatureMap(method="joint", sweeps=np.arange(2), poses=np.zeros((2, 3)), pose_covariances=covariances)


def test_an_empty_map_has_nothing_in_the_map_frame() -> None:
    empty = FeatureMap(method="rcd")
    assert (empty.walls, empty.corners, empty.cylinders) == ((), (), ())
    assert empty.poses.shape == (0, 3)
    assert empty.frame == "map"
