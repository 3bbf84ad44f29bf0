"""The values that flow through echoplan: frozen, checked, with read-only arrays."""

from echoplan.model.features import (
    ClassProbabilities,
    Corner,
    CornerKind,
    Cylinder,
    FeatureClass,
    FeatureMap,
    Opening,
    UnobservedStretch,
    Wall,
)
from echoplan.model.grid import OccupancyGrid
from echoplan.model.odometry import Odometry
from echoplan.model.rig import Firing, Rig, Servo
from echoplan.model.sensor import Sensor, Transducer
from echoplan.model.sweep import Pings, Recording, Source, Sweep
from echoplan.model.table import Table
from echoplan.model.translation import translated, translated_wall
from echoplan.model.world import EVERYWHERE, Pillar, Polyline, Route, Truth, World

__all__ = [
    "EVERYWHERE",
    "ClassProbabilities",
    "Corner",
    "CornerKind",
    "Cylinder",
    "FeatureClass",
    "FeatureMap",
    "Firing",
    "OccupancyGrid",
    "Odometry",
    "Opening",
    "Pillar",
    "Pings",
    "Polyline",
    "Recording",
    "Rig",
    "Route",
    "Sensor",
    "Servo",
    "Source",
    "Sweep",
    "Table",
    "Transducer",
    "Truth",
    "UnobservedStretch",
    "Wall",
    "World",
    "translated",
    "translated_wall",
]
