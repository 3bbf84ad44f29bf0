"""Damaged, unfinished and foreign files are refused in one line; nothing of rosbags gets out."""

import builtins
import random
import sqlite3
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from mcap.writer import Writer

from echoplan.errors import EchoplanError, InputError, MissingExtraError
from echoplan.io.ros import is_bag, parse_bag_options, read_bag
from helpers.bags import (
    HUMBLE,
    NOON_NS,
    ROS1,
    Robot,
    Sent,
    drive,
    recorded_by,
    ring,
    write_humble_database,
    write_mcap,
    write_ros1,
    write_ros2,
)

DRIVEN = recorded_by(ring(2), rounds=2)
WRITTEN: dict[str, Callable[[Path], Path]] = {
    "run.mcap": lambda path: write_mcap(path, drive(DRIVEN, Robot())),
    "run.db3": lambda path: write_humble_database(path, drive(DRIVEN, Robot(HUMBLE))),
    "run.bag": lambda path: write_ros1(path, drive(DRIVEN, Robot(ROS1))),
}


def test_bags_are_known_by_their_names_or_what_is_in_a_folder(tmp_path: Path) -> None:
    names = ("a.bag", "a.mcap", "a.db3", "a.csv", "a", "a.bag.active", "A.BAG")
    assert [name for name in names if is_bag(tmp_path / name)] == ["a.bag", "a.mcap", "a.db3", "a.bag.active", "A.BAG"]
    (tmp_path / "run").mkdir()
    assert not is_bag(tmp_path / "run")
    (tmp_path / "run" / "metadata.yaml").touch()
    assert is_bag(tmp_path / "run")
    (tmp_path / "run" / "pings.csv").touch()
    assert not is_bag(tmp_path / "run")


@pytest.mark.parametrize("name", WRITTEN)
def test_bags_are_known_by_their_first_bytes_whatever_their_names_are(name: str, tmp_path: Path) -> None:
    assert is_bag(WRITTEN[name](tmp_path / name).rename(tmp_path / "recorded today"))


@pytest.mark.parametrize("name", ["RUN.BAG", "run", "run.mcap"])
def test_a_bag_of_ros_1_is_read_whatever_its_name_is(name: str, tmp_path: Path) -> None:
    assert len(read_bag(WRITTEN["run.bag"](tmp_path / name))) == 2


@pytest.mark.parametrize(("written", "name"), [("run.mcap", "run.bag"), ("run.mcap", "run.db3"), ("run.db3", "run")])
def test_a_bag_of_ros_2_with_the_name_of_another_kind_is_refused(written: str, name: str, tmp_path: Path) -> None:
    path = WRITTEN[written](tmp_path / written).rename(tmp_path / name)
    suffix = Path(written).suffix
    with pytest.raises(InputError, match=rf"{name}: it is a \{suffix} file by its first bytes; name it run\{suffix}"):
        read_bag(path)


def test_another_database_is_refused(tmp_path: Path) -> None:
    database = sqlite3.connect(tmp_path / "run.db3")
    database.execute("CREATE TABLE notes(text)")
    database.close()
    with pytest.raises(InputError, match=r"run\.db3: it is not a bag but another SQLite database; check the name"):
        read_bag(tmp_path / "run.db3")


def test_a_folder_without_metadata_is_read_if_it_has_one_file(tmp_path: Path) -> None:
    (tmp_path / "run").mkdir()
    write_mcap(tmp_path / "run" / "a.mcap", drive(DRIVEN, Robot()))
    assert len(read_bag(tmp_path / "run")) == 2
    (tmp_path / "run" / "b.mcap").touch()
    with pytest.raises(InputError, match=r"run: metadata\.yaml is missing; restore it with: ros2 bag reindex"):
        read_bag(tmp_path / "run")


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("run.mcap", b"", "the file is empty; record it again"),
        ("run.bag", b"", "the file is empty; record it again"),
        ("run.mcap", b"t,sweep,sensor\n" * 9, "it is not a bag, although its name ends like one; check the name"),
        ("run.bag", b"t,sweep,sensor\n" * 9, "it is not a bag, although its name ends like one; check the name"),
        ("run.db3", b"t,sweep,sensor\n" * 99, "it is not a bag, although its name ends like one; check the name"),
        ("run.bag.active", b"#ROSBAG V2.0", "it was not closed; close it with: rosbag reindex FILE, and name it with"),
        ("run.db3.zstd", b"(", "the file is compressed; name its folder, or decompress it: zstd -d FILE"),
    ],
)
def test_what_is_no_bag_is_refused(name: str, content: bytes, message: str, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=f"{name}: {message}"):
        read_bag(tmp_path / name)


