import re
from typing import Any

import numpy as np
import pytest

from echoplan.errors import InvalidValueError, UnknownNameError
from echoplan.model import Firing, Rig, Sensor, Servo


def sensor(sensor_id: int, *, x: float = 0.0, y: float = 0.0, yaw: float = 0.0) -> Sensor:
    return Sensor(
        sensor_id=sensor_id, x=x, y=y, yaw=yaw, half_aperture=0.6, min_range=0.03, max_range=3.0, resolution=0.005
    )


# One sensor ahead of the axis, one to its left that looks left; ids out of order on purpose.
AHEAD, LEFT = sensor(7, x=0.05), sensor(3, y=0.08, yaw=np.pi / 2)
TURRET = (0.1, -0.2, 0.0)


def rig(**fields: Any) -> Rig:
    return Rig(**{"name": "pair", "sensors": (AHEAD, LEFT), "base_from_turret": TURRET, **fields})


def test_sensors_are_found_by_their_ids_in_any_order() -> None:
    assert rig().indices([3, 7, 7, 3]).tolist() == [1, 0, 0, 1]
    assert rig().indices([]).tolist() == []


@pytest.mark.parametrize("strange", [0, 5, 99])
def test_an_unknown_sensor_id_is_refused_with_the_known_ones(strange: int) -> None:
    with pytest.raises(UnknownNameError, match=f"^unknown sensor id '{strange}'; known: 3, 7$"):
        rig().indices([7, strange])


def test_the_servo_turns_the_sensors_about_its_axis() -> None:
    placed = rig().base_from_sensors([7, 3, 3], [0.0, 0.0, np.pi / 2])
    assert placed == pytest.approx(np.array([[0.15, -0.2, 0.0], [0.1, -0.12, np.pi / 2], [0.02, -0.2, -np.pi]]))


def test_the_turret_may_itself_be_turned() -> None:
    placed = rig(base_from_turret=(0.1, -0.2, np.pi / 2)).base_from_sensors([7], [0.0])
    assert placed == pytest.approx(np.array([[0.1, -0.15, np.pi / 2]]))


def test_columns_of_sensor_values_follow_the_order_of_the_sensors() -> None:
    assert rig().sensor_ids.tolist() == [7, 3]
    assert rig().turret_from_sensors == pytest.approx(np.array([[0.05, 0, 0], [0, 0.08, np.pi / 2]]))
    assert rig().min_ranges.tolist() == [0.03, 0.03]
    assert rig().max_ranges.tolist() == [3.0, 3.0]


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"sensors": ()}, "a rig must have at least one sensor"),
        ({"sensors": (AHEAD, LEFT, AHEAD)}, "sensor id 7 occurs 2 times; every sensor needs its own"),
        (
            {"firing": Firing(period=0.06, groups=((7,), (4, 3)))},
            "groups name sensor 4, but the sensors are [3, 7]",
        ),
        ({"base_from_turret": (0.0, 0.0)}, "turret must have shape (3), not (2,)"),
    ],
)
def test_a_rig_that_cannot_be_is_refused(fields: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidValueError, match=f"^{re.escape(message)}$"):
        rig(**fields)


@pytest.mark.parametrize("groups", [(), ((1,), ())])
def test_a_firing_group_without_sensors_is_refused(groups: tuple[tuple[int, ...], ...]) -> None:
    with pytest.raises(InvalidValueError, match="groups must name the sensors fired together, not "):
        Firing(period=0.06, groups=groups)


def test_a_firing_period_must_pass() -> None:
    with pytest.raises(InvalidValueError, match="period must be greater than 0, not 0"):
        Firing(period=0.0, groups=((0,),))


def test_a_servo_steps_from_its_start_to_its_stop() -> None:
    degree = np.radians(1.0)
    angles = Servo(start=-90 * degree, stop=90 * degree, step=degree).angles
    assert len(angles) == 181
    assert np.degrees(angles[[0, 1, -1]]) == pytest.approx([-90.0, -89.0, 90.0])


def test_a_servo_whose_step_does_not_divide_its_way_ends_short_of_the_stop() -> None:
    assert Servo(start=0.0, stop=1.0, step=0.3).angles == pytest.approx([0.0, 0.3, 0.6, 0.9])


@pytest.mark.parametrize(
    ("stop", "step", "message"),
    [
        (0.5, 0.1, "stop must be greater than 0.5, not 0.5"),
        (1.0, 0.0, "step must be greater than 0, not 0"),
    ],
)
def test_a_servo_that_does_not_turn_is_refused(stop: float, step: float, message: str) -> None:
    with pytest.raises(InvalidValueError, match=f"^{re.escape(message)}$"):
        Servo(start=0.5, stop=stop, step=step)
