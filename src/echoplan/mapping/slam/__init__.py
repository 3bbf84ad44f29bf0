"""Simultaneous localisation and mapping by an extended Kalman filter."""

from echoplan.mapping.slam.beliefs import Belief, Innovation
from echoplan.mapping.slam.filter import Landmark, Slam, SlamSettings
from echoplan.mapping.slam.landmarks import CIRCLE, LINE, Expectation, Shape, expect_circle, expect_line
from echoplan.mapping.slam.motion import MotionSettings, moved

__all__ = [
    "CIRCLE",
    "LINE",
    "Belief",
    "Expectation",
    "Innovation",
    "Landmark",
    "MotionSettings",
    "Shape",
    "Slam",
    "SlamSettings",
    "expect_circle",
    "expect_line",
    "moved",
]
