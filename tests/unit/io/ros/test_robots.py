"""Sensors, mounting, servo and poses of robots of many kinds."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from echoplan.errors import InputError, UnknownNameError
from echoplan.io.ros import parse_bag_options, read_bag
from echoplan.model import Recording, Sweep
from helpers.bags import NOON_NS, Robot, Sent, drive, recorded_by, ring, write_mcap

ROBOT = Robot()
SECOND = 1_000_000_000


def facing_ahead(*, count: int = 11, frame: str = "sonar", distance: float = 1.5, **limits: Any) -> Iterator[Sent]:
    """One fixed sensor that is read ten times a second."""
    yield Sent("/tf_static", NOON_NS, ROBOT.transform("base_link", frame, (0.1, 0.0, 0.0)))
    for number in range(count):
        now = NOON_NS + number * SECOND // 10
        yield Sent("/range", now, ROBOT.sonar(distance, stamp_ns=now, frame=frame, **limits))


def driving_along_x(*, speed: float = 1.0, **names: str) -> Iterator[Sent]:
    """Odometry once a second, for a second."""
    for number in range(2):
        now = NOON_NS + number * SECOND
        yield Sent("/odom", now, ROBOT.odometry((speed * number, 0.0, 0.0), stamp_ns=now, **names))


def written(folder: Path, *sent: Iterator[Sent]) -> Path:
    return write_mcap(folder / "run.mcap", [each for some in sent for each in some])


def turret_of(*angles: float) -> Recording:
    """Two sensors on a servo that goes through some angles, one sweep a pass as echoplan splits them."""
    rig = replace(ring(2), base_from_turret=np.array([0.05, 0.02, 0.3]))
    sweep = Sweep(
        index=0,
        stamps_ns=np.repeat(np.arange(len(angles)) * SECOND // 10, 2),
        sensor_ids=np.tile([0, 1], len(angles)),
        servo_angles=np.repeat(angles, 2),
        ranges=np.full(2 * len(angles), 1.25),
        map_from_base=np.zeros((2 * len(angles), 3)),
    )
    return Recording(name="turret", rig=rig, sweeps=(sweep,))


def test_each_firing_round_of_a_ring_is_a_sweep_even_where_messages_are_lost(tmp_path: Path) -> None:
    sent = list(drive(recorded_by(ring(), rounds=4), ROBOT))
    sonar = [place for place, each in enumerate(sent) if each.topic.startswith("/sonar")]
    # The last of the first round, and the first of the second.
    for place in (sonar[4], sonar[3]):
        del sent[place]
    found = read_bag(write_mcap(tmp_path / "run.mcap", sent))
    assert [sweep.sensor_ids.tolist() for sweep in found] == [[0, 1, 2], [1, 2, 3], [0, 1, 2, 3], [0, 1, 2, 3]]


def test_sensors_are_numbered_as_people_count(tmp_path: Path) -> None:
    found = read_bag(write_mcap(tmp_path / "run.mcap", drive(recorded_by(ring(12), rounds=2), ROBOT)))
    np.testing.assert_allclose(found.rig.sensors[10].yaw, -np.pi / 3, atol=1e-6)


def test_a_frame_that_turns_is_a_turret_and_each_pass_of_it_a_sweep(tmp_path: Path) -> None:
    forth = np.linspace(-1.0, 1.0, 9)
    turret = turret_of(*forth, *forth[::-1], *forth)
    found = read_bag(write_mcap(tmp_path / "run.mcap", drive(turret, ROBOT)))
    assert [len(sweep) for sweep in found] == [18, 18, 18]
    np.testing.assert_allclose(found.rig.base_from_turret[:2], [0.05, 0.02], atol=1e-6)
    joined = np.concatenate([sweep.servo_angles for sweep in found])
    expected = turret.rig.base_from_sensors(turret.sweeps[0].sensor_ids, turret.sweeps[0].servo_angles)
    in_base = found.rig.base_from_sensors(np.concatenate([sweep.sensor_ids for sweep in found]), joined)
    np.testing.assert_allclose(in_base[:, :2], expected[:, :2], atol=1e-6)
    np.testing.assert_allclose(np.cos(in_base[:, 2] - expected[:, 2]), 1.0, atol=1e-9)


@pytest.mark.parametrize(
    ("angles", "lengths"),
    [
        # To and fro without a pause; with one; back at once; round and round; with the jitter of a cheap servo.
        ([0.0, 0.5, 1.0, 0.5, 0.0], [3, 2]),
        ([0.0, 0.5, 1.0, 1.0, 0.5, 0.0], [3, 3]),
        ([0.0, 0.5, 1.0, 0.0, 0.5, 1.0], [3, 3]),
        ([*np.arange(0.0, 4 * np.pi - 0.1, np.pi / 4)], [8, 8]),
        ([0.0, 0.5, 0.48, 1.0, 0.98, 1.01, 0.5, 0.0], [6, 2]),
    ],
)
def test_a_pass_ends_where_the_servo_turns_back(angles: list[float], lengths: list[int], tmp_path: Path) -> None:
    found = read_bag(write_mcap(tmp_path / "run.mcap", drive(turret_of(*angles), ROBOT)))
    assert [len(sweep) // 2 for sweep in found] == lengths


def test_poses_are_interpolated_the_shorter_way_round(tmp_path: Path) -> None:
    def turning() -> Iterator[Sent]:
        for number, yaw in enumerate((3.0, -3.0)):
            now = NOON_NS + number * SECOND
            yield Sent("/odom", now, ROBOT.odometry((number, 0.0, yaw), stamp_ns=now))

    found = read_bag(written(tmp_path, facing_ahead(), turning()))
    poses = np.concatenate([sweep.map_from_base for sweep in found])
    np.testing.assert_allclose(poses[:, 0], np.linspace(0.0, 1.0, 11), atol=1e-9)
    np.testing.assert_allclose(np.cos(poses[5, 2]), -1.0, atol=1e-9)


def test_readings_outside_the_poses_are_left_out_and_counted(tmp_path: Path) -> None:
    found = read_bag(written(tmp_path, facing_ahead(count=15), driving_along_x()))
    assert len(found) == 11
    assert found.notes == ("4 of 15 readings are left out: their pose or servo angle is unknown.",)


def test_readings_on_an_unknown_way_are_left_out(tmp_path: Path) -> None:
    def with_a_gap() -> Iterator[Sent]:
        for at, x in ((0.0, 0.0), (0.3, 0.0), (2.0, 3.0)):
            now = NOON_NS + round(at * SECOND)
            yield Sent("/odom", now, ROBOT.odometry((x, 0.0, 0.0), stamp_ns=now))

    assert len(read_bag(written(tmp_path, facing_ahead(), with_a_gap()))) == 4


def test_without_odometry_the_poses_are_those_of_the_transforms(tmp_path: Path) -> None:
    def moving() -> Iterator[Sent]:
        for number in range(2):
            now = NOON_NS + number * SECOND
            yield Sent("/tf", now, ROBOT.transform("odom", "base_footprint", (number, 0.0, 0.2), stamp_ns=now))
            yield Sent("/tf", now, ROBOT.transform("base_footprint", "base_link", (0.5, 0.0, 0.0), stamp_ns=now))

    found = read_bag(written(tmp_path, facing_ahead(), moving()))
    poses = np.concatenate([sweep.map_from_base for sweep in found])
    np.testing.assert_allclose(poses[[0, 10], 0], [0.5 * np.cos(0.2), 1.0 + 0.5 * np.cos(0.2)], atol=1e-6)


def following(*shifts: float, prefix: str = "") -> Iterator[Sent]:
    """Transforms of a robot at some places along x, one each tenth of a second."""
    for number, x in enumerate(shifts):
        now = NOON_NS + number * SECOND // 10
        yield Sent("/tf", now, ROBOT.transform(f"{prefix}odom", f"{prefix}base_link", (x, 0.0, 0.0), stamp_ns=now))


@pytest.mark.parametrize("orientation", [np.nan, 0.0])
def test_a_transform_that_is_not_finite_or_was_never_set_is_left_out(orientation: float, tmp_path: Path) -> None:
    sent = list(following(0.0, 0.1, 0.2, 0.3, 0.4))
    rotation = sent[2].message.transforms[0].transform.rotation
    for name in ("x", "y", "z", "w"):
        object.__setattr__(rotation, name, orientation)
    found = read_bag(written(tmp_path, facing_ahead(count=5), iter(sent)))
    poses = np.concatenate([sweep.map_from_base for sweep in found])
    np.testing.assert_allclose(poses[:, 0], [0.0, 0.1, 0.2, 0.3, 0.4], atol=1e-9)


def test_frames_may_have_the_name_of_the_robot_before_them(tmp_path: Path) -> None:
    def sensor(robot: str) -> Iterator[Sent]:
        yield Sent("/tf_static", NOON_NS, ROBOT.transform(f"{robot}/base_link", f"{robot}/sonar", (0.1, 0.0, 0.0)))
        yield from (each for each in facing_ahead(frame=f"{robot}/sonar") if each.topic == "/range")

    found = read_bag(written(tmp_path, sensor("robot1"), following(0.0, 0.1, 0.2, prefix="robot1/")))
    assert found.sweeps[1].map_from_base[0, 0] == pytest.approx(0.1)
    one, other = (following(0.0, 0.1, 0.2, prefix=f"robot{number}/") for number in (1, 2))
    with pytest.raises(
        InputError, match=r"its frames are robot1/base_link, robot1/odom, robot1/sonar, robot2/base_link"
    ):
        read_bag(written(tmp_path, sensor("robot1"), one, other))


def test_the_base_is_the_frame_of_which_odometry_speaks(tmp_path: Path) -> None:
    lower = iter([Sent("/tf_static", NOON_NS, ROBOT.transform("base_footprint", "base_link", (0.5, 0.0, 0.0)))])
    found = read_bag(written(tmp_path, lower, facing_ahead(), driving_along_x(child="base_footprint")))
    assert found.rig.sensors[0].x == pytest.approx(0.6)


def test_the_greatest_range_is_no_echo_and_said_so(tmp_path: Path) -> None:
    found = read_bag(written(tmp_path, facing_ahead(distance=4.0, most=4.0), driving_along_x()))
    assert np.isposinf([sweep.ranges[0] for sweep in found]).all()
    assert found.notes == ("11 of 11 readings are max_range or more and mean no echo.",)


@pytest.mark.parametrize("distance", [np.inf, -np.inf, np.nan])
def test_ranges_without_a_distance_are_kept(distance: float, tmp_path: Path) -> None:
    found = read_bag(written(tmp_path, facing_ahead(distance=distance), driving_along_x()))
    np.testing.assert_array_equal(next(iter(found)).ranges, [distance])
    assert found.notes == ()


def test_infrared_is_left_out_unless_it_is_named(tmp_path: Path) -> None:
    infrared = (each._replace(topic="/ir") for each in facing_ahead(frame="ir", kind=1) if each.topic == "/range")
    mount = iter([Sent("/tf_static", NOON_NS, ROBOT.transform("base_link", "ir", (0.0, 0.1, 0.0)))])
    path = written(tmp_path, facing_ahead(), mount, infrared, driving_along_x())
    found = read_bag(path)
    assert len(found.rig.sensors) == 1
    assert found.notes == ("/ir is infrared, not sonar, and is left out. To map it, name it with --topic.",)
    assert len(read_bag(path, parse_bag_options(topics=["/*r*"])).rig.sensors) == 2


def test_a_sensor_that_looks_at_the_floor_is_left_out(tmp_path: Path) -> None:
    cliff = (each._replace(topic="/cliff") for each in facing_ahead(frame="cliff") if each.topic == "/range")
    mount = iter([Sent("/tf_static", NOON_NS, ROBOT.transform("base_link", "cliff", (0.2, 0.0, 0.0), pitch=1.5))])
    found = read_bag(written(tmp_path, facing_ahead(), mount, cliff, driving_along_x()))
    assert len(found.rig.sensors) == 1
    remedy = "To keep it, state its mounting: --mount cliff=X,Y,YAW [m, m, rad]."
    assert found.notes == (f"cliff points at the floor or the ceiling and is left out. {remedy}",)


def test_sensors_that_look_at_the_floor_are_named_in_the_order_of_their_topics(tmp_path: Path) -> None:
    names = [f"cliff_{number}" for number in range(1, 9)]
    down = [
        Sent("/tf_static", NOON_NS, ROBOT.transform("base_link", name, (0.2, 0.0, 0.0), pitch=1.5)) for name in names
    ]
    cliffs = [
        each._replace(topic=f"/{name}") for name in names for each in facing_ahead(frame=name) if each.topic == "/range"
    ]
    found = read_bag(written(tmp_path, facing_ahead(), iter(down), iter(cliffs), driving_along_x()))
    assert [note.split()[0] for note in found.notes] == names


def test_sensors_may_be_mounted_by_the_user(tmp_path: Path) -> None:
    sent = [each for each in facing_ahead() if each.topic != "/tf_static"]
    path = written(tmp_path, iter(sent), driving_along_x())
    found = read_bag(path, parse_bag_options(mounts=["sonar=0.2,-0.1,1.5"]))
    assert found.rig.turret_from_sensors.tolist() == [[0.2, -0.1, 1.5]]


def test_a_stated_mounting_of_no_sensor_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path, facing_ahead(), driving_along_x())
    message = r"unknown sensor of --mount 'sonr'; did you mean 'sonar'\? known: range, sonar"
    with pytest.raises(UnknownNameError, match=message):
        read_bag(path, parse_bag_options(mounts=["sonr=0.2,-0.1,1.5"]))
    with pytest.raises(InputError, match="no topic has ranges of sonar"):
        read_bag(written(tmp_path, driving_along_x()), parse_bag_options(mounts=["sonr=0.2,-0.1,1.5"]))


def test_stamps_of_another_clock_are_replaced_by_the_times_of_recording(tmp_path: Path) -> None:
    # A microcontroller counts from its start.
    sent = [
        each if each.topic != "/range" else each._replace(message=ROBOT.sonar(1.5, stamp_ns=each.log_ns - NOON_NS + 1))
        for each in facing_ahead()
    ]
    found = read_bag(written(tmp_path, iter(sent), driving_along_x()))
    assert [sweep.stamps_ns[0] for sweep in found] == [NOON_NS + number * SECOND // 10 for number in range(11)]
    (note,) = found.notes
    assert note.startswith("The messages on /range were stamped by another clock, -1760000000 s off; the times")


def test_stamps_of_a_simulator_are_used_where_all_topics_have_them(tmp_path: Path) -> None:
    driven = recorded_by(ring(2))
    sent = [each._replace(log_ns=NOON_NS + each.log_ns) for each in drive(driven, ROBOT, start_ns=5 * SECOND)]
    found = read_bag(write_mcap(tmp_path / "run.mcap", sent))
    assert found.sweeps[0].stamps_ns[0] == 5 * SECOND
    assert found.notes == ()


def test_messages_without_stamps_have_the_times_of_recording(tmp_path: Path) -> None:
    sent = [
        each if each.topic != "/range" else each._replace(message=ROBOT.sonar(1.5, stamp_ns=0))
        for each in facing_ahead()
    ]
    found = read_bag(written(tmp_path, iter(sent), driving_along_x()))
    assert found.sweeps[0].stamps_ns[0] == NOON_NS
    assert found.notes[0].startswith("The messages on /range have no stamps; the times of recording are used")


def test_messages_that_overtake_each_other_are_sorted(tmp_path: Path) -> None:
    sent = list(drive(recorded_by(ring(2)), ROBOT))
    swapped = [*sent[:-4], *sent[-2:], *sent[-4:-2]]
    found = read_bag(write_mcap(tmp_path / "run.mcap", swapped))
    assert [len(sweep) for sweep in found] == [2] * 5


def scan_of(count: int = 5) -> Iterator[Sent]:
    """A sonar that turns through five bearings for each scan."""
    yield Sent("/tf_static", NOON_NS, ROBOT.transform("base_link", "head", (0.1, 0.0, 0.0)))
    for number in range(count):
        now = NOON_NS + number * SECOND // 5
        scan = ROBOT.make(
            "sensor_msgs/msg/LaserScan",
            header=ROBOT.header("head", now),
            angle_min=-1.0,
            angle_max=1.0,
            angle_increment=0.5,
            time_increment=0.01,
            scan_time=0.1,
            range_min=0.02,
            range_max=4.0,
            ranges=np.full(5, 1.5, dtype=np.float32),
            intensities=np.zeros(0, dtype=np.float32),
        )
        yield Sent("/scan", now, scan)


def test_a_scan_that_is_named_is_a_pass_of_a_servo(tmp_path: Path) -> None:
    path = written(tmp_path, scan_of(), driving_along_x())
    found = read_bag(path, parse_bag_options(topics=["/scan"], fields=["field_of_view=0.5"]))
    assert [len(sweep) for sweep in found] == [5] * 5
    np.testing.assert_allclose(found.sweeps[1].servo_angles, [-1.0, -0.5, 0.0, 0.5, 1.0])
    np.testing.assert_allclose(np.diff(found.sweeps[1].stamps_ns), 10_000_000, atol=1)
    np.testing.assert_allclose(found.rig.base_from_turret, [0.1, 0.0, 0.0])


def test_other_types_of_poses_are_read_where_they_are_named(tmp_path: Path) -> None:
    def localised() -> Iterator[Sent]:
        for each in driving_along_x():
            pose = ROBOT.make("geometry_msgs/msg/PoseStamped", header=each.message.header, pose=each.message.pose.pose)
            yield Sent("/pose", each.log_ns, pose)

    path = written(tmp_path, facing_ahead(), localised())
    with pytest.raises(InputError, match="it has no poses of the robot"):
        read_bag(path)
    found = read_bag(path, parse_bag_options(odometry="/pose"))
    assert found.sweeps[-1].map_from_base[0, 0] == pytest.approx(1.0)


def test_an_orientation_that_was_never_set_is_no_pose(tmp_path: Path) -> None:
    nothing = ROBOT.make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.0, w=0.0)

    def unset() -> Iterator[Sent]:
        for each in driving_along_x():
            pose = replace(each.message.pose, pose=replace(each.message.pose.pose, orientation=nothing))
            yield each._replace(message=replace(each.message, pose=pose))

    with pytest.raises(InputError, match="/odom: none of its poses has finite numbers and a valid orientation"):
        read_bag(written(tmp_path, facing_ahead(), unset()))


def sliding() -> Iterator[Sent]:
    """A sensor on a slide."""
    for number in range(2):
        now = NOON_NS + number * SECOND
        yield Sent("/tf", now, ROBOT.transform("base_link", "sonar", (0.5 * number, 0.0, 0.0), stamp_ns=now))


def far_away() -> Iterator[Sent]:
    """A mounting in millimetres, which replaces that of before."""
    yield Sent("/tf_static", NOON_NS + 1, ROBOT.transform("base_link", "far", (120.0, 0.0, 0.0)))


def twice(sent: Iterator[Sent]) -> Iterator[Sent]:
    """Messages of a simulation that was started again after ten seconds."""
    first = list(sent)
    yield from first
    yield from (each._replace(log_ns=each.log_ns + 10 * SECOND) for each in first)


REFUSED = {
    "no poses": (
        [facing_ahead()],
        {},
        """run.mcap: it has no poses of the robot: no nav_msgs/Odometry and no transform from odom to
        base_link (its frames are base_link, sonar); record /odom, or name a topic of poses with --odom; if the robot
        stood still, add --field x=0 --field y=0 --field yaw=0""",
    ),
    "no ranges": (
        [driving_along_x()],
        {},
        """run.mcap: no topic has ranges of sonar (sensor_msgs/Range); it has /odom (nav_msgs/msg/Odometry); record
        them, name the field of another type: --field range=/TOPIC.FIELD, or a sonar's LaserScan: --topic""",
    ),
    "no transform": (
        [facing_ahead(), driving_along_x(child="base_footprint")],
        {},
        """run.mcap, /range: there is no transform from base_footprint to sonar; record /tf_static (and /tf), state
        where it is mounted: --mount sonar=X,Y,YAW [m, m, rad], or name the other topics with --topic""",
    ),
    "no frame": (
        [facing_ahead(frame=""), driving_along_x()],
        {},
        """run.mcap, /range: its messages name no frame; record /tf_static (and /tf), state where it is mounted:
        --mount range=X,Y,YAW [m, m, rad], or name the other topics with --topic""",
    ),
    "no beam": (
        [facing_ahead(view=0.0), driving_along_x()],
        {},
        """run.mcap, /range: its field_of_view is 0; state it from the data sheet, for example --field
        field_of_view=0.5 [rad, the full angle]""",
    ),
    "degrees": (
        [facing_ahead(view=30.0), driving_along_x()],
        {},
        """run.mcap, /range: field_of_view is 30, more than a full turn; if these are degrees, add --field
        field_of_view=0.5236 [rad]""",
    ),
    "limits": (
        [facing_ahead(least=5.0), driving_along_x()],
        {},
        """run.mcap, /range: min_range, 5, is not less than max_range, 4; state them: --field min_range=0.02 --field
        max_range=4""",
    ),
    "ranges in centimetres": (
        [facing_ahead(distance=150.0), driving_along_x()],
        {},
        """run.mcap, /range: its ranges, up to 150, are not in metres where max_range is 4; add --field
        range=/range.range*0.01 or --field range=/range.range*0.001 or --field range=/range.range*0.0254, and state
        field_of_view, min_range and max_range with --field""",
    ),
    "limits in centimetres": (
        [facing_ahead(distance=150.0, most=400.0), driving_along_x()],
        {},
        """run.mcap, /range: its ranges, up to 150, are not in metres where max_range is 400; add --field
        range=/range.range*0.01 or --field range=/range.range*0.001, and state field_of_view,
        min_range and max_range with --field""",
    ),
    "a sensor far from its robot": (
        [facing_ahead(frame="far"), driving_along_x(), far_away()],
        {},
        """run.mcap, /range: it is mounted 120 m from the robot; write the transforms in metres, or state it with
        --mount""",
    ),
    "two topics of odometry": (
        [facing_ahead(), driving_along_x(), (each._replace(topic="/ekf") for each in driving_along_x())],
        {},
        "run.mcap: 2 topics have odometry; name one: --odom /ekf or --odom /odom",
    ),
    "two runs": (
        [twice(facing_ahead(count=16)), twice(driving_along_x())],
        {},
        """run.mcap, /range: time goes back by 1.5 s at message 17; the bag contains two runs, or a topic with two
        publishers: split the bag at this message""",
    ),
    "an unknown topic": (
        [facing_ahead()],
        {"odometry": "/odm"},
        "unknown topic '/odm'; known: /range, /tf_static",
    ),
    "a scan that is not named in full": (
        [scan_of(), driving_along_x()],
        {"topics": ["/sc*"]},
        """--topic, /sc*: it has no sensor_msgs/Range: /scan (sensor_msgs/msg/LaserScan); name a sonar's LaserScan in
        full, or the field with the range: --field range=/TOPIC.FIELD""",
    ),
    "a scan of unknown beam": (
        [scan_of(), driving_along_x()],
        {"topics": ["/scan"]},
        """run.mcap, /scan: its messages lack the field_of_view; state it from the data sheet, for example --field
        field_of_view=0.5 [rad, the full angle]""",
    ),
    "a scan and a fixed sensor": (
        [scan_of(), facing_ahead(), driving_along_x()],
        {"topics": ["/scan", "/range"], "fields": ["field_of_view=0.5"]},
        """run.mcap: not all sensors turn together: /range is fixed, /scan turns with head; name those to map together
        with --topic""",
    ),
    "no odometry on the topic": (
        [facing_ahead(), driving_along_x()],
        {"odometry": "/range"},
        """--odom: /range has no poses; its type is sensor_msgs/msg/Range; name a topic of
        nav_msgs/Odometry or geometry_msgs/PoseStamped""",
    ),
    "a sensor on a slide": (
        [sliding(), (each for each in facing_ahead() if each.topic == "/range"), driving_along_x()],
        {},
        """run.mcap, /range: sonar moves relative to the robot, other than by turning about one upright axis; state
        a rigid mounting: --mount sonar=X,Y,YAW [m, m, rad]""",
    ),
}


