"""Quantities from fields of messages of any type, as the user names them."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from echoplan.errors import InputError, UnknownNameError
from echoplan.io.ros import parse_bag_options, read_bag, summarise_bag
from helpers.bags import NOON_NS, Robot, Sent, write_mcap, write_ros1

STANDING = ["x=0", "y=0", "yaw=0"]
HC_SR04 = ["field_of_view=0.5", "min_range=0.02", "max_range=4"]
ECHO = """std_msgs/Header header
int32 millimetres
float64 heading_deg
geometry_msgs/Quaternion orientation
float64[] raw
"""
REAL = Path(__file__).parents[4] / ".." / "shared" / "data" / "real" / "Lvl_1_Room_Map_4.bag"


def own_type(store: Stores) -> Robot:
    """A robot with a message type of its own: range and orientation in one message."""
    types = get_typestore(store)
    types.register(get_types_from_msg(ECHO, "my_robot/msg/Echo"))
    return Robot(types)


def turned_by_hand(robot: Robot) -> Iterator[Sent]:
    for number in range(5):
        now = NOON_NS + number * 100_000_000
        echo = robot.make(
            "my_robot/msg/Echo",
            header=robot.header("head", now),
            millimetres=1500 + number,
            heading_deg=10.0 * number,
            orientation=robot.turn(0.3 * number),
            raw=np.array([0.0, 2.0 + number]),
        )
        yield Sent("/echo", now, echo)


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    robot = own_type(Stores.ROS2_JAZZY)
    return write_mcap(tmp_path / "run.mcap", turned_by_hand(robot), store=robot.store)


@pytest.mark.parametrize(
    ("servo", "angles"),
    [
        ("/echo.heading_deg*-0.0174532925", np.radians([0.0, -10.0, -20.0, -30.0, -40.0])),
        ("/echo.orientation", [0.0, 0.3, 0.6, 0.9, 1.2]),
    ],
)
def test_range_and_angle_may_come_from_one_message(servo: str, angles: list[float], bag: Path) -> None:
    fields = ["range=/echo.millimetres*0.001", f"servo={servo}", *STANDING, *HC_SR04]
    found = read_bag(bag, parse_bag_options(fields=fields))
    (sweep,) = found
    np.testing.assert_allclose(sweep.ranges, [1.5, 1.501, 1.502, 1.503, 1.504])
    np.testing.assert_allclose(sweep.servo_angles, angles, atol=1e-9)
    np.testing.assert_array_equal(sweep.map_from_base, np.zeros((5, 3)))
    (sensor,) = found.rig.sensors
    assert (sensor.half_aperture, sensor.min_range, sensor.max_range) == (0.25, 0.02, 4.0)
    (note,) = found.notes
    assert note.startswith(
        "The mounting of the sensor on /echo is unknown; the middle of the robot is assumed: state it"
    )


def test_an_angle_in_degrees_is_refused(tmp_path: Path) -> None:
    robot = own_type(Stores.ROS2_JAZZY)
    path = write_mcap(tmp_path / "run.mcap", turned_by_hand(robot), store=robot.store)
    fields = ["range=/echo.millimetres*0.001", "servo=/echo.heading_deg", *STANDING, *HC_SR04]
    with pytest.raises(InputError, match=r"servo=/echo\.heading_deg: the angles look like degrees; write --field serv"):
        read_bag(path, parse_bag_options(fields=fields))


def test_fields_that_may_be_ranges_are_found_by_their_names(bag: Path) -> None:
    # The name of the topic says it of all its numbers.
    summary = summarise_bag(bag)
    assert summary.candidates[:2] == ("/echo.millimetres", "/echo.heading_deg")
    assert summary.candidates[-1] == "/echo.raw[0]"
    options = parse_bag_options(fields=["range=/echo.raw[1]", *STANDING, *HC_SR04])
    assert summarise_bag(bag, options).candidates == ()


def test_a_stated_mounting_needs_no_note(bag: Path) -> None:
    fields = ["range=/echo.millimetres*0.001", *STANDING, *HC_SR04]
    found = read_bag(bag, parse_bag_options(fields=fields, mounts=["head=0.1,0,1.5"]))
    assert found.rig.turret_from_sensors.tolist() == [[0.1, 0.0, 1.5]]
    assert found.notes == ()


def test_a_message_may_have_the_ranges_of_several_sensors(bag: Path) -> None:
    fields = ["range=/echo.raw[1]", "range=/echo.millimetres*0.001", *STANDING, *HC_SR04]
    with pytest.raises(InputError, match=r"there is no transform from base_link to head; rec.*: --mount echo\.mill"):
        read_bag(bag, parse_bag_options(fields=fields))
    mounts = ["echo.raw[1]=0.1,0,0", "echo.millimetres=0,0.1,1.5"]
    found = read_bag(bag, parse_bag_options(fields=fields, mounts=mounts))
    assert found.rig.turret_from_sensors.tolist() == [[0.0, 0.1, 1.5], [0.1, 0.0, 0.0]]
    np.testing.assert_allclose([sweep.ranges for sweep in found][1], [1.501, 3.0])


def test_yaw_may_come_from_a_compass(bag: Path) -> None:
    fields = ["range=/echo.raw[1]", "x=1", "y=2", "yaw=/echo.orientation", *HC_SR04]
    poses = np.concatenate([sweep.map_from_base for sweep in read_bag(bag, parse_bag_options(fields=fields))])
    np.testing.assert_allclose(poses, np.column_stack([np.ones(5), np.full(5, 2.0), 0.3 * np.arange(5)]), atol=1e-9)


def test_a_bag_of_ros_1_brings_its_own_types(tmp_path: Path) -> None:
    robot = own_type(Stores.ROS1_NOETIC)
    path = write_ros1(tmp_path / "run.bag", turned_by_hand(robot), store=robot.store)
    found = read_bag(path, parse_bag_options(fields=["range=/echo.raw[1]", *STANDING, *HC_SR04]))
    np.testing.assert_allclose(np.concatenate([sweep.ranges for sweep in found]), [2.0, 3.0, np.inf, np.inf, np.inf])


def test_a_servo_may_be_named_by_its_joint(tmp_path: Path) -> None:
    robot = Robot()

    def panning() -> Iterator[Sent]:
        yield Sent("/tf_static", NOON_NS, robot.transform("base_link", "sonar", (0.1, 0.0, 0.0)))
        for number in range(5):
            now = NOON_NS + number * 100_000_000
            state = robot.make(
                "sensor_msgs/msg/JointState",
                header=robot.header("", now),
                name=["left_wheel", "pan"],
                position=np.array([9.0, 0.25 * number]),
                velocity=np.zeros(2),
                effort=np.zeros(2),
            )
            yield Sent("/joint_states", now, state)
            yield Sent("/range", now, robot.sonar(1.5, stamp_ns=now))

    path = write_mcap(tmp_path / "run.mcap", panning())
    fields = ["servo=/joint_states.position[pan]", *STANDING]
    (sweep,) = read_bag(path, parse_bag_options(fields=fields))
    np.testing.assert_allclose(sweep.servo_angles, [0.0, 0.25, 0.5, 0.75, 1.0])
    with pytest.raises(InputError, match=r"position\[tilt\]: a message of /joint_states has no 'tilt'; known here: l"):
        read_bag(path, parse_bag_options(fields=["servo=/joint_states.position[tilt]", *STANDING]))


def test_a_range_in_another_unit_takes_the_place_of_the_message(tmp_path: Path) -> None:
    robot = Robot()

    def in_centimetres() -> Iterator[Sent]:
        yield Sent("/tf_static", NOON_NS, robot.transform("base_link", "sonar", (0.1, 0.0, 0.0)))
        yield Sent("/range", NOON_NS, robot.sonar(150.0, stamp_ns=NOON_NS, most=400.0))

    path = write_mcap(tmp_path / "run.mcap", in_centimetres())
    (sweep,) = read_bag(path, parse_bag_options(fields=["range=/range.range*0.01", *STANDING, *HC_SR04]))
    assert sweep.ranges.tolist() == [1.5]


@pytest.mark.parametrize(
    ("field", "message"),
    [
        (
            "range",
            r"--field: 'range' is not KEY=/TOPIC\.FIELD or KEY=NUMBER; write for example --field range=/echo\.dist",
        ),
        ("range=/echo", r"'range=/echo' is not KEY=/TOPIC\.FIELD or KEY=NUMBER"),
        ("range=/echo.raw*", r"'range=/echo\.raw\*' is not KEY=/TOPIC\.FIELD or KEY=NUMBER"),
        ("range=1.5", r"--field: range must be a field; write for example --field range=/TOPIC\.FIELD"),
        ("max_range=/echo.raw[0]", r"--field: max_range must be a number; write for example --field max_range=0\.5"),
        ("range=/echo.raw[1]*half", r"--field range: 'half' is not a finite number; write digits with a decimal point"),
        ("x=nan", r"--field x: 'nan' is not a finite number"),
        ("range=/echo.metres", r"range=/echo\.metres: a message of /echo has no 'metres'; known here: header, milli"),
        ("range=/echo.raw[2]", r"range=/echo\.raw\[2\]: a message of /echo has no '2'; indices of an array start"),
        ("range=/echo.header", r"it is not a number but std_msgs/msg/Header; name a field inside it: stamp, frame_id"),
        ("range=/echo.raw", r"it is not a number but ndarray; name a field that is a number"),
    ],
)
def test_a_field_that_is_wrong_is_refused_with_what_there_is(field: str, message: str, bag: Path) -> None:
    with pytest.raises(InputError, match=message):
        read_bag(bag, parse_bag_options(fields=[field, *STANDING[1:], *HC_SR04[:2]]))


def test_an_unknown_quantity_or_topic_is_refused_with_the_nearest(bag: Path) -> None:
    with pytest.raises(UnknownNameError, match="unknown quantity of --field 'rnge'; did you mean 'range'"):
        parse_bag_options(fields=["rnge=/echo.raw[1]"])
    with pytest.raises(UnknownNameError, match="unknown topic '/ecco'; did you mean '/echo'"):
        read_bag(bag, parse_bag_options(fields=["range=/ecco.raw[1]", *STANDING]))
    for fields in (["x=0", "x=1"], ["range=/echo.raw[1]"] * 2):
        with pytest.raises(InputError, match=r"--field: (x|range) is given 2 times; give it once"):
            parse_bag_options(fields=fields)


@pytest.mark.parametrize(
    ("mount", "message"),
    [
        ("head", r"'head' is not FRAME=X,Y,YAW; write for example --mount sonar_left=0\.1,0\.05,1\.57"),
        ("head=1,2", r"'head=1,2' is not FRAME=X,Y,YAW"),
        ("head=1,2,left", r"'left' is not a finite number"),
        ("head=1,2,90", r"the yaw of head, 90, is more than a full turn; write radians: 1\.5708 if it is in degr"),
    ],
)
def test_a_mounting_that_is_wrong_is_refused(mount: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        parse_bag_options(mounts=[mount])


def test_a_recorded_bag_with_a_type_of_its_own_is_read() -> None:
    if not REAL.exists():
        pytest.skip("the bag Lvl_1_Room_Map_4.bag is not here")
    fields = ["range=/fusion.range*0.001", "servo=/fusion.yaw*-1", *STANDING, "field_of_view=0.7", "min_range=0.3"]
    found = read_bag(REAL, parse_bag_options(fields=[*fields, "max_range=4.99"]))
    assert sum(map(len, found)) == 1374
    assert found.rig.sensors[0].resolution == pytest.approx(0.001)
    angles = np.concatenate([sweep.servo_angles for sweep in found])
    assert np.ptp(np.unwrap(angles)) == pytest.approx(6.0, abs=1.0)
