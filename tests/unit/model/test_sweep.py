import re
from typing import Any

import numpy as np
import pytest

from echoplan.errors import InvalidValueError, UnknownNameError
from echoplan.model import Pings, Recording, Rig, Sensor, Sweep

SENSOR = Sensor(sensor_id=4, x=0.05, half_aperture=0.6, min_range=0.03, max_range=3.0, resolution=0.005)
RIG = Rig(name="one", sensors=(SENSOR,), base_from_turret=np.array([0.1, 0.0, 0.0]))
SWEEP: dict[str, Any] = {
    "index": 2,
    "stamps_ns": [10, 20, 20],
    "sensor_ids": [4, 4, 4],
    "servo_angles": [0.0, np.pi / 2, np.pi],
    "ranges": [1.5, np.inf, -np.inf],
    "map_from_base": [[1.0, 2.0, 0.0], [1.0, 2.0, np.pi / 2], [3.0, 2.0, 0.0]],
}


def test_pings_lie_in_the_map_where_robot_turret_and_servo_put_them() -> None:
    pings = Pings.from_sweep(Sweep(**SWEEP), RIG)
    assert pings.hubs_xy == pytest.approx(np.array([[1.1, 2.0], [1.0, 2.1], [3.1, 2.0]]))
    assert pings.origins_xy == pytest.approx(np.array([[1.15, 2.0], [0.95, 2.1], [3.05, 2.0]]))
    assert np.cos(pings.bearings) == pytest.approx([1.0, -1.0, -1.0])
    assert np.array_equal(pings.ranges, SWEEP["ranges"])
    assert pings.sensors.tolist() == [0, 0, 0]


def test_a_sweep_of_another_rig_is_refused() -> None:
    with pytest.raises(UnknownNameError, match=re.escape("unknown sensor id '9'; known: 4")):
        Pings.from_sweep(Sweep(**{**SWEEP, "sensor_ids": [4, 9, 4]}), RIG)


@pytest.mark.parametrize("chosen", [np.array([True, False, True]), np.array([0, 2]), slice(None, None, 2)])
def test_pings_can_be_chosen_by_mask_index_or_slice(chosen: Any) -> None:
    pings = Pings.from_sweep(Sweep(**SWEEP), RIG)
    some = pings[chosen]
    assert len(some) == 2
    for name in ("origins_xy", "hubs_xy", "bearings", "ranges", "sensors"):
        assert np.array_equal(getattr(some, name), getattr(pings, name)[[0, 2]])


def test_the_station_of_a_sweep_is_where_the_robot_was_halfway() -> None:
    assert Sweep(**SWEEP).station.tolist() == SWEEP["map_from_base"][1]


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"index": -1}, "index must be at least 0, not -1"),
        ({"stamps_ns": [10, 30, 20]}, "stamps_ns must not go back; sweep 2 does"),
        ({"sensor_ids": [4, 4]}, "sensor_ids must have shape (3), not (2,)"),
        ({"servo_angles": [0.0, np.nan, 0.0]}, "servo_angles must be finite, not nan"),
        ({"ranges": [1.0, -0.25, np.nan]}, "ranges must not be negative, not -0.25"),
        ({"temperature": 293.15}, "temperature must be at most 60, not 293.15"),
        ({"temperature": -np.inf}, "temperature must be finite, not -inf"),
        ({"map_from_base": np.zeros((3, 2))}, "map_from_base must have shape (3, 3), not (3, 2)"),
    ],
)
def test_a_sweep_that_cannot_be_is_refused(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidValueError, match=f"^{re.escape(message)}$"):
        Sweep(**{**SWEEP, **wrong})


def test_a_range_of_zero_is_valid() -> None:
    assert Sweep(**{**SWEEP, "ranges": [0.0, 0.5, np.nan]}).ranges[0] == 0.0


def test_a_recording_gives_its_sweeps_again_and_again() -> None:
    sweeps = (Sweep(**SWEEP), Sweep(**{**SWEEP, "index": 3}))
    recording = Recording(name="attic", rig=RIG, sweeps=sweeps)
    assert len(recording) == 2
    assert [sweep.index for sweep in recording] == [sweep.index for sweep in recording] == [2, 3]
