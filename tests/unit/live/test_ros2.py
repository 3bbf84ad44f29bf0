"""A running ROS 2 as a feed: it waits for the robot, follows it, and says what is missing."""

import time
from collections.abc import Iterable, Iterator
from threading import Thread, Timer
from typing import Any

import numpy as np
import pytest

from echoplan.errors import InputError, UnknownNameError
from echoplan.grids import grid_from_map
from echoplan.io.ros import BagOptions, parse_bag_options
from echoplan.io.ros.series import Row, as_contents
from echoplan.io.ros.wire import parse_address, stream
from echoplan.live import Complete, Control, Event, Notice, Ros2Feed
from echoplan.live.mapping import MapUpdate
from echoplan.model import FeatureMap
from helpers.bags import JAZZY, NOON_NS, Robot, Sent, drive, recorded_by, ring
from helpers.maps import wall
from helpers.wires import FakeTransport

ROBOT = Robot(JAZZY)
SECOND = 1_000_000_000


def driven(*, start_ns: int = NOON_NS) -> list[Sent]:
    """Forty rounds of three sensors in four seconds."""
    return list(drive(recorded_by(ring(3), rounds=40), ROBOT, start_ns=start_ns))


def joined(transport: FakeTransport, *, wait: int = 5, options: BagOptions | None = None, **others: Any) -> Ros2Feed:
    """A feed of a network whose messages come as soon as somebody has subscribed."""
    Timer(0.1, transport.send, [transport.sent]).start()
    address = parse_address(f"ros2://?wait={wait}", environment={})
    return Ros2Feed(address, options=options, connect=lambda _: transport, **others)


def until(events: Iterator[Event], kind: type) -> Any:
    return next(event for event in events if isinstance(event, kind))


def test_sweeps_come_from_messages_and_other_programs_drive() -> None:
    feed = joined(FakeTransport(driven()))
    events = feed.events()
    assert len(until(events, Complete).sweep) == 3
    assert len(feed.rig.sensors) == 3
    assert feed.controls == frozenset[Control]()
    feed.close()


def test_each_message_is_decoded_once_while_it_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    taken = list[Row]()

    def noted(rows: Iterable[Row]) -> Any:
        new = list(rows)
        taken.extend(new)
        return as_contents(new)

    monkeypatch.setattr(stream, "as_contents", noted)
    joined(FakeTransport(driven())).close()
    assert len(taken) == len({id(row) for row in taken}) > 0


def test_a_network_that_takes_no_map_is_left() -> None:
    class Refusing(FakeTransport):
        def advertise(self, name: str, kind: str, *, is_latched: bool) -> Any:
            raise InputError("ROS 2", f"{name} cannot be published", remedy="start again")

    transport = Refusing(driven())
    with pytest.raises(InputError, match="/map cannot be published"):
        joined(transport)
    assert transport.is_closed


def test_what_is_missing_is_said_while_it_waits_and_at_the_end() -> None:
    lines = list[str]()
    transport = FakeTransport([each for each in driven() if each.topic != "/tf_static"])
    with pytest.raises(InputError) as refused:
        joined(transport, report=lines.append)
    assert "/sonar_0: there is no transform from base_link to sonar_0; seen: /odom (nav_msgs" in str(refused.value)
    assert len(lines) == 1
    assert lines[0].startswith("Waiting for up to 5 s: ros2://?wait=5: /sonar_0: there is no transform")
    assert transport.is_closed


def test_mountings_may_be_stated_where_there_are_no_transforms() -> None:
    options = parse_bag_options(mounts=[f"sonar_{number}=0.1,0,{number}" for number in range(3)])
    feed = joined(FakeTransport([each for each in driven() if each.topic != "/tf_static"]), options=options)
    assert [round(sensor.yaw, 6) for sensor in feed.rig.sensors] == [0.0, 1.0, 2.0]
    feed.close()


