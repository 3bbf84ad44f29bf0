from dataclasses import replace

import numpy as np
import pytest

from echoplan.classical.grids import chosen_cones, cones_of, join_cones
from echoplan.errors import UnknownNameError
from echoplan.model import Rig, Sweep
from helpers import scenes


def sweep(*readings: float, sensor_ids: tuple[int, ...] = (), yaw: float = 0.0) -> Sweep:
    """Readings of sensors of the four-sensor rig, one after the other, with the turret turned by a tenth."""
    count = len(readings)
    return Sweep(
        index=3,
        stamps_ns=np.arange(count),
        sensor_ids=np.array(sensor_ids or (0,) * count, dtype=np.int64),
        servo_angles=np.full(count, 0.1),
        ranges=np.array(readings),
        map_from_base=np.tile([2.0, -1.0, yaw], (count, 1)),
    )


def wide_rig(half_aperture: float) -> Rig:
    rig = scenes.rig()
    return replace(rig, sensors=tuple(replace(each, half_aperture=half_aperture) for each in rig.sensors))


def test_a_cone_begins_in_the_acoustic_centre_and_looks_along_the_beam() -> None:
    cones = cones_of(sweep(1.0, 1.2, sensor_ids=(0, 1), yaw=0.4), scenes.rig())
    bearings = np.array([0.5, 0.5 + np.pi / 2])
    np.testing.assert_allclose(cones.x, 2.0 + scenes.ARM * np.cos(bearings))
    np.testing.assert_allclose(cones.y, -1.0 + scenes.ARM * np.sin(bearings))
    np.testing.assert_allclose(np.arctan2(cones.uy, cones.ux), bearings)
    np.testing.assert_allclose(np.column_stack([cones.hub_x, cones.hub_y]), [[2.0, -1.0]] * 2)
    assert cones.readings.tolist() == [1.0, 1.2]
    assert set(cones.half_apertures) == {0.61}
    assert (set(cones.blanks), set(cones.reaches)) == ({0.03}, {3.0})


@pytest.mark.parametrize(
    ("reading", "wanted"),
    [
        (np.nan, []),
        (-np.inf, []),
        (0.02, []),
        (0.03, [0.03]),
        (2.99, [2.99]),
        (2.995, [np.inf]),
        (3.0, [np.inf]),
        (9.0, [np.inf]),
        (np.inf, [np.inf]),
    ],
)
def test_a_reading_is_a_range_or_silence_or_says_nothing(reading: float, wanted: list[float]) -> None:
    assert cones_of(sweep(reading), scenes.rig()).readings.tolist() == wanted


def test_no_sensor_detects_anything_behind_itself() -> None:
    assert cones_of(sweep(1.0), wide_rig(3.0)).half_apertures.tolist() == [np.pi / 2]


def test_a_sweep_without_a_ping_has_no_cone() -> None:
    assert all(field.shape == (0,) for field in cones_of(sweep(), scenes.rig()))


def test_a_sensor_that_the_rig_has_not_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="unknown sensor id '7'"):
        cones_of(sweep(1.0, sensor_ids=(7,)), scenes.rig())


def test_cones_are_joined_in_order_and_nothing_joined_is_no_cone() -> None:
    parts = [cones_of(sweep(*readings), scenes.rig()) for readings in ((1.0, 1.1), (), (1.2,))]
    assert join_cones(parts).readings.tolist() == [1.0, 1.1, 1.2]
    assert all(field.shape == (0,) and field.dtype == np.float64 for field in join_cones([]))


def test_chosen_cones_do_not_share_the_memory_of_all() -> None:
    every = cones_of(sweep(1.0, 1.1, 1.2), scenes.rig())
    some = chosen_cones(every, slice(1, None))
    assert some.readings.tolist() == [1.1, 1.2]
    assert not any(np.shares_memory(own, field) for own, field in zip(some, every, strict=True))
    assert chosen_cones(every, every.readings > 1.15).readings.tolist() == [1.2]
    assert chosen_cones(every, np.array([2, 0])).readings.tolist() == [1.2, 1.0]
