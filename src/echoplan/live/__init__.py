"""Live: a page in the browser that shows a recording while it is made, with the map growing."""

from echoplan.live.device import DeviceFeed
from echoplan.live.feed import Complete, Control, Event, Feed, Notice, Partial
from echoplan.live.player import Player, SimulationPlayer
from echoplan.live.ros2 import Ros2Feed
from echoplan.live.running import run_live

__all__ = [
    "Complete",
    "Control",
    "DeviceFeed",
    "Event",
    "Feed",
    "Notice",
    "Partial",
    "Player",
    "Ros2Feed",
    "SimulationPlayer",
    "run_live",
]