def test_topics_without_messages_and_networks_without_topics_are_told_apart() -> None:
    quiet, empty = FakeTransport(driven()), FakeTransport([])
    quiet.send = lambda messages: None  # type: ignore[method-assign]
    with pytest.raises(InputError, match="no message yet on /odom, /sonar_0, /sonar_1, /sonar_2, /tf_static; seen: "):
        joined(quiet, wait=0)
    with pytest.raises(InputError, match="no topics were found in domain 0; start the robot"):
        joined(empty, wait=0)


def test_a_topic_that_the_user_names_and_nobody_has_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="unknown topic '/sonra_0'; did you mean '/sonar_0'"):
        joined(FakeTransport(driven()), wait=0, options=BagOptions(topics=("/sonra_0",)))


def test_after_a_jump_of_the_clock_it_says_so_and_goes_on() -> None:
    transport = FakeTransport(driven())
    feed = joined(transport)
    events = feed.events()
    until(events, Complete)
    again = [each for each in driven(start_ns=NOON_NS - 60 * SECOND) if each.topic != "/tf_static"]
    transport.send(again[:3])
    problem = until(events, Notice)
    assert problem.is_problem
    assert "time goes back by" in problem.text
    transport.send(again)
    assert until(events, Complete).sweep.stamps_ns[0] == NOON_NS - 60 * SECOND
    assert until(events, Notice) == Notice(text="Readings come again.")
    feed.close()


def test_after_one_late_stamp_it_waits_until_all_sensors_came_again() -> None:
    transport = FakeTransport(driven())
    feed = joined(transport)
    events = feed.events()
    until(events, Complete)
    late = [each for each in driven(start_ns=NOON_NS - 60 * SECOND) if each.topic == "/sonar_0"]
    transport.send(late[:1])
    assert until(events, Notice).is_problem
    # Messages come so slowly that most batches lack a sensor.
    later = [each for each in driven(start_ns=NOON_NS + 60 * SECOND) if each.topic != "/tf_static"]

    def send_slowly() -> None:
        for each in later[:8]:
            transport.send([each])
            time.sleep(0.3)
        transport.send(later[8:])

    Thread(target=send_slowly).start()
    assert until(events, Notice) == Notice(text="Readings come again.")
    feed.close()


def test_silence_ends_the_current_sweep_and_is_told() -> None:
    feed = joined(FakeTransport(driven()))
    count, events = 0, feed.events()
    for event in events:
        count += isinstance(event, Complete)
        if isinstance(event, Notice):
            break
    assert count == 40
    assert event == Notice(text="No readings come.", is_problem=True)
    feed.close()


def test_odometry_is_placed_where_the_map_has_the_robot() -> None:
    transport = FakeTransport(driven())
    feed = joined(transport)
    sweep = until(feed.events(), Complete).sweep
    house = FeatureMap(method="joint", walls=(wall([0.0, 0.0], [2.0, 0.0]),))
    shifted = sweep.station + np.array([0.5, -0.25, 0.0])
    last_ns = int(sweep.stamps_ns[-1])
    feed.publish(MapUpdate(feature_map=house, grid=grid_from_map(house), last_ns=last_ns, map_from_base=shifted))
    count, patience = len(transport.published["/tf"]), time.monotonic() + 10.0
    while len(transport.published["/tf"]) < count + 2:
        assert time.monotonic() < patience
    feed.close()
    (last,) = transport.published["/tf"][-1].transforms
    np.testing.assert_allclose([last.transform.translation.x, last.transform.translation.y], [0.5, -0.25], atol=1e-9)


def test_a_robot_that_is_localised_already_gets_no_second_transform_and_its_user_is_told() -> None:
    placed = [ROBOT.transform("map", "odom", (1.0, 0.0, 0.0), stamp_ns=NOON_NS + each * SECOND) for each in range(5)]
    amcl = [Sent("/tf", NOON_NS + each * SECOND, message) for each, message in enumerate(placed)]
    sent = sorted([*driven(), *amcl], key=lambda each: each.log_ns)
    transport = FakeTransport(sent)
    feed = joined(transport)
    assert feed.notes[-1] == "The transform from map to odom comes from another program; echoplan publishes none."
    feed.close()
    assert not transport.published["/tf"]
