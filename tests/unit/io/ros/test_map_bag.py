"""Maps for RViz and Foxglove, read back by rosbags and by the reader of mcap itself."""

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore
from scipy.spatial.transform import Rotation

from echoplan.arrays import FloatArray
from echoplan.errors import InvalidValueError, MissingExtraError
from echoplan.geometry import compose
from echoplan.grids import grid_from_map
from echoplan.io.ros import write_map_bag
from echoplan.model import FeatureMap, UnobservedStretch
from helpers.maps import corner, cylinder, wall
from helpers.planning import TWO_ROOMS

TIMES_NS = 1_763_700_000_123_456_789 + 2_000_000_000 * np.arange(4)
COVARIANCES = (
    np.array([[4e-4, 1e-4, 2e-5], [1e-4, 9e-4, 3e-5], [2e-5, 3e-5, 1e-4]]) * np.arange(1.0, 5.0)[:, None, None]
)
ODOMETRY = TWO_ROOMS.poses + np.array([0.1, -0.2, 0.05]) * np.arange(1, 5)[:, None]
MAP = replace(
    TWO_ROOMS,
    walls=(*TWO_ROOMS.walls, replace(wall([1, 1], [2, 1]), inferred=np.array([0.25, 0.0]))),
    corners=(replace(corner([3.0, 1.5]), covariance=np.diag([4e-4, 1e-4])), corner([0.0, 4.0])),
    cylinders=(cylinder([5.0, 3.0], 0.2),),
    unobserved=(UnobservedStretch(endpoints_xy=np.array([[2.0, 1.0], [2.5, 1.0]]), walls=(6,)),),
    pose_covariances=COVARIANCES,
)
GRID = grid_from_map(MAP)


def written(folder: Path, feature_map: FeatureMap = MAP, **changed: Any) -> Path:
    path = folder / "map.mcap"
    arguments: dict[str, Any] = {"grid": GRID, "times_ns": TIMES_NS, "odom_from_base": ODOMETRY}
    write_map_bag(path, feature_map, **(arguments | changed))
    return path


def decoded(path: Path) -> dict[str, list[tuple[int, Any]]]:
    """Times and messages of each topic, by the reader of mcap."""
    found: dict[str, list[tuple[int, Any]]] = {}
    with path.open("rb") as file:
        for _, channel, message, content in make_reader(
            file, decoder_factories=[DecoderFactory()]
        ).iter_decoded_messages():
            found.setdefault(channel.topic, []).append((message.log_time, content))
    return found


def stamp_of(header: Any) -> int:
    return int(header.stamp.sec * 10**9 + header.stamp.nanosec)


def planar(position: Any, orientation: Any) -> FloatArray:
    """A pose or transform as x, y and yaw."""
    turn = Rotation.from_quat([orientation.x, orientation.y, orientation.z, orientation.w]).as_euler("xyz")
    assert (position.z, turn[0], turn[1]) == (0.0, 0.0, 0.0)
    return np.array([position.x, position.y, turn[2]])


def test_the_file_is_one_mcap_with_every_topic_and_nothing_beside_it(tmp_path: Path) -> None:
    path = written(tmp_path)
    assert [each.name for each in tmp_path.iterdir()] == ["map.mcap"]
    with path.open("rb") as file:
        reader = make_reader(file)
        summary = reader.get_summary()
    assert summary is not None
    assert summary.statistics is not None
    counts = {summary.channels[each].topic: n for each, n in summary.statistics.channel_message_counts.items()}
    assert counts == {"/map": 1, "/echoplan/markers": 1, "/echoplan/path": 1, "/echoplan/odometry": 4, "/tf": 4}
    kinds = {channel.topic: summary.schemas[channel.schema_id].name for channel in summary.channels.values()}
    assert kinds["/map"] == "nav_msgs/msg/OccupancyGrid"
    assert kinds["/tf"] == "tf2_msgs/msg/TFMessage"


def test_what_holds_for_the_whole_drive_is_latched(tmp_path: Path) -> None:
    with written(tmp_path).open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    for channel in summary.channels.values():
        # 1 is transient local, 2 volatile (rmw_qos_durability_policy_t).
        durability = 1 if channel.topic in ("/map", "/echoplan/markers", "/echoplan/path") else 2
        assert f"durability: {durability}" in channel.metadata["offered_qos_profiles"]
        assert "reliability: 1" in channel.metadata["offered_qos_profiles"]


def test_the_grid_has_the_cells_of_the_map_from_the_lower_left_row_by_row(tmp_path: Path) -> None:
    ((time, message),) = decoded(written(tmp_path))["/map"]
    assert time == stamp_of(message.header) == TIMES_NS[0]
    assert message.header.frame_id == "map"
    assert (message.info.height, message.info.width) == GRID.values.shape
    assert message.info.resolution == pytest.approx(0.05)
    assert planar(message.info.origin.position, message.info.origin.orientation) == pytest.approx(
        [*GRID.origin_xy, 0.0]
    )
    cells = np.reshape(message.data, GRID.values.shape)
    assert np.array_equal(cells, np.select([GRID.values == 1.0, GRID.values == 0.0], [100, 0], -1))


def test_poses_have_their_covariances_in_the_order_of_ros(tmp_path: Path) -> None:
    for number, (time, message) in enumerate(decoded(written(tmp_path))["/echoplan/odometry"]):
        assert time == stamp_of(message.header) == TIMES_NS[number]
        assert (message.header.frame_id, message.child_frame_id) == ("map", "base_link")
        pose = message.pose.pose
        assert planar(pose.position, pose.orientation) == pytest.approx(MAP.poses[number])
        covariance = np.reshape(message.pose.covariance, (6, 6))
        # x, y, z and the rotations about x, y and z.
        assert np.array_equal(covariance[np.ix_([0, 1, 5], [0, 1, 5])], COVARIANCES[number])
        assert not covariance[2:5].any()
        assert not covariance[:, 2:5].any()


