"""The result of mapping one source."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path

import numpy as np
from pydantic import BaseModel

from echoplan.arrays import FloatArray, IntArray
from echoplan.config import Run
from echoplan.errors import InvalidValueError
from echoplan.evaluation import Evaluation, EvaluationSettings, evaluate
from echoplan.io.truth import as_truth
from echoplan.mapping.exports import Exportable, export_formats, export_map
from echoplan.mapping.folder import GRID, RESULTS, results_folder
from echoplan.mapping.start import PRIOR, StartingMap
from echoplan.model import (
    Corner,
    Cylinder,
    FeatureMap,
    OccupancyGrid,
    Opening,
    Quality,
    Rig,
    Sweep,
    Truth,
    Wall,
)
from echoplan.viewer import Definitions, Plan, Section, plan_svg

__all__ = ["MapResult"]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class MapResult:
    """A map with the recording that it was made of, the settings of the run and what a report says about both.

    Parameters
    ----------
    title : str
        Title of the report.
    run : Run
        Source, method, seed and version.
    settings : mapping of str to BaseModel
        Settings of the stages by the name of their table.
    plan : Plan
        The map, and what can be drawn beneath it.
    rig : Rig
        Sensors that made the recording.
    sweeps : tuple of Sweep
        The recording as it was mapped, without readings of faulty sensors.
    decisions : Definitions
        Why each landmark is in the map or not; empty for methods that do not record it.
    sections : tuple of Section, optional
        What else the report says, before the tables of the evaluation.
    grid : OccupancyGrid, optional
        The grid of a method that maps on one.
    known : StartingMap, optional
        What another recording needs to go on from the map, if its method can.
    """

    title: str
    run: Run
    settings: Mapping[str, BaseModel]
    plan: Plan
    rig: Rig
    sweeps: tuple[Sweep, ...]
    decisions: Definitions = field(default_factory=lambda: Definitions(title="Why", items=()))
    sections: tuple[Section, ...] = ()
    grid: OccupancyGrid | None = None
    known: StartingMap | None = None

    @property
    def feature_map(self) -> FeatureMap:
        """The map itself."""
        return self.plan.feature_map

    @property
    def walls(self) -> tuple[Wall, ...]:
        """Walls of the map."""
        return self.feature_map.walls

    @property
    def openings(self) -> tuple[Opening, ...]:
        """Doorways and other gaps between walls."""
        return self.feature_map.openings

    @property
    def corners(self) -> tuple[Corner, ...]:
        """Corners of the map."""
        return self.feature_map.corners

    @property
    def cylinders(self) -> tuple[Cylinder, ...]:
        """Cylinders of the map."""
        return self.feature_map.cylinders

    @property
    def poses(self) -> FloatArray:
        """Pose of each mapped sweep [m, m, rad], shape (s, 3); corrected where the method corrects poses."""
        return self.feature_map.poses

    @property
    def quality(self) -> Quality | None:
        """Whether the map can be trusted, and if not, why and what to do."""
        return self.feature_map.quality

    @property
    def stamps_ns(self) -> IntArray:
        """When the robot was at each pose [ns], shape (s,)."""
        stamps = {sweep.index: sweep.station_ns for sweep in self.sweeps if len(sweep)}
        return np.array([stamps[index] for index in self.feature_map.sweeps.tolist()], dtype=np.int64)

    @property
    def exportable(self) -> Exportable:
        """What the export formats are made of."""
        return Exportable(
            plan=self.plan,
            name=self.title,
            rig=self.rig,
            sweeps=self.sweeps,
            stamps_ns=self.stamps_ns,
            grid=self.grid,
        )

    def save(self, folder: str | PathLike[str], *, export: str | Sequence[str] = ()) -> tuple[str, ...]:
        """Write ``map.json``, ``map.svg``, ``report.html``, ``trajectory.tum`` and ``run.toml``; all or none.

        A map of joint has a ``prior.npz``, too, with which the map of another recording can go on from it.

        Parameters
        ----------
        folder : str or Path
            Where to; it is made if it does not exist.  Files of an earlier run that this one does not make go.
        export : str or sequence of str, optional
            Names of further formats, keys of ``EXPORTS``, as in ``"pdf"``, ``"nav2,dxf"`` or ``["nav2", "dxf"]``.

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
        exports = export_formats(export)
        with results_folder(Path(folder), self, exports=exports):
            pass
        made = (*(() if self.known is None else (PRIOR,)), *(() if self.grid is None else GRID))
        return tuple(dict.fromkeys([*RESULTS, *made, *(name for each in exports for name in each.files)]))

    def export(self, path: str | PathLike[str]) -> None:
        """Write the map in the format that the suffix of a file names.

        Parameters
        ----------
        path : str or Path
            ``plan.pdf``, ``plan.png``, ``map.dxf``, ``map.geojson``, ``map.yaml`` (for Nav2) or ``map.mcap``.

        Raises
        ------
        OutputError
            If the file cannot be written.
        InputError
            If no format has this suffix.
        MissingExtraError
            If the package that writes the format is not installed.
        """
        export_map(path, self.exportable)

    def evaluate(
        self, truth: Truth | str | PathLike[str] | None = None, *, settings: EvaluationSettings | None = None
    ) -> Evaluation:
        """Compare the map with ground truth.

        Parameters
        ----------
        truth : Truth or str or Path, optional
            The truth, or a ``truth.json``; by default that of the recording.
        settings : EvaluationSettings, optional
            How to match and what counts.

        Returns
        -------
        Evaluation
            Recall, precision, errors and consistency.

        Raises
        ------
        InvalidValueError
            If no truth is given and the recording has none.
        """
        truth = self.plan.truth if truth is None else as_truth(truth)
        if truth is None:
            raise InvalidValueError("the recording has no ground truth: pass truth=")
        return evaluate(self.feature_map, truth, settings)

    def _repr_svg_(self) -> str:
        """Draw the map in a notebook."""
        return plan_svg(self.plan)
