"""Addresses of a running ROS 2 are understood, or refused in one line."""

import pytest

from echoplan.errors import InputError, UnknownNameError
from echoplan.io.ros.wire import Middleware, is_address, parse_address
from echoplan.io.ros.wire.transport import type_from_wire, type_on_wire


def test_without_anything_it_is_dds_in_the_domain_of_the_environment() -> None:
    found = parse_address("ros2://", environment={"ROS_DOMAIN_ID": "7"})
    assert (found.middleware, found.domain, found.host, found.wait) == (Middleware.DDS, 7, "", 10.0)
    assert parse_address("ros2://", environment={"ROS_DOMAIN_ID": ""}).domain == 0


def test_the_domain_of_the_address_comes_first() -> None:
    assert parse_address("ros2://?domain=5&wait=60", environment={"ROS_DOMAIN_ID": "7"}).domain == 5


def test_a_router_of_zenoh_has_a_host_and_a_port() -> None:
    own, other = parse_address("ros2+zenoh://"), parse_address("ros2+zenoh://robot.local:7450")
    assert (own.middleware, own.host, own.port) == (Middleware.ZENOH, "localhost", 7447)
    assert (other.host, other.port) == ("robot.local", 7450)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("ros2:", "it is not the address of a ROS 2; write for example"),
        ("ros2://robot/odom", "it is not the address of a ROS 2"),
        ("ros2://robot:7447", "DDS computes its ports from the domain; leave out :7447"),
        ("ros2+zenoh://robot:http", "its host or port cannot be"),
        ("ros2://?domain=233", "domain: '233' is not a whole number from 0 to 232"),
        ("ros2://?wait=soon", "wait: 'soon' is not a whole number"),
        ("ros2://?domain=", "domain: '' is not"),
    ],
)
def test_what_cannot_be_is_refused_with_a_remedy(text: str, problem: str) -> None:
    with pytest.raises(InputError, match=problem.replace("'", "'")):
        parse_address(text, environment={})


def test_an_unknown_option_is_refused_with_those_that_there_are() -> None:
    with pytest.raises(UnknownNameError, match=r"option of ros2:// 'domian'; did you mean 'domain'"):
        parse_address("ros2://?domian=5", environment={})


def test_a_wrong_domain_in_the_environment_is_named() -> None:
    with pytest.raises(InputError, match="ROS_DOMAIN_ID: 'five' is not a whole number"):
        parse_address("ros2://", environment={"ROS_DOMAIN_ID": "five"})


def test_files_and_devices_are_no_addresses_of_ros() -> None:
    assert not any(map(is_address, ["ros2", "run.mcap", "tcp://robot:4000", "ros2/run.mcap"]))


def test_types_on_the_wire_are_those_of_ros() -> None:
    assert type_on_wire("sensor_msgs/msg/Range") == "sensor_msgs::msg::dds_::Range_"
    assert type_from_wire("sensor_msgs::msg::dds_::Range_") == "sensor_msgs/msg/Range"
    assert [type_from_wire(each) for each in ("Square", "shapes::Square", "")] == ["", "", ""]


def test_the_address_of_a_router_may_be_ipv6() -> None:
    address = parse_address("ros2+zenoh://[::1]:7448", environment={})
    assert (address.host, address.port, address.endpoint) == ("::1", 7448, "[::1]:7448")
    assert address.is_local
    assert parse_address("ros2+zenoh://robot", environment={}).endpoint == "robot:7447"
