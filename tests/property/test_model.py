import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from echoplan.arrays import FloatArray, IntArray, checked_covariance, checked_floats, checked_integers
from echoplan.errors import InvalidValueError
from echoplan.geometry import compose, directions, transform_points
from echoplan.model import Pings, Polyline, Rig, Sensor, Servo, Sweep

PINGS = 6
metres = st.floats(-20, 20)
angles = st.floats(-7, 7)
matrices = arrays(np.float64, (3, 3), elements=st.floats(-1, 1))


def poses(count: int) -> st.SearchStrategy[FloatArray]:
    rows = st.tuples(metres, metres, angles)
    return st.lists(rows, min_size=count, max_size=count).map(np.array)


@st.composite
def rigs(draw: st.DrawFn) -> Rig:
    """Up to four sensors anywhere on a turret anywhere."""
    ids = draw(st.lists(st.integers(0, 99), min_size=1, max_size=4, unique=True))
    sensors = tuple(
        Sensor(
            sensor_id=sensor_id,
            x=draw(st.floats(-0.2, 0.2)),
            y=draw(st.floats(-0.2, 0.2)),
            yaw=draw(angles),
            half_aperture=0.5,
            min_range=0.02,
            max_range=4.0,
            resolution=0.003,
        )
        for sensor_id in ids
    )
    return Rig(name="drawn", sensors=sensors, base_from_turret=draw(poses(1))[0])


@st.composite
def recorded(draw: st.DrawFn) -> tuple[Rig, Sweep]:
    """A rig and a sweep of it."""
    rig = draw(rigs())
    known = st.sampled_from(rig.sensor_ids.tolist())
    sweep = Sweep(
        index=0,
        stamps_ns=np.arange(PINGS),
        sensor_ids=np.array(draw(st.lists(known, min_size=PINGS, max_size=PINGS))),
        servo_angles=draw(arrays(np.float64, PINGS, elements=angles)),
        ranges=np.linspace(0.1, 2.0, PINGS),
        map_from_base=draw(poses(PINGS)),
    )
    return rig, sweep


def moved(sweep: Sweep, pose: FloatArray) -> Sweep:
    return Sweep(
        index=sweep.index,
        stamps_ns=sweep.stamps_ns,
        sensor_ids=sweep.sensor_ids,
        servo_angles=sweep.servo_angles,
        ranges=sweep.ranges,
        map_from_base=compose(pose, sweep.map_from_base),
    )


@given(recorded(), poses(1))
def test_pings_move_with_the_robot(recording: tuple[Rig, Sweep], pose: FloatArray) -> None:
    rig, sweep = recording
    here, there = Pings.from_sweep(sweep, rig), Pings.from_sweep(moved(sweep, pose[0]), rig)
    assert there.origins_xy == pytest.approx(transform_points(pose[0], here.origins_xy), abs=1e-9)
    assert there.hubs_xy == pytest.approx(transform_points(pose[0], here.hubs_xy), abs=1e-9)
    assert directions(there.bearings) == pytest.approx(directions(here.bearings + pose[0, 2]), abs=1e-9)


@given(recorded())
def test_the_servo_turns_a_sensor_on_its_arm_and_its_beam_with_it(recording: tuple[Rig, Sweep]) -> None:
    rig, sweep = recording
    pings = Pings.from_sweep(sweep, rig)
    arms = np.array([[sensor.x, sensor.y] for sensor in rig.sensors])[pings.sensors]
    assert np.hypot(*(pings.origins_xy - pings.hubs_xy).T) == pytest.approx(np.hypot(*arms.T), abs=1e-9)
    turns = np.array([sensor.yaw for sensor in rig.sensors])[pings.sensors] + sweep.servo_angles
    turns = turns + rig.base_from_turret[2] + sweep.map_from_base[:, 2]
    assert directions(pings.bearings) == pytest.approx(directions(turns), abs=1e-9)


@given(rigs())
def test_every_sensor_is_found_by_its_id(rig: Rig) -> None:
    assert rig.indices(rig.sensor_ids).tolist() == list(range(len(rig.sensors)))
    assert rig.indices(rig.sensor_ids[::-1]).tolist() == list(range(len(rig.sensors)))[::-1]


@given(st.floats(-4, 4), st.floats(0.01, 7), st.floats(0.01, 1))
def test_a_servo_takes_even_steps_and_stops_within_one_of_its_end(start: float, way: float, step: float) -> None:
    servo = Servo(start=start, stop=start + way, step=step)
    assert servo.angles[0] == start
    assert np.diff(servo.angles) == pytest.approx(np.full(len(servo.angles) - 1, step))
    assert servo.stop - step - 1e-6 < servo.angles[-1] <= servo.stop + 1e-5


@given(arrays(np.float64, (5, 2), elements=metres))
def test_a_closed_polyline_comes_back_to_its_start_and_an_open_one_lacks_the_last_face(points: FloatArray) -> None:
    assume((np.abs(points - np.roll(points, 1, axis=0)).max(axis=1) > 1e-3).all())
    closed, opened = (Polyline(points_xy=points, closed=each).segments_xy for each in (True, False))
    assert np.array_equal(closed[:, 1], np.roll(closed[:, 0], -1, axis=0))
    assert np.array_equal(opened, closed[:-1])


@given(arrays(np.int64, st.integers(0, 9)))
def test_integers_pass_unchanged(values: IntArray) -> None:
    assert np.array_equal(checked_integers(values, name="values", shape=(None,)), values)


@given(arrays(np.float64, (4, 2), elements=st.floats(allow_nan=True, allow_infinity=True)))
def test_floats_pass_unchanged_or_are_refused_as_not_finite(values: FloatArray) -> None:
    if np.isfinite(values).all():
        assert np.array_equal(checked_floats(values, name="values", shape=(None, 2)), values)
    else:
        with pytest.raises(InvalidValueError, match=r"values must be finite, not -?(inf|nan)"):
            checked_floats(values, name="values", shape=(None, 2))
    kept = checked_floats(values, name="values", shape=(4, 2), finite=False)
    assert np.array_equal(kept, values, equal_nan=True)


@given(matrices, st.sampled_from([1e-9, 1.0, 1e6]))
def test_every_square_of_a_matrix_is_a_covariance_at_any_scale(root: FloatArray, scale: float) -> None:
    covariance = scale * (root @ root.T)
    assert np.array_equal(checked_covariance(covariance, name="covariance", size=3), covariance)


@given(matrices, st.sampled_from([1e-9, 1.0, 1e6]))
def test_a_matrix_that_would_shrink_a_variance_below_nothing_is_refused(root: FloatArray, scale: float) -> None:
    square = root @ root.T
    shifted = scale * (square - (np.linalg.eigvalsh(square)[0] + 0.1) * np.eye(3))
    with pytest.raises(InvalidValueError, match="covariance must have no negative eigenvalue"):
        checked_covariance(shifted, name="covariance", size=3)
