"""Trials in processes of their own."""

import math
import os
from typing import Any, cast

import pytest

from echoplan.comparison import Subject, Trial, measure, run_trials
from echoplan.evaluation import evaluate
from echoplan.io import builtin_rig, builtin_route, builtin_world
from echoplan.methods import find_method, map_sweeps
from echoplan.model import Recording, Truth
from echoplan.simulation import Simulation
from helpers.outcomes import subject
from helpers.scenes import rig, sweep_of


class Deadly:
    """Ends the process that unpickles it."""

    def __reduce__(self) -> tuple[Any, ...]:
        return os._exit, (3,)


@pytest.fixture(scope="module")
def square() -> Subject:
    made = Simulation(world=builtin_world("square"), rig=builtin_rig("rotary-array"), route=builtin_route("square"))
    return Subject(
        name="sim:square", recording=Recording(name="square", rig=made.rig, sweeps=tuple(made)), truth=made.truth
    )


def test_a_trial_gives_the_map_of_the_method_and_its_evaluation(square: Subject) -> None:
    outcome = measure(Trial(subject=square, method="rcd"))
    alone = map_sweeps(find_method("rcd").build(square.recording.rig), square.recording)
    assert square.truth is not None
    assert outcome.evaluation is not None
    assert outcome.evaluation.matches.walls.tally == evaluate(alone, square.truth).matches.walls.tally
    assert outcome.seconds > 0.0


def test_a_grid_is_kept_and_scored_where_a_method_draws_one(square: Subject) -> None:
    drawn, none = (measure(Trial(subject=square, method=name)) for name in ("grid-range-layer", "rcd"))
    assert (none.grid, none.grid_score) == (None, None)
    assert drawn.grid is not None
    assert drawn.grid_score is not None
    assert 0.0 < drawn.grid_score.free < 0.5 < drawn.grid_score.occupied < 1.0


def test_a_process_reports_the_memory_that_it_needed(square: Subject) -> None:
    memory = measure(Trial(subject=square, method="rcd")).peak_memory
    assert math.isnan(memory) or 2e7 < memory < 8e9


def test_one_that_fails_and_one_that_dies_leave_the_others_alone(square: Subject) -> None:
    strange = Recording(name="strange", rig=rig(sensors=2), sweeps=(sweep_of(square.recording.sweeps[0].ranges[:360]),))
    trials = [
        Trial(subject=Subject(name="strange", recording=strange), method="rcd"),
        Trial(subject=subject("deadly", truth=cast("Truth", Deadly())), method="rcd"),
        Trial(subject=square, method="rcd"),
    ]
    outcomes = {outcome.trial.subject.name: outcome for outcome in run_trials(trials, workers=2)}
    assert outcomes["strange"].failure.startswith("UnknownNameError: unknown sensor id '2'")
    assert outcomes["deadly"].failure.startswith("BrokenProcessPool: ")
    assert "\n" not in outcomes["deadly"].failure
    assert outcomes["sim:square"].feature_map is not None