@pytest.mark.parametrize(("parts", "options", "message"), REFUSED.values(), ids=list(REFUSED))
def test_what_cannot_be_mapped_is_refused_in_one_line(
    parts: list[Iterator[Sent]], options: dict[str, Any], message: str, tmp_path: Path
) -> None:
    path = written(tmp_path, *parts)
    with pytest.raises((InputError, UnknownNameError)) as refused:
        read_bag(path, parse_bag_options(**options))
    assert str(refused.value).replace(f"{tmp_path}/", "") == " ".join(message.split())


def test_a_bag_without_messages_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"run\.mcap: there is no message in it; record it again; check with"):
        read_bag(written(tmp_path))


def test_readings_and_poses_must_overlap(tmp_path: Path) -> None:
    later = NOON_NS + 60 * SECOND
    still = [Sent("/odom", later, ROBOT.odometry((0.0, 0.0, 0.0), stamp_ns=later))]
    with pytest.raises(InputError, match="unknown at the time of every reading; record the readings and /odom at"):
        read_bag(written(tmp_path, facing_ahead(), iter(still)))


def test_a_position_that_jumps_out_of_the_world_is_refused(tmp_path: Path) -> None:
    with pytest.raises(
        InputError, match=r"/odom: the poses lie up to 1e\+05 m apart, and echoplan maps at most 10000 m"
    ):
        read_bag(written(tmp_path, facing_ahead(), driving_along_x(speed=100_000.0)))


def test_a_topic_of_two_robots_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path, facing_ahead(), driving_along_x(), driving_along_x(child="other"))
    with pytest.raises(
        InputError, match=r"/odom: its poses are in several frames: odom > base_link, odom > other; name"
    ):
        read_bag(path)
