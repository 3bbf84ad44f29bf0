"""Bags of ROS 1 and ROS 2, read and written through rosbags (the extra ``ros``)."""

from echoplan.io.ros.bag import is_bag
from echoplan.io.ros.map_bag import write_map_bag
from echoplan.io.ros.options import BagOptions, Field, Mount, parse_bag_options
from echoplan.io.ros.recording import read_bag
from echoplan.io.ros.summary import BagSensor, BagSummary, BagTopic, summarise_bag

__all__ = [
    "BagOptions",
    "BagSensor",
    "BagSummary",
    "BagTopic",
    "Field",
    "Mount",
    "is_bag",
    "parse_bag_options",
    "read_bag",
    "summarise_bag",
    "write_map_bag",
]
