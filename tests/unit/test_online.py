"""Mapping while a robot drives: nothing waits, nothing is lost, and the map is that of all sweeps."""

import os
import signal
import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

import echoplan as ep
from echoplan.errors import EchoplanError, InvalidValueError, UnknownNameError
from echoplan.geometry import compose
from echoplan.joint.mapper import JointMapper, JointSettings
from echoplan.joint.settings import PoseMode
from echoplan.methods import map_sweeps
from echoplan.online import OnlineMapper
from echoplan.simulation import OdometryNoise, SimulationSettings


@pytest.fixture(scope="module")
def room() -> ep.Simulation:
    """A square room."""
    return ep.simulate("square", seed=1)


@pytest.fixture
def mapper(room: ep.Simulation) -> Iterator[OnlineMapper]:
    """A mapper that is closed afterwards."""
    with OnlineMapper(room.rig) as made:
        yield made


def test_the_map_is_that_of_all_sweeps_at_once(room: ep.Simulation, mapper: OnlineMapper) -> None:
    for sweep in room:
        mapper.add(sweep)
    found, expected = mapper.finish(), map_sweeps(JointMapper(room.rig), tuple(room))
    assert mapper.behind == 0
    for one, other in zip(found.walls, expected.walls, strict=True):
        assert one.endpoints_xy == pytest.approx(other.endpoints_xy, abs=1e-9)
    assert found.sweeps.tolist() == expected.sweeps.tolist()


def test_nothing_waits_for_the_map(room: ep.Simulation, mapper: OnlineMapper) -> None:
    begun = time.perf_counter()
    for sweep in room:
        mapper.add(sweep)
        mapper.result()
    # The process needs longer to import NumPy.
    assert time.perf_counter() - begun < 0.5
    assert mapper.behind > 0
    assert mapper.finish().walls


def test_the_frame_of_odometry_is_where_the_map_puts_it() -> None:
    settings = SimulationSettings(odometry=OdometryNoise(along=0.02, yaw_per_metre=0.03))
    drifting = ep.simulate("square", seed=1, settings=settings)
    sweeps = tuple(drifting)
    with OnlineMapper(drifting.rig, JointSettings(poses=PoseMode.CORRECT)) as mapper:
        assert mapper.map_from_odom.tolist() == [0.0, 0.0, 0.0]
        for sweep in sweeps:
            mapper.add(sweep)
        found = mapper.finish()
        here = compose(mapper.map_from_odom, sweeps[-1].station)
    assert here == pytest.approx(found.poses[-1])
    assert np.abs(mapper.map_from_odom).max() > 1e-3


def test_before_the_first_map_there_is_an_empty_one(mapper: OnlineMapper) -> None:
    assert mapper.result().is_empty
    assert mapper.behind == 0
    assert mapper.finish().is_empty


def test_sweeps_without_pings_say_nothing(room: ep.Simulation, mapper: OnlineMapper) -> None:
    columns = ("stamps_ns", "sensor_ids", "servo_angles", "ranges", "map_from_base")
    first = next(iter(room))
    mapper.add(replace(first, **{name: getattr(first, name)[:0] for name in columns}))
    assert mapper.behind == 0


def test_a_sweep_that_does_not_follow_is_refused_at_once(room: ep.Simulation, mapper: OnlineMapper) -> None:
    first, second, *_ = room
    mapper.add(second)
    with pytest.raises(InvalidValueError, match="the index of a sweep must increase"):
        mapper.add(first)
    assert mapper.finish().sweeps.tolist() == [second.index]


def test_a_sweep_of_another_rig_is_refused_at_once(mapper: OnlineMapper) -> None:
    with pytest.raises(UnknownNameError):
        mapper.add(next(iter(ep.simulate("square", rig="ring-16"))))


def test_waiting_ends_after_the_time_that_is_given(room: ep.Simulation, mapper: OnlineMapper) -> None:
    for sweep in room:
        mapper.add(sweep)
    with pytest.raises(TimeoutError, match="5 sweeps are not mapped after"):
        mapper.finish(timeout=0.01)


def test_a_process_that_was_killed_is_named(room: ep.Simulation, mapper: OnlineMapper) -> None:
    first, second, *_ = room
    mapper.add(first)
    mapper.finish(timeout=60.0)
    (child,) = mapper._process._processes
    os.kill(child, signal.SIGKILL)
    with pytest.raises(EchoplanError, match="the process that maps was ended from outside"):
        add_and_finish(mapper, second)
    # And so it remains.
    with pytest.raises(EchoplanError, match="the process that maps was ended from outside"):
        mapper.finish(timeout=60.0)


def add_and_finish(mapper: OnlineMapper, sweep: ep.Sweep) -> None:
    """Whichever notices first that the process is gone says so."""
    mapper.add(sweep)
    mapper.finish(timeout=60.0)


def test_a_closed_mapper_says_so(room: ep.Simulation) -> None:
    mapper = OnlineMapper(room.rig)
    for sweep in room:
        mapper.add(sweep)
    mapper.close()
    for call in (mapper.finish, mapper.result, lambda: mapper.add(next(iter(room)))):
        with pytest.raises(EchoplanError, match="the mapper is closed"):
            call()


def test_settings_of_another_type_are_refused_at_once(room: ep.Simulation) -> None:
    with pytest.raises(InvalidValueError, match="the settings must be JointSettings, not dict"):
        OnlineMapper(room.rig, {"poses": "trust"})  # type: ignore[arg-type]
