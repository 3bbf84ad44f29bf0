"""The formats in which other software reads a map, by name and by suffix."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from os import PathLike, fspath
from pathlib import Path

import numpy as np

from echoplan.arrays import FloatArray, IntArray
from echoplan.errors import InputError, MissingExtraError, UnknownNameError
from echoplan.grids import grid_from_map
from echoplan.io import write_bytes, write_dxf, write_geojson, write_grid, write_text
from echoplan.io.ros import write_map_bag
from echoplan.io.text import names_in
from echoplan.model import FeatureMap, OccupancyGrid, Rig, Sweep
from echoplan.viewer import Plan, floor_plan_pdf, floor_plan_png, plan_svg

__all__ = ["EXPORTS", "ExportFormat", "Exportable", "export_formats", "export_map"]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Exportable:
    """What the export formats are made of: a map, and the recording behind it where that is at hand.

    Parameters
    ----------
    plan : Plan
        The map.
    name : str, optional
        What it is a map of, for title blocks.
    rig : Rig, optional
        Sensors that made the recording; None for a map that was read from a file.
    sweeps : tuple of Sweep, optional
        The recording; empty for a map that was read from a file.
    stamps_ns : ndarray of int, shape (s,), optional
        When the robot was at each pose of the map [ns]; None if unknown: then poses count as a second apart.
    grid : OccupancyGrid, optional
        The grid of a method that maps on one.
    """

    plan: Plan
    name: str = "Floor plan"
    rig: Rig | None = None
    sweeps: tuple[Sweep, ...] = ()
    stamps_ns: IntArray | None = None
    grid: OccupancyGrid | None = None

    @property
    def feature_map(self) -> FeatureMap:
        """The map itself."""
        return self.plan.feature_map

    @property
    def nav2_grid(self) -> OccupancyGrid:
        """The grid of the method, or one of its features: free where sound or the robot passed."""
        return self.grid or grid_from_map(self.feature_map, rig=self.rig, sweeps=self.sweeps or None)

    @property
    def known_stamps_ns(self) -> IntArray:
        """The stamps, or whole seconds where they are unknown [ns], shape (s,)."""
        seconds = 1_000_000_000 * np.arange(len(self.feature_map.poses))
        return seconds if self.stamps_ns is None else self.stamps_ns

    @property
    def odom_from_base(self) -> FloatArray | None:
        """The recorded pose of each mapped sweep [m, m, rad], shape (s, 3); None without the recording."""
        recorded = {sweep.index: sweep.station for sweep in self.sweeps if len(sweep)}
        return np.array([recorded[index] for index in self.feature_map.sweeps.tolist()]) if recorded else None


@dataclass(frozen=True, slots=True, kw_only=True)
class ExportFormat:
    """A format for other software.

    Parameters
    ----------
    name : str
        What to call it on the command line.
    summary : str
        Who reads it.
    files : tuple of str
        What it writes into a folder of results; the first is the file to open.
    write : callable
        Writes a file of the suffix of the first one, and beside it any others.
    package, extra : str, optional
        Optional package that it needs, and the extra of echoplan that brings it.
    """

    name: str
    summary: str
    files: tuple[str, ...]
    write: Callable[[Path, Exportable], None]
    package: str = ""
    extra: str = ""

    @property
    def suffix(self) -> str:
        """Suffix of the file to open."""
        return Path(self.files[0]).suffix


EXPORTS: Mapping[str, ExportFormat] = {
    each.name: each
    for each in (
        ExportFormat(
            name="nav2",
            summary="occupancy grid for Nav2",
            files=("map.yaml", "map.pgm"),
            write=lambda path, content: write_grid(path, content.nav2_grid),
        ),
        ExportFormat(
            name="dxf",
            summary="drawing for CAD",
            files=("map.dxf",),
            write=lambda path, content: write_dxf(path, content.feature_map),
            package="ezdxf",
            extra="cad",
        ),
        ExportFormat(
            name="geojson",
            summary="features for GIS",
            files=("map.geojson",),
            write=lambda path, content: write_geojson(path, content.feature_map),
        ),
        ExportFormat(
            name="pdf",
            summary="floor plan on paper, to scale",
            files=("floor-plan.pdf",),
            write=lambda path, content: write_bytes(path, floor_plan_pdf(content.plan, name=content.name)),
        ),
        ExportFormat(
            name="png",
            summary="floor plan as a picture",
            files=("floor-plan.png",),
            write=lambda path, content: write_bytes(path, floor_plan_png(content.plan, name=content.name)),
        ),
        ExportFormat(
            name="mcap",
            summary="map and path for RViz and Foxglove",
            files=("map.mcap",),
            write=lambda path, content: write_map_bag(
                path,
                content.feature_map,
                grid=content.nav2_grid,
                times_ns=content.known_stamps_ns,
                odom_from_base=content.odom_from_base,
            ),
            package="rosbags",
            extra="ros",
        ),
        ExportFormat(
            name="svg",
            summary="drawing to scale",
            files=("map.svg",),
            write=lambda path, content: write_text(path, plan_svg(content.plan)),
        ),
    )
}


def export_formats(names: str | Iterable[str]) -> tuple[ExportFormat, ...]:
    """Find export formats by their names, and check that their packages are installed.

    Parameters
    ----------
    names : str or iterable of str
        Keys of ``EXPORTS``, or ``all``; several in one text are separated by commas.

    Returns
    -------
    tuple of ExportFormat
        Each once, in the order given.

    Raises
    ------
    UnknownNameError
        If there is no such format.
    MissingExtraError
        If the package that writes a format is not installed.

    Examples
    --------
    >>> [each.files for each in export_formats(["svg"])]
    [('map.svg',)]
    """
    chosen: dict[str, ExportFormat] = {}
    for name in names_in(names):
        if name != "all" and name not in EXPORTS:
            raise UnknownNameError("export format", name, known=[*EXPORTS, "all"])
        chosen |= EXPORTS if name == "all" else {name: EXPORTS[name]}
    for each in chosen.values():
        if each.package and find_spec(each.package) is None:
            raise MissingExtraError(each.package, extra=each.extra)
    return tuple(chosen.values())


def export_map(path: str | PathLike[str], content: Exportable) -> tuple[str, ...]:
    """Write a map in the format that the suffix of a file names.

    Parameters
    ----------
    path : str or Path
        The file: ``plan.pdf``, ``map.yaml`` and so on.
    content : Exportable
        The map.

    Returns
    -------
    tuple of str
        Names of the files that were written beside each other.

    Raises
    ------
    OutputError
        If the file cannot be written.
    InputError
        If no format has this suffix.
    MissingExtraError
        If the package that writes the format is not installed.
    """
    by_suffix = {each.suffix: each.name for each in EXPORTS.values()} | {".yml": "nav2"}
    suffix = Path(path).suffix.lower()
    if suffix not in by_suffix:
        kinds = ", ".join(sorted(by_suffix))
        problem = f"no format for other software has the suffix {suffix!r}" if suffix else "the name has no suffix"
        raise InputError(
            fspath(path), problem, remedy=f"end it with one of {kinds}; map.json is written by echoplan map"
        )
    (chosen,) = export_formats([by_suffix[suffix]])
    chosen.write(Path(path), content)
    return (Path(path).name, *(Path(path).with_suffix(Path(name).suffix).name for name in chosen.files[1:]))
