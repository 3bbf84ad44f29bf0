"""Bags on the command line: what ``echoplan info`` shows of them, and the options of all commands."""

import json
import sys
from pathlib import Path

import pytest

from echoplan.cli.main import main
from helpers.bags import Robot, drive, recorded_by, ring, write_mcap

ROBOT = Robot()
DATA = Path(__file__).parents[3] / ".." / "shared" / "data"


def run(words: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> tuple[int, str, str]:
    monkeypatch.setattr(sys, "argv", ["echoplan", *words])
    with pytest.raises(SystemExit) as ended:
        main()
    out, err = capsys.readouterr()
    assert isinstance(ended.value.code, int)
    return ended.value.code, out, err


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    return write_mcap(tmp_path / "run.mcap", drive(recorded_by(ring()), ROBOT))


def test_info_shows_topics_sensors_and_readings_of_a_bag(
    bag: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    status, out, err = run(["info", str(bag)], monkeypatch, capsys)
    assert (status, err) == (0, "")
    lines = [line.split() for line in out.splitlines()]
    assert ["/odom", "nav_msgs/msg/Odometry", "20", "49.5", "odom", ">", "base_link"] in lines
    assert ["1", "/sonar_1", "sonar_1", "5", "28.6", "0.02", "to", "4.00", "0.000", "0.100", "90.0", "fixed"] in lines
    assert "Poses of the robot: /odom" in out
    assert "run.mcap: 5 sweeps, 20 pings" in out


def test_info_shows_a_bag_that_cannot_be_mapped_and_what_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    sent = [each for each in drive(recorded_by(ring()), ROBOT) if each.topic.startswith("/sonar")]
    bag = str(write_mcap(tmp_path / "run.mcap", sent))
    status, out, err = run(["info", bag], monkeypatch, capsys)
    assert (status, err) == (0, "")
    assert ["3", "/sonar_3", "sonar_3", "5", "28.6", "0.02", "to", "4.00", "-", "-", "-", "fixed"] in [
        line.split() for line in out.splitlines()
    ]
    assert "Missing for a map: /sonar_0: there is no transform from base_link to sonar_0; record /tf_static" in out
    assert "Missing for a map: it has no poses of the robot: no nav_msgs/Odometry" in out
    status, out, err = run(["info", bag, "--json"], monkeypatch, capsys)
    document = json.loads(out)["bag"]
    assert (len(document["topics"]), len(document["sensors"]), len(document["missing"])) == (4, 4, 2)
    assert document["sensors"][0]["x"] is None
    status, out, err = run(["map", bag, "--out", str(tmp_path / "map")], monkeypatch, capsys)
    assert (status, out) == (2, "")
    assert "it has no poses of the robot" in err
    assert not (tmp_path / "map").exists()


def test_options_of_bags_reach_every_command(
    bag: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    options = ["--topic", "/sonar_[01]", "--odom", "/odom", "--mount", "sonar_0=0.2,0,0", "--field", "max_range=1.1"]
    status, out, _ = run(["info", str(bag), *options, "--json"], monkeypatch, capsys)
    document = json.loads(out)
    assert [sensor["x"] for sensor in document["bag"]["sensors"]] == pytest.approx([0.2, 0.0])
    assert document["notes"] == ["5 of 10 readings are max_range or more and mean no echo."]
    for words in (
        ["map", str(bag), "--method", "grid-bayes", "--out", str(tmp_path / "map"), *options],
        ["compare", str(bag), "--methods", "grid-bayes", "--jobs", "1", *options],
    ):
        status, out, _ = run(words, monkeypatch, capsys)
        assert status == 0
        assert "Note: 5 of 10 readings are max_range or more and mean no echo." in out


def test_options_of_bags_are_refused_for_other_sources(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    status, _, err = run(["info", "sim:square", "--topic", "/sonar"], monkeypatch, capsys)
    assert (status, err) == (
        2,
        "echoplan: sim:square: it is no ROS bag; leave out --topic, --odom, --field and --mount\n",
    )


@pytest.mark.parametrize(
    ("name", "missing"),
    [
        ("bags/sonar.bag", "it has no poses of the robot"),
        ("bags/scan_lidar.bag", "no topic has ranges of sonar (sensor_msgs/Range); it has /scan"),
        ("bags/odometry.bag", "no topic has ranges of sonar (sensor_msgs/Range); it has /mobile_base_controller/odom"),
        ("real/Lvl_1_Room_Map_4.bag", "it has /fusion (imu_driver/msg/ImuEcho)"),
        ("real/Lvl_1_Room_Map_4.bag", "Fields that may be ranges, to be named with --field range=: /fusion.range\n"),
    ],
)
def test_bags_of_others_are_shown_with_what_is_missing(
    name: str, missing: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    if not (DATA / name).exists():
        pytest.skip(f"the bag {name} is not here")
    status, out, err = run(["info", str(DATA / name)], monkeypatch, capsys)
    assert (status, err) == (0, "")
    assert missing in out


def test_a_bag_of_another_robot_is_mapped_once_its_sensors_are_mounted(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    if not (DATA / "bags" / "sonar.bag").exists():
        pytest.skip("the bag sonar.bag is not here")
    mounts = [f"--mount=base_sonar_0{number}_link=0.2,0,{yaw}" for number, yaw in ((1, 0.5), (2, 0), (3, -0.5))]
    still = [f"--field={name}=0" for name in ("x", "y", "yaw")]
    status, out, _ = run(["info", str(DATA / "bags" / "sonar.bag"), *mounts, *still], monkeypatch, capsys)
    assert status == 0
    assert "Note: 442 of 609 readings are max_range or more and mean no echo." in out
    assert "sonar.bag: 203 sweeps, 609 pings" in out
