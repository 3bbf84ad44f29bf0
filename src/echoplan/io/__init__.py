"""Formats: ``read_*`` beside ``write_*``, one file a format, each described in ``docs/formats.md``."""

from echoplan.io.array_file import read_arrays, write_arrays
from echoplan.io.builtin import (
    builtin_rig,
    builtin_route,
    builtin_world,
    rig_names,
    route_names,
    world_names,
)
from echoplan.io.dxf import write_dxf
from echoplan.io.feature_map import read_map, write_map
from echoplan.io.files import check_folder, read_text, write_bytes, write_text, written_whole
from echoplan.io.geojson import write_geojson
from echoplan.io.grid_map import read_grid, write_grid
from echoplan.io.localisation import write_localisation
from echoplan.io.recorder import Recorder
from echoplan.io.recording import RecordingFolder, read_recording, write_recording
from echoplan.io.rig import format_rig, read_conventions, read_rig, write_rig
from echoplan.io.route import read_route, write_route
from echoplan.io.trajectory import read_trajectory, write_trajectory
from echoplan.io.truth import read_truth, write_truth
from echoplan.io.world import read_world, write_world

__all__ = [
    "Recorder",
    "RecordingFolder",
    "builtin_rig",
    "builtin_route",
    "builtin_world",
    "check_folder",
    "format_rig",
    "read_arrays",
    "read_conventions",
    "read_grid",
    "read_map",
    "read_recording",
    "read_rig",
    "read_route",
    "read_text",
    "read_trajectory",
    "read_truth",
    "read_world",
    "rig_names",
    "route_names",
    "world_names",
    "write_arrays",
    "write_bytes",
    "write_dxf",
    "write_geojson",
    "write_grid",
    "write_localisation",
    "write_map",
    "write_recording",
    "write_rig",
    "write_route",
    "write_text",
    "write_trajectory",
    "write_truth",
    "write_world",
    "written_whole",
]
