"""Trials: one method on one recording, measured in the process in which it runs."""

from dataclasses import dataclass, field
from math import nan
from pathlib import Path
from time import process_time

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.evaluation import (
    Evaluation,
    EvaluationSettings,
    GridScore,
    MatchingSettings,
    evaluate,
    score_grid,
)
from echoplan.methods import Method, find_method, grid_of, map_sweeps, points_of
from echoplan.model import FeatureMap, OccupancyGrid, Recording, Truth

__all__ = ["Outcome", "Subject", "Trial", "measure"]

_STATUS = Path("/proc/self/status")


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Subject:
    """A recording on which methods are tried.

    Parameters
    ----------
    name : str
        What to call it: as it was named on the command line.
    recording : Recording
        The sweeps.
    truth : Truth, optional
        What a map of it should say; None where it is unknown.
    min_stations : int, optional
        Objects that fewer stations can detect do not count for recall.
    """

    name: str
    recording: Recording
    truth: Truth | None = None
    min_stations: int = MatchingSettings().min_stations

    @property
    def settings(self) -> EvaluationSettings:
        """How maps of it are evaluated."""
        matching = MatchingSettings(min_stations=self.min_stations, opening_reach=_reach(self.recording))
        return EvaluationSettings(matching=matching)

    @property
    def pings(self) -> int:
        """How many pings it holds."""
        return sum(map(len, self.recording))


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Trial:
    """One method on one recording.

    Parameters
    ----------
    subject : Subject
        The recording.
    method : str
        Name of the method.
    """

    subject: Subject
    method: str


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Outcome:
    """The result of a trial.

    Parameters
    ----------
    trial : Trial
        What was tried.
    feature_map : FeatureMap, optional
        The map; None if the method failed.
    evaluation : Evaluation, optional
        Of the map; None if there is no map or no truth.
    points_xy : ndarray, shape (n, 2), optional
        Points of which the method made its map [m]; none if it makes it of something else.
    grid : OccupancyGrid, optional
        What the method drew on cells; None if it draws none.
    grid_score : GridScore, optional
        Of the grid; None if there is no grid or no truth.
    seconds : float, optional
        Processor time for the map [s].
    peak_memory : float, optional
        Most memory that the process ever held [bytes], with Python, its packages and the recording; nan where the
        system does not report it.
    failure : str, optional
        Why there is no map, in one line.
    """

    trial: Trial
    feature_map: FeatureMap | None = None
    evaluation: Evaluation | None = None
    points_xy: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))
    grid: OccupancyGrid | None = None
    grid_score: GridScore | None = None
    seconds: float = nan
    peak_memory: float = nan
    failure: str = ""

    @property
    def seconds_per_thousand_pings(self) -> float:
        """Processor time for a thousand pings [s]; nan without a map or pings."""
        pings = self.trial.subject.pings
        return 1000 * self.seconds / pings if pings else nan


def measure(trial: Trial) -> Outcome:
    """Run a trial in this process.

    Processor time is what a map costs however busy the machine is.  What a method loads and compiles when it is
    used for the first time is not counted: it maps the first sweep once before.

    Parameters
    ----------
    trial : Trial
        What to try.

    Returns
    -------
    Outcome
        The map, its evaluation and what it cost.
    """
    recording, truth = trial.subject.recording, trial.subject.truth
    method = find_method(trial.method)
    _warm_up(method, recording)
    mapper = method.build(recording.rig)
    start = process_time()
    feature_map = map_sweeps(mapper, recording)
    seconds = process_time() - start
    grid = grid_of(mapper)
    return Outcome(
        trial=trial,
        feature_map=feature_map,
        evaluation=None if truth is None else evaluate(feature_map, truth, trial.subject.settings),
        points_xy=points_of(mapper),
        grid=grid,
        grid_score=None if truth is None or grid is None else score_grid(grid, truth, reach=_reach(recording)),
        seconds=seconds,
        peak_memory=_peak_memory(),
    )


def _warm_up(method: Method, recording: Recording) -> None:
    mapper = method.build(recording.rig)
    for sweep in recording.sweeps[:1]:
        mapper.add(sweep)
    mapper.result()


def _reach(recording: Recording) -> float:
    """Maximum range of the sensors [m]."""
    return float(recording.rig.max_ranges.max())


def _peak_memory() -> float:
    """Read the high-water mark of this process's memory where Linux reports it [bytes].

    The portable counter of ``getrusage`` would do more harm than good: a child inherits that of its parent.
    """
    if not _STATUS.exists():
        return nan
    status = dict(line.partition(":")[::2] for line in _STATUS.read_text(encoding="utf-8").splitlines())
    return 1024.0 * int(status["VmHWM"].removesuffix("kB"))
