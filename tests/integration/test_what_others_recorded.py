"""Every recording and bag of other people is read, or refused in one line with the reason."""

from pathlib import Path

import pytest

from echoplan.errors import InputError
from echoplan.io.ros import parse_bag_options
from echoplan.sources import open_source

DATA = Path(__file__).parents[2] / ".." / "shared" / "data"
FOLDERS = sorted(path.parent for path in DATA.glob("real/*/pings.csv"))
BAGS = {
    "bags/sonar.bag": "it has no poses of the robot",
    "bags/scan_lidar.bag": "no topic has ranges of sonar",
    "bags/odometry.bag": "no topic has ranges of sonar",
    "real/Lvl_1_Room_Map_4.bag": "no topic has ranges of sonar",
}


@pytest.mark.skipif(not FOLDERS, reason="the recordings of others are not here")
@pytest.mark.parametrize("folder", FOLDERS, ids=lambda path: path.name)
def test_a_converted_recording_is_read_to_the_end(folder: Path) -> None:
    recording = open_source(folder)
    assert sum(len(sweep) for sweep in recording) > 100


@pytest.mark.parametrize("name", BAGS)
def test_a_bag_that_says_too_little_is_refused_with_the_reason(name: str) -> None:
    if not (DATA / name).is_file():
        pytest.skip(f"the bag {name} is not here")
    with pytest.raises(InputError, match=BAGS[name]) as refused:
        open_source(DATA / name)
    assert "\n" not in str(refused.value)
    assert refused.value.remedy


def test_a_bag_with_messages_of_its_own_is_read_by_their_fields() -> None:
    bag = DATA / "real" / "Lvl_1_Room_Map_4.bag"
    if not bag.is_file():
        pytest.skip("the bag is not here")
    fields = ["range=/fusion.range*0.001", "servo=/fusion.yaw*-1", "x=0", "y=0", "yaw=0"]
    limits = ["field_of_view=0.7", "min_range=0.3", "max_range=4.99"]
    recording = open_source(bag, bag=parse_bag_options(topics=(), odometry=None, fields=[*fields, *limits], mounts=()))
    assert sum(len(sweep) for sweep in recording) > 100