def test_a_bag_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"run\.bag: there is no such file; check the name"):
        read_bag(tmp_path / "run.bag")


@pytest.mark.parametrize(
    ("name", "message"),
    [
        (
            "run.mcap",
            r"it was not closed: its end is missing; repair it with: mcap recover run\.mcap -o rep",
        ),
        ("run.bag", r"its index is damaged; repair it with: rosbag reindex run\.bag"),
        ("run.db3", "it is damaged or cut short .*malformed.*; repair it"),
    ],
)
def test_a_bag_that_was_cut_short_is_refused_with_its_repair(name: str, message: str, tmp_path: Path) -> None:
    path = WRITTEN[name](tmp_path / name)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with pytest.raises(InputError, match=message):
        read_bag(path)


@pytest.mark.parametrize("name", WRITTEN)
def test_nothing_but_our_errors_comes_of_damaged_bags(name: str, tmp_path: Path) -> None:
    rng = random.Random(5)
    path = WRITTEN[name](tmp_path / name)
    whole = path.read_bytes()
    for _ in range(30):
        damaged = bytearray(whole[: rng.randrange(len(whole))] if rng.random() < 0.3 else whole)
        for _ in range(20):
            damaged[rng.randrange(len(damaged))] = rng.randrange(256)
        path.write_bytes(damaged)
        try:
            read_bag(path)
        except EchoplanError as error:
            message = str(error).replace(str(tmp_path), "")
            assert len(message) < 500
            assert "()" not in message


def test_mcap_of_other_programs_is_refused(tmp_path: Path) -> None:
    with (tmp_path / "run.mcap").open("wb") as file:
        writer = Writer(file)
        writer.start(profile="protobuf")
        writer.finish()  # type: ignore[no-untyped-call]  # mcap has few annotations
    with pytest.raises(InputError, match="it is an mcap file without the ROS 2 profile; convert it to a ROS 2 bag"):
        read_bag(tmp_path / "run.mcap")


def test_metadata_of_the_future_is_refused(tmp_path: Path) -> None:
    path = write_ros2(tmp_path / "run", drive(DRIVEN, Robot()))
    metadata = path / "metadata.yaml"
    metadata.write_text(metadata.read_text().replace("version: 9", "version: 99"))
    with pytest.raises(InputError, match=r"its version is not supported; use: ros2 bag convert"):
        read_bag(path)


def test_a_type_that_a_bag_does_not_define_is_refused(tmp_path: Path) -> None:
    path = write_humble_database(tmp_path / "run.db3", drive(DRIVEN, Robot(HUMBLE)))
    path.write_bytes(path.read_bytes().replace(b"nav_msgs/msg/Odometry", b"our_msgs/msg/Odometry"))
    options = parse_bag_options(fields=["yaw=/odom.heading", "x=0", "y=0"])
    with pytest.raises(InputError, match="messages of type our_msgs/msg/Odometry on /odom are not defined in the bag"):
        read_bag(path, options)


def test_a_type_that_is_not_read_need_not_be_defined(tmp_path: Path) -> None:
    path = write_humble_database(
        tmp_path / "run.db3",
        [*drive(DRIVEN, Robot(HUMBLE)), Sent("/clock", NOON_NS, Robot(HUMBLE).header("", NOON_NS))],
    )
    path.write_bytes(path.read_bytes().replace(b"std_msgs/msg/Header", b"our_msgs/msg/Header"))
    assert len(read_bag(path)) == 2


def test_without_rosbags_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = WRITTEN["run.mcap"](tmp_path / "run.mcap")
    imported = builtins.__import__

    def without_rosbags(name: str, *rest: Any, **more: Any) -> Any:
        if name.startswith("rosbags"):
            raise ModuleNotFoundError(name)
        return imported(name, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", without_rosbags)
    with pytest.raises(MissingExtraError, match=r"rosbags is not installed; install it with: pip install rosbags"):
        read_bag(path)
