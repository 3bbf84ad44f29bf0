import re
from typing import Any

import numpy as np
import pytest

from echoplan.errors import InvalidValueError
from echoplan.model import Pillar, Polyline, Route, Truth, World

# A right-angled triangle.
POINTS: Any = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0]]


def test_an_open_polyline_has_a_face_between_neighbours() -> None:
    segments = Polyline(points_xy=POINTS).segments_xy
    assert segments.tolist() == [[[0, 0], [4, 0]], [[4, 0], [4, 3]]]


def test_a_closed_polyline_has_a_face_back_to_its_start() -> None:
    segments = Polyline(points_xy=POINTS, closed=True).segments_xy
    assert segments.tolist() == [[[0, 0], [4, 0]], [[4, 0], [4, 3]], [[4, 3], [0, 0]]]


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"points_xy": POINTS[:1]}, "points must be at least 2, not 1"),
        ({"points_xy": POINTS[:2], "closed": True}, "points must be at least 3, not 2"),
        (
            {"points_xy": [*POINTS, [4.0, 3.0]]},
            "points must differ from their neighbours; [4.0, 3.0] occurs twice",
        ),
        (
            {"points_xy": [*POINTS, [0.0, 0.0]], "closed": True},
            "points must differ from their neighbours; [0.0, 0.0] occurs twice",
        ),
    ],
)
def test_a_polyline_that_cannot_be_is_refused(fields: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidValueError, match=f"^{re.escape(message)}$"):
        Polyline(**fields)


def test_a_pillar_has_a_girth() -> None:
    with pytest.raises(InvalidValueError, match="radius must be greater than 0, not 0"):
        Pillar(center_xy=np.zeros(2), radius=0.0)


def test_a_world_gathers_its_faces_and_its_pillars() -> None:
    board = Polyline(points_xy=np.array([[1.0, 1.0], [2.0, 1.5]]))
    pillar = Pillar(center_xy=np.array([3.0, 1.0]), radius=0.2)
    world = World(name="room", polylines=(Polyline(points_xy=POINTS, closed=True), board), pillars=(pillar,))
    assert world.segments_xy.shape == (4, 2, 2)
    assert world.segments_xy[3].tolist() == [[1.0, 1.0], [2.0, 1.5]]
    assert world.discs.tolist() == [[3.0, 1.0, 0.2]]


def test_an_empty_world_has_arrays_of_nothing() -> None:
    world = World(name="plain", polylines=())
    assert world.segments_xy.shape == (0, 2, 2)
    assert world.discs.shape == (0, 3)


def test_a_route_may_have_times_or_none() -> None:
    poses = np.array([[0.0, 1.0, 0.5], [2.0, 1.0, 0.5]])
    assert Route(map_from_base=poses).stamps_ns is None
    stamps = Route(map_from_base=poses, stamps_ns=[0, 5]).stamps_ns  # type: ignore[arg-type]
    assert stamps is not None
    assert stamps.tolist() == [0, 5]


@pytest.mark.parametrize(
    ("poses", "stamps", "message"),
    [
        (np.zeros((0, 3)), None, "a route must have at least one pose"),
        (np.zeros((2, 3)), [5, 5], "the times of a route must increase"),
        (np.zeros((2, 3)), [5], "stamps_ns must have shape (2), not (1,)"),
    ],
)
def test_a_route_that_cannot_be_is_refused(poses: Any, stamps: Any, message: str) -> None:
    with pytest.raises(InvalidValueError, match=f"^{re.escape(message)}$"):
        Route(map_from_base=poses, stamps_ns=stamps)


def test_a_truth_may_have_the_true_poses_without_those_recorded() -> None:
    truth = Truth(walls_xy=np.zeros((0, 2, 2)), walls_detected_by=np.zeros(0, dtype=int), poses=np.ones((2, 3)))
    assert truth.poses.shape == (2, 3)
    assert truth.given.shape == (0, 3)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"walls_detected_by": [1, 2]}, "walls_heard must have shape (1), not (2,)"),
        ({"cylinders": [[1, 2, 0.1]]}, "cylinders_heard must have shape (1), not (0,)"),
        ({"poses": np.zeros((2, 3)), "given": np.zeros((1, 3))}, "given must have shape (2, 3), not (1, 3)"),
    ],
)
def test_a_truth_whose_lists_do_not_go_together_is_refused(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidValueError, match=f"^{re.escape(message)}$"):
        Truth(**{"walls_xy": [[[0, 0], [4, 0]]], "walls_detected_by": [3], **wrong})
