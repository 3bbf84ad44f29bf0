"""Floor plans from echoes: maps of walls, corners and cylinders from cheap ultrasonic sensors.

Map a recording, look at the map and save it::

    import echoplan as ep

    recording = ep.open("rec/")            # a recording's folder, a ROS bag, or "sim:two-room-flat"
    result = ep.map(recording)             # method="joint" by default
    print(result.quality.verdict, len(result.walls))
    result.save("map/", export=["pdf", "nav2"])

Map sweeps as they come, from whatever source::

    mapper = ep.JointMapper(recording.rig)
    for sweep in recording:
        mapper.add(sweep)
    feature_map = mapper.result()

What is here
------------
Reading
    open, read_map, read_truth, builtin_rig, find_rig, write_recording
Mapping
    map, locate, METHODS, JointMapper, OnlineMapper, JointSettings
Results
    MapResult, LocateResult, Localisation, FeatureMap, Wall, Opening, Corner, Cylinder, Changes, Quality, Verdict,
    OccupancyGrid
Evaluating
    evaluate, compare, Evaluation, Truth
Simulating
    simulate, Simulation, SimulationSettings
Values that are read
    Source, Recording, Sweep, Rig, Sensor
Errors
    EchoplanError, InputError, InvalidValueError, OutputError, UnknownNameError, MissingExtraError

``help(echoplan.map)`` and the like say more.  Lengths are in metres, angles in radians, times in seconds or, where the
name ends in ``_ns``, in nanoseconds (REP 103).
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from echoplan.api import compare, evaluate, locate, simulate
    from echoplan.api import map as map  # noqa: A004 - echoplan.map reads well, and is lazy
    from echoplan.api import open as open  # noqa: A004 - likewise
    from echoplan.errors import (
        EchoplanError,
        InputError,
        InvalidValueError,
        MissingExtraError,
        OutputError,
        UnknownNameError,
    )
    from echoplan.evaluation import Evaluation
    from echoplan.io import builtin_rig, read_map, read_truth, write_recording
    from echoplan.joint.mapper import JointMapper, JointSettings
    from echoplan.mapping import LocateResult, MapResult
    from echoplan.methods import METHODS
    from echoplan.model import (
        Changes,
        Corner,
        Cylinder,
        FeatureMap,
        Localisation,
        OccupancyGrid,
        Opening,
        Quality,
        Recording,
        Rig,
        Sensor,
        Source,
        Sweep,
        Truth,
        Verdict,
        Wall,
    )
    from echoplan.online import OnlineMapper
    from echoplan.simulation import Simulation, SimulationSettings
    from echoplan.sources import find_rig

from echoplan.version import __version__

__all__ = [
    "METHODS",
    "Changes",
    "Corner",
    "Cylinder",
    "EchoplanError",
    "Evaluation",
    "FeatureMap",
    "InputError",
    "InvalidValueError",
    "JointMapper",
    "JointSettings",
    "Localisation",
    "LocateResult",
    "MapResult",
    "MissingExtraError",
    "OccupancyGrid",
    "OnlineMapper",
    "Opening",
    "OutputError",
    "Quality",
    "Recording",
    "Rig",
    "Sensor",
    "Simulation",
    "SimulationSettings",
    "Source",
    "Sweep",
    "Truth",
    "UnknownNameError",
    "Verdict",
    "Wall",
    "__version__",
    "builtin_rig",
    "compare",
    "evaluate",
    "find_rig",
    "locate",
    "read_map",
    "read_truth",
    "simulate",
    "write_recording",
]

# Modules are imported when one of their names is asked for (PEP 562): `import echoplan` must not wait for NumPy.
_HOMES = {
    "echoplan.api": ("compare", "evaluate", "locate", "map", "open", "simulate"),
    "echoplan.errors": (
        "EchoplanError",
        "InputError",
        "InvalidValueError",
        "MissingExtraError",
        "OutputError",
        "UnknownNameError",
    ),
    "echoplan.evaluation": ("Evaluation",),
    "echoplan.io": ("builtin_rig", "read_map", "read_truth", "write_recording"),
    "echoplan.joint.mapper": ("JointMapper", "JointSettings"),
    "echoplan.mapping": ("LocateResult", "MapResult"),
    "echoplan.methods": ("METHODS",),
    "echoplan.model": (
        "Changes",
        "Corner",
        "Cylinder",
        "FeatureMap",
        "Localisation",
        "OccupancyGrid",
        "Opening",
        "Quality",
        "Recording",
        "Rig",
        "Sensor",
        "Source",
        "Sweep",
        "Truth",
        "Verdict",
        "Wall",
    ),
    "echoplan.online": ("OnlineMapper",),
    "echoplan.simulation": ("Simulation", "SimulationSettings"),
    "echoplan.sources": ("find_rig",),
}
_PUBLIC = {name: home for home, names in _HOMES.items() for name in names}


def __getattr__(name: str) -> object:
    if name not in _PUBLIC:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_PUBLIC[name]), name)


def __dir__() -> list[str]:
    # `from echoplan import *` must not replace the builtins map and open, so these are not in __all__.
    return ["__version__", *_PUBLIC]