def test_the_path_has_every_pose(tmp_path: Path) -> None:
    ((time, message),) = decoded(written(tmp_path))["/echoplan/path"]
    assert time == TIMES_NS[0]
    poses = [planar(each.pose.position, each.pose.orientation) for each in message.poses]
    assert np.array(poses) == pytest.approx(MAP.poses)
    assert [stamp_of(each.header) for each in message.poses] == TIMES_NS.tolist()


def test_map_to_odom_and_the_odometry_give_the_corrected_poses(tmp_path: Path) -> None:
    for number, (_, message) in enumerate(decoded(written(tmp_path))["/tf"]):
        (each,) = message.transforms
        assert (each.header.frame_id, each.child_frame_id) == ("map", "odom")
        map_from_odom = planar(each.transform.translation, each.transform.rotation)
        assert compose(map_from_odom, ODOMETRY[number]) == pytest.approx(MAP.poses[number])


@pytest.mark.parametrize(("frame", "odometry"), [("map", None), ("odom", ODOMETRY)])
def test_without_odometry_the_robot_itself_is_the_frame(
    tmp_path: Path, frame: str, odometry: FloatArray | None
) -> None:
    messages = decoded(written(tmp_path, replace(MAP, frame=frame), odom_from_base=odometry))["/tf"]
    for (_, message), pose in zip(messages, MAP.poses, strict=True):
        (each,) = message.transforms
        assert (each.header.frame_id, each.child_frame_id) == (frame, "base_link")
        assert planar(each.transform.translation, each.transform.rotation) == pytest.approx(pose)


def test_every_feature_is_marked_with_its_number(tmp_path: Path) -> None:
    ((_, message),) = decoded(written(tmp_path))["/echoplan/markers"]
    by_name = {(each.ns, each.id): each for each in message.markers}
    assert len(by_name) == len(message.markers)
    numbers = {name: [number for ns, number in by_name if ns == name] for name, _ in by_name}
    assert numbers == {
        "walls": list(range(7)),
        "wall numbers": list(range(7)),
        "inferred": [6],
        "openings": [0],
        "opening numbers": [0],
        "unobserved": [0],
        "corners": [0, 1],
        "corner ellipses": [0, 1],
        "corner numbers": [0, 1],
        "cylinders": [0],
        "cylinder numbers": [0],
    }
    assert by_name["wall numbers", 3].text == "wall 3"
    assert [(each.x, each.y) for each in by_name["walls", 0].points] == [(0.0, 0.0), (6.0, 0.0)]
    assert [each.x for each in by_name["walls", 6].points] == [1.25, 2.0]
    assert [each.x for each in by_name["inferred", 6].points] == [1.0, 1.25]
    assert by_name["cylinders", 0].scale.x == pytest.approx(0.4)
    # 95 %: 2.4477 standard deviations to either side.
    ellipse = by_name["corner ellipses", 0]
    assert (ellipse.scale.x, ellipse.scale.y) == pytest.approx((2 * 2.4477 * 0.02, 2 * 2.4477 * 0.01), rel=1e-4)
    assert all(
        each.header.frame_id == "map" and each.color.a > 0 and each.lifetime.sec == 0 for each in message.markers
    )
    assert {each.type for each in message.markers if each.ns in ("walls", "openings")} == {5}


def test_rosbags_reads_the_same(tmp_path: Path) -> None:
    path = written(tmp_path)
    store = get_typestore(Stores.ROS2_JAZZY)
    with AnyReader([path], default_typestore=store) as reader:
        read = [(each.topic, time, reader.deserialize(data, each.msgtype)) for each, time, data in reader.messages()]
    assert len(read) == 11
    assert [time for _, time, _ in read] == sorted(time for _, time, _ in read)
    odometry: list[Any] = [message for topic, _, message in read if topic == "/echoplan/odometry"]
    assert [message.pose.pose.position.x for message in odometry] == MAP.poses[:, 0].tolist()


def test_an_empty_map_has_a_grid_and_no_frames(tmp_path: Path) -> None:
    empty = FeatureMap(method="none")
    found = decoded(written(tmp_path, empty, grid=grid_from_map(empty), times_ns=[], odom_from_base=None))
    assert sorted(found) == ["/echoplan/markers", "/echoplan/path", "/map"]


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"times_ns": TIMES_NS[:3]}, "times_ns must have shape"),
        ({"times_ns": [-1, 0, 1, 2]}, "times_ns must lie in"),
        ({"times_ns": [0, 1, 2, 2**62]}, "times_ns must lie in"),
        ({"odom_from_base": ODOMETRY[:2]}, "odom_from_base must have shape"),
    ],
)
def test_times_and_odometry_that_do_not_fit_are_refused_and_nothing_is_written(
    tmp_path: Path, changed: dict[str, Any], message: str
) -> None:
    with pytest.raises(InvalidValueError, match=message):
        written(tmp_path, **changed)
    assert not list(tmp_path.iterdir())


def test_without_rosbags_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rosbags.typesys", None)
    with pytest.raises(
        MissingExtraError, match=r"rosbags is not installed; install it with: pip install rosbags \(extra 'ros'\)"
    ):
        written(tmp_path)
