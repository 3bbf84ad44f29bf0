"""Outcomes of trials by hand, for tests."""

import numpy as np

from echoplan.comparison import Outcome, Subject, Trial
from echoplan.evaluation import GridScore, evaluate
from echoplan.model import FeatureMap, Recording, Truth
from helpers.maps import ROOM, drawn, wall
from helpers.scenes import rig, sweep_of

GRID_SCORE = GridScore(occupied=0.2, free=0.05, occupied_cells=10, free_cells=30)
WALLS = [wall(start, end) for start, end in ROOM.walls_xy]


def subject(name: str = "sim:room", *, truth: Truth | None = ROOM) -> Subject:
    """A recording of one sweep of 360 pings."""
    sweeps = (sweep_of(np.full(360, 1.5)),)
    return Subject(name=name, recording=Recording(name="room", rig=rig(), sweeps=sweeps), truth=truth)


def mapped(
    method: str, found: FeatureMap, *, of: Subject, seconds: float = 0.36, grid_score: GridScore | None = None
) -> Outcome:
    """A trial that gave a map."""
    return Outcome(
        trial=Trial(subject=of, method=method),
        feature_map=found,
        evaluation=None if of.truth is None else evaluate(found, of.truth),
        grid_score=grid_score,
        seconds=seconds,
        peak_memory=5e7,
    )


def failed(method: str, reason: str, *, of: Subject) -> Outcome:
    """A trial that gave none."""
    return Outcome(trial=Trial(subject=of, method=method), failure=reason)


def some(truth: Truth | None = ROOM) -> list[Outcome]:
    """Two methods on two recordings: one has a grid and is all right, the other has half the walls and fails once."""
    first, second = subject("sim:room", truth=truth), subject("rec/<two>", truth=truth)
    grid = GRID_SCORE if truth else None
    return [
        mapped("good", drawn(*WALLS, poses=[[1.0, 1.0, 0.0]]), of=first, grid_score=grid),
        mapped("poor", drawn(*WALLS[:3], poses=[[1.0, 1.0, 0.0]]), of=first, seconds=0.72),
        mapped("good", drawn(*WALLS, poses=[[1.0, 1.0, 0.0]]), of=second, grid_score=grid),
        failed("poor", "ValueError: no <walls>", of=second),
    ]
