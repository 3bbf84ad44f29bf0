import numpy as np
import pytest

from echoplan.model import FeatureMap, Sweep
from echoplan.preprocessing import placed_sweeps

DRIVEN = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.5]])


def sweep(index: int) -> Sweep:
    """Three pings of a robot that moves between them; its station is the second pose."""
    return Sweep(
        index=index,
        stamps_ns=np.arange(3),
        sensor_ids=np.zeros(3, dtype=np.int64),
        servo_angles=np.array([-0.5, 0.0, 0.5]),
        ranges=np.ones(3),
        map_from_base=DRIVEN,
    )


def test_a_sweep_moves_as_a_rigid_body_to_its_pose_in_the_map() -> None:
    feature_map = FeatureMap(method="by hand", sweeps=np.array([4]), poses=np.array([[5.0, 5.0, np.pi / 2]]))
    (placed,) = placed_sweeps([sweep(4), sweep(7), sweep(4)[:0]], feature_map)
    turn = np.pi / 2
    assert placed.map_from_base == pytest.approx(np.array([[5, 4, turn], [5, 5, turn], [4, 5, turn + 0.5]]))
    assert placed.servo_angles.tolist() == [-0.5, 0.0, 0.5]


def test_the_servo_turns_as_far_as_the_map_states() -> None:
    found = {"servo_gain": {"value": 1.1}, "servo_offset": {"value": 0.05}}
    feature_map = FeatureMap(method="joint", sweeps=np.array([4]), poses=DRIVEN[1:2], parameters={"found": found})
    (placed,) = placed_sweeps([sweep(4)], feature_map)
    assert placed.servo_angles == pytest.approx(np.array([-0.5, 0.05, 0.6]))
    assert placed.map_from_base == pytest.approx(DRIVEN)
