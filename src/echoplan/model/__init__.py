"""The values that flow through echoplan: frozen, checked, with read-only arrays."""

from echoplan.model.changes import Changes
from echoplan.model.conventions import UNITS, Axes, Conventions, Heading
from echoplan.model.feature_map import FeatureMap
from echoplan.model.features import (
    HALF_OF_95,
    ClassProbabilities,
    Corner,
    CornerKind,
    Cylinder,
    FeatureClass,
    Opening,
    UnobservedStretch,
    Wall,
)
from echoplan.model.grid import OccupancyGrid
from echoplan.model.localisation import Localisation, StartPose, TrajectorySegment
from echoplan.model.odometry import Odometry
from echoplan.model.quality import Quality, Verdict
from echoplan.model.rig import Firing, Rig, Servo
from echoplan.model.sensor import Sensor, Transducer
from echoplan.model.sweep import Pings, Recording, Source, Sweep
from echoplan.model.table import Table
from echoplan.model.translation import translated, translated_wall
from echoplan.model.world import EVERYWHERE, Pillar, Polyline, Route, Truth, World

__all__ = [
    "EVERYWHERE",
    "HALF_OF_95",
    "UNITS",
    "Axes",
    "Changes",
    "ClassProbabilities",
    "Conventions",
    "Corner",
    "CornerKind",
    "Cylinder",
    "FeatureClass",
    "FeatureMap",
    "Firing",
    "Heading",
    "Localisation",
    "OccupancyGrid",
    "Odometry",
    "Opening",
    "Pillar",
    "Pings",
    "Polyline",
    "Quality",
    "Recording",
    "Rig",
    "Route",
    "Sensor",
    "Servo",
    "Source",
    "StartPose",
    "Sweep",
    "Table",
    "TrajectorySegment",
    "Transducer",
    "Truth",
    "UnobservedStretch",
    "Verdict",
    "Wall",
    "World",
    "translated",
    "translated_wall",
]
