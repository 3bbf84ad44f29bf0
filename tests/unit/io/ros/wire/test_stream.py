"""Sweeps from messages that keep coming are those of the bag of the same messages."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from echoplan.errors import InputError
from echoplan.io.ros import read_bag
from echoplan.io.ros.bag import open_bag
from echoplan.io.ros.choice import choose_topics
from echoplan.io.ros.messages import rows_of
from echoplan.io.ros.options import BagOptions
from echoplan.io.ros.series import Row
from echoplan.io.ros.wire import Advance, Listening, Window, advance
from echoplan.model import Recording, Sweep
from echoplan.sources import open_source
from helpers.bags import JAZZY, NOON_NS, Robot, Sent, drive, recorded_by, ring, write_mcap

ROBOT = Robot(JAZZY)
SECOND = 1_000_000_000


def listened(bag: Path) -> tuple[Listening, list[list[Row]]]:
    """What is listened to, and the rows of each message in the order in which they came."""
    options = BagOptions()
    with open_bag(bag) as opened:
        choice = choose_topics(opened.topics, options, path=bag)
        rows = [list(rows_of(message, options)) for message in opened.messages(choice.topics)]
        return Listening(path=bag, options=options, topics=opened.topics, choice=choice), rows


def streamed(listening: Listening, messages: Sequence[list[Row]], *, chunk: int, first: int = 0) -> list[Advance]:
    """Advance by some messages at once, the first time by more; in the end, nothing more comes."""
    window, advances, place = Window(), list[Advance](), 0
    while place < len(messages):
        count = chunk if place else max(first, chunk)
        rows = [row for message in messages[place : place + count] for row in message]
        advances.append(advance(window, rows, listening=listening))
        window, place = advances[-1].window, place + count
    return [*advances, advance(window, [], listening=listening, is_silent=True)]


def sweeps_of(advances: Sequence[Advance]) -> list[Sweep]:
    return [sweep for each in advances for sweep in each.finished]


def assert_same(found: Sequence[Sweep], expected: Recording) -> None:
    assert len(found) == len(expected.sweeps)
    for own, other in zip(found, expected.sweeps, strict=True):
        for name in ("stamps_ns", "sensor_ids", "servo_angles", "ranges", "map_from_base"):
            # Angles over more than a turn are rounded.
            np.testing.assert_allclose(getattr(own, name), getattr(other, name), rtol=0.0, atol=1e-12, err_msg=name)


def spun(*, turns: int, steps: int = 40, period_ns: int = SECOND // 40) -> list[Sent]:
    """A sonar on a turret that turns to and fro while the robot drives; a shot every 25 ms."""
    sent = [Sent("/tf_static", NOON_NS, ROBOT.transform("turret", "sonar", (0.05, 0.0, 0.0)))]
    for shot in range(turns * steps):
        now_ns, phase = NOON_NS + shot * period_ns, shot % (2 * steps)
        angle = -1.0 + 2.0 * (phase if phase < steps else 2 * steps - 1 - phase) / (steps - 1)
        pose = (0.001 * shot, 0.0, 0.0)
        sent += [
            Sent("/tf", now_ns, ROBOT.transform("base_link", "turret", (0.1, 0.0, angle), stamp_ns=now_ns)),
            Sent("/odom", now_ns, ROBOT.odometry(pose, stamp_ns=now_ns)),
            Sent("/sonar", now_ns, ROBOT.sonar(round(1.0 + 0.013 * (shot % 7), 3), stamp_ns=now_ns)),
        ]
    return sent


@pytest.mark.parametrize(("rig", "chunk"), [("ring-16", 1), ("ring-16", 40), ("rotary-array", 150)])
def test_sweeps_and_sensors_are_those_of_the_bag(tmp_path: Path, rig: str, chunk: int) -> None:
    bag = write_mcap(tmp_path / "run.mcap", drive(open_source(f"sim:square,rig={rig},seed=1"), ROBOT))
    expected = read_bag(bag)
    listening, messages = listened(bag)
    advances = streamed(listening, messages, chunk=chunk, first=300)
    assert_same(sweeps_of(advances), expected)
    for own, other in zip(advances[-1].rig.sensors, expected.rig.sensors, strict=True):
        assert own.resolution == other.resolution
        np.testing.assert_allclose([own.x, own.y, own.yaw], [other.x, other.y, other.yaw], atol=1e-12)


def test_a_sweep_is_finished_as_soon_as_the_next_one_has_begun_and_late_messages_must_have_come(tmp_path: Path) -> None:
    bag = write_mcap(tmp_path / "run.mcap", spun(turns=6))
    listening, messages = listened(bag)
    advances = streamed(listening, messages, chunk=3, first=150)
    finished_at = [place for place, each in enumerate(advances) if each.finished]
    assert len(finished_at) == 6
    # A turn lasts 40 shots, each in one step; a quarter of a second later it is finished.
    assert np.diff(finished_at[:-1]).max() <= 41
    assert_same(sweeps_of(advances), read_bag(bag))


def test_old_messages_are_forgotten(tmp_path: Path) -> None:
    bag = write_mcap(tmp_path / "run.mcap", spun(turns=20))
    listening, messages = listened(bag)
    sizes = [sum(map(len, each.window.series.values())) for each in streamed(listening, messages, chunk=30, first=300)]
    assert max(sizes[len(sizes) // 2 :]) <= max(sizes[: len(sizes) // 2]) + 3


def test_a_servo_may_stand_still_for_longer_than_messages_are_kept(tmp_path: Path) -> None:
    bag = write_mcap(tmp_path / "run.mcap", spun(turns=4))
    listening, messages = listened(bag)
    last_shot, begin = messages[-3:], messages[-1][0].stamp_ns
    for shot in range(1, 400):
        later = begin + shot * SECOND // 40
        messages += [[row._replace(log_ns=later, stamp_ns=later) for row in each] for each in last_shot]
    advances = streamed(listening, messages, chunk=60, first=360)
    last = advances[-1]
    np.testing.assert_allclose(last.rig.base_from_turret, [0.1, 0.0, 0.0], atol=1e-9)
    # The turret stays where the last turn ended.
    np.testing.assert_allclose(sweeps_of(advances)[-1].servo_angles[-399:], -1.0, atol=1e-9)


def test_a_sensor_that_falls_silent_leaves_the_numbers_of_the_others(tmp_path: Path) -> None:
    sent = list(drive(recorded_by(ring(3), rounds=40), ROBOT))
    quiet = [each for each in sent if each.topic != "/sonar_0" or each.log_ns < NOON_NS + SECOND]
    listening, messages = listened(write_mcap(tmp_path / "run.mcap", quiet))
    sweeps = sweeps_of(streamed(listening, messages, chunk=20, first=120))
    assert {*sweeps[0].sensor_ids.tolist()} == {0, 1, 2}
    assert {*sweeps[-1].sensor_ids.tolist()} == {1, 2}


def test_a_sensor_that_is_new_is_refused(tmp_path: Path) -> None:
    sent = list(drive(recorded_by(ring(3), rounds=40), ROBOT))
    late = [each for each in sent if each.topic != "/sonar_0" or each.log_ns > NOON_NS + 2 * SECOND]
    listening, messages = listened(write_mcap(tmp_path / "run.mcap", late))
    with pytest.raises(InputError, match="sensors were added, or are mounted or turned differently than at the start"):
        streamed(listening, messages, chunk=20, first=60)


def test_time_that_goes_back_is_refused(tmp_path: Path) -> None:
    listening, messages = listened(write_mcap(tmp_path / "run.mcap", spun(turns=4)))
    with pytest.raises(InputError, match=r"time goes back by 4\.0 s"):
        streamed(listening, [*messages, *messages[:60]], chunk=60, first=240)


def test_poses_may_come_from_transforms_of_a_robot_that_does_not_move_yet(tmp_path: Path) -> None:
    stays = [each._replace(message=ROBOT.odometry((1.0, 2.0, 0.0), stamp_ns=each.log_ns)) for each in spun(turns=2)]
    sent = []
    for each, own in zip(spun(turns=2), stays, strict=True):
        if each.topic != "/odom":
            sent.append(each)
            continue
        pose = ROBOT.transform("odom", "base_link", (1.0, 2.0, 0.0), stamp_ns=own.log_ns)
        sent.append(Sent("/tf", own.log_ns, pose))
    listening, messages = listened(write_mcap(tmp_path / "run.mcap", sent))
    last = streamed(listening, messages, chunk=600)
    assert last[0].world == "odom"
    np.testing.assert_allclose(sweeps_of(last)[0].map_from_base[:, :2], [[1.0, 2.0]] * 40)


def test_the_clock_of_the_robot_is_known(tmp_path: Path) -> None:
    sent = [each._replace(log_ns=each.log_ns - SECOND) for each in spun(turns=2)]
    listening, messages = listened(write_mcap(tmp_path / "run.mcap", sent))
    assert streamed(listening, messages, chunk=600)[0].clock_offset_ns == SECOND
