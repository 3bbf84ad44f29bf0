"""Locate one source in a map that was made before."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from os import PathLike, fspath
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from echoplan.arrays import FloatArray, IntArray, checked_floats
from echoplan.config import Run, write_run
from echoplan.diagnosis import assess_localisation
from echoplan.errors import InputError, InvalidValueError, UnknownNameError
from echoplan.io import read_map, write_localisation, write_text, write_trajectory, written_whole
from echoplan.io.text import names_in
from echoplan.joint.localisation import localise
from echoplan.mapping.exports import Exportable, ExportFormat, export_formats
from echoplan.mapping.progress import SILENT, Progress
from echoplan.model import FeatureMap, Localisation, Quality, Rig, Source, Sweep, Verdict
from echoplan.preprocessing import clean_sweeps, find_faults
from echoplan.sources import as_source
from echoplan.viewer import Plan, plan_svg

__all__ = ["LOCATED", "LocateResult", "locate_source", "located_formats"]

# Export formats that show the path of the robot; floor plans for print do not.
_SHOW_PATHS = ("mcap",)
LOCATED = ("localisation.json", "located.svg", "trajectory.tum", "run.toml")


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class LocateResult:
    """Where a recording was made in a map.

    Parameters
    ----------
    run : Run
        Source and version.
    feature_map : FeatureMap
        The map, with the poses of the recording.
    localisation : Localisation
        The poses, the alternatives to the first one, and how far echoes and map agree.
    quality : Quality
        ``good``, or ``doubtful`` with the reasons and what to do.
    rig : Rig
        Sensors that made the recording.
    sweeps : tuple of Sweep
        The sweeps with pings, without readings of faulty sensors.
    """

    run: Run
    feature_map: FeatureMap
    localisation: Localisation
    quality: Quality
    rig: Rig
    sweeps: tuple[Sweep, ...]

    @property
    def poses(self) -> FloatArray:
        """Pose of each sweep with pings in the frame of the map [m, m, rad], shape (s, 3)."""
        return self.localisation.poses

    @property
    def stamps_ns(self) -> IntArray:
        """When the robot was at each pose [ns], shape (s,)."""
        return np.array([sweep.station_ns for sweep in self.sweeps], dtype=np.int64)

    def save(self, folder: str | PathLike[str], *, export: str | Sequence[str] = ()) -> tuple[str, ...]:
        """Write ``localisation.json``, ``located.svg``, ``trajectory.tum`` and ``run.toml``; all or none.

        Parameters
        ----------
        folder : str or Path
            Where to; it is made if it does not exist.
        export : str or sequence of str, optional
            ``"mcap"`` for ``located.mcap``, which RViz and Foxglove show: grid, markers, path and the transforms from
            ``map`` to ``odom``.

        Returns
        -------
        tuple of str
            Names of the files in the folder.

        Raises
        ------
        OutputError
            If one of them cannot be written.
        UnknownNameError
            If there is no such format.
        MissingExtraError
            If the package that writes a format is not installed.
        """
        formats = located_formats(export)
        names = tuple(f"located{each.suffix}" for each in formats)
        plan = Plan(feature_map=self.feature_map)
        content = Exportable(
            plan=plan, name=self.run.source, rig=self.rig, sweeps=self.sweeps, stamps_ns=self.stamps_ns
        )
        with written_whole(Path(folder)) as draft:
            write_localisation(
                draft / "localisation.json", self.localisation, stamps_ns=self.stamps_ns, quality=self.quality
            )
            write_text(draft / "located.svg", plan_svg(plan))
            write_trajectory(draft / "trajectory.tum", self.stamps_ns, self.poses)
            write_run(draft / "run.toml", self.run, {})
            for each, name in zip(formats, names, strict=True):
                each.write(draft / name, content)
        return (*LOCATED, *names)

    def _repr_svg_(self) -> str:
        """Draw the path in the map in a notebook."""
        return plan_svg(Plan(feature_map=self.feature_map))


def located_formats(names: str | Sequence[str]) -> tuple[ExportFormat, ...]:
    """Find the formats that show a path in a map by their names, and check that their packages are installed.

    Parameters
    ----------
    names : str or sequence of str
        ``"mcap"``, or nothing.

    Returns
    -------
    tuple of ExportFormat
        Each once.

    Raises
    ------
    UnknownNameError
        If there is no such format.
    MissingExtraError
        If the package that writes a format is not installed.
    """
    for name in names_in(names):
        if name not in _SHOW_PATHS:
            raise UnknownNameError("export format of a path", name, known=_SHOW_PATHS)
    return export_formats(names)


def locate_source(
    source: Source | str | PathLike[str],
    feature_map: FeatureMap | str | PathLike[str],
    *,
    start: ArrayLike | None = None,
    name: str | None = None,
    progress: Progress = SILENT,
) -> LocateResult:
    """Find the poses of a recording in a map that was made before.

    Parameters
    ----------
    source : Source or str or Path
        What ``echoplan.open`` returns, or what it takes: a recording's folder, a bag, or ``sim:WORLD``.  Its poses are
        those of odometry, in a frame of their own.
    feature_map : FeatureMap or str or Path
        The map, or a ``map.json`` or its folder.
    start : array_like, shape (3,), optional
        About where the recording begins: x, y and yaw in the frame of the map [m, m, rad], within 0.3 m and 30 degrees.
        Anywhere by default.
    name : str, optional
        How to name the source in the record of the run; by default that of the source.
    progress : Progress, optional
        Shows how far it is; nothing by default.

    Returns
    -------
    LocateResult
        The poses; ``result.quality`` says whether there is a doubt about them.

    Raises
    ------
    InputError
        If the source or the map cannot be used, or if the echoes do not agree with the map.
    InvalidValueError
        If the start is no pose.

    Examples
    --------
    >>> from echoplan.mapping import map_source
    >>> room = map_source("sim:square,seed=1").feature_map
    >>> located = locate_source("sim:square,seed=2", room, start=room.poses[0])
    >>> located.quality.verdict.value, len(located.poses)
    ('good', 5)
    """
    opened = as_source(source)
    name = name or opened.name
    known, map_name = (
        (feature_map, None) if isinstance(feature_map, FeatureMap) else (read_map(feature_map), fspath(feature_map))
    )
    first = None if start is None else checked_floats(start, name="start", shape=(3,))
    recorded = tuple(progress.track(opened, total=len(opened), task="reading"))
    faults = find_faults(recorded, opened.rig)
    if faults.has_no_poses:
        raise InputError(name, "it has no positions", remedy="record the poses of the robot by odometry with it")
    sweeps = tuple(sweep for sweep in clean_sweeps(recorded, opened.rig, faults) if len(sweep))
    try:
        with progress.busy("locating"):
            found = localise(sweeps, known, rig=opened.rig, start=first)
    except InvalidValueError as error:
        remedy = "check that the map is of this place, and the start if one was given"
        raise InputError(name, str(error), remedy=remedy) from None
    quality = assess_localisation(found, known, faults=faults)
    if quality.verdict is Verdict.FAILED:
        problem = quality.reasons[0].rstrip(".")
        raise InputError(name, problem[:1].lower() + problem[1:], remedy=quality.next_step)
    there = replace(
        known,
        quality=quality,
        openings=(),
        unobserved=(),
        sweeps=found.sweeps,
        poses=found.poses,
        pose_covariances=found.covariances,
    )
    return LocateResult(
        run=Run(source=name, method="joint", start=map_name),
        feature_map=there,
        localisation=found,
        quality=quality,
        rig=opened.rig,
        sweeps=sweeps,
    )
