"""Simultaneous localisation and mapping by an extended Kalman filter."""

from echoplan.classical.slam.filter import Landmark, Slam, SlamSettings
from echoplan.classical.slam.gaussian_state import GaussianState, Innovation
from echoplan.classical.slam.landmarks import CIRCLE, LINE, Expectation, Shape, expect_circle, expect_line
from echoplan.classical.slam.motion import MotionSettings, moved

__all__ = [
    "CIRCLE",
    "LINE",
    "Expectation",
    "GaussianState",
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
