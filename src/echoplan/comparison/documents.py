"""Comparisons as documents: one ready for JSON, and a table as CSV."""

from collections.abc import Callable, Mapping, Sequence
from math import degrees, isfinite, nan
from statistics import fmean
from typing import Any

from echoplan.comparison.scores import MethodScore
from echoplan.comparison.trials import Outcome
from echoplan.evaluation import Evaluation, GridScore, evaluation_document, summary_document
from echoplan.io.text import format_csv
from echoplan.version import __version__

__all__ = ["comparison_csv", "comparison_document"]

_MEGABYTE = 1e6

# Columns that score a map, and a grid.
_SCORES: Mapping[str, Callable[[Evaluation], float]] = {
    "wall_recall": lambda each: each.matches.walls.tally.recall,
    "wall_precision": lambda each: each.matches.walls.tally.precision,
    "wall_offset_mm": lambda each: 1000 * _mean([match.distance for match in each.matches.walls.right]),
    "wall_angle_deg": lambda each: degrees(_mean([match.angle for match in each.matches.walls.right])),
    "corner_recall": lambda each: each.matches.corners.tally.recall,
    "corner_precision": lambda each: each.matches.corners.tally.precision,
    "cylinder_recall": lambda each: each.matches.cylinders.tally.recall,
    "cylinder_precision": lambda each: each.matches.cylinders.tally.precision,
    "map_error_mm": lambda each: 1000 * each.map_error.mean,
    "length_recall": lambda each: each.floor_plan.lengths.recall,
    "length_precision": lambda each: each.floor_plan.lengths.precision,
    "walked_through": lambda each: each.floor_plan.lengths.walked_through,
    "opening_recall": lambda each: each.floor_plan.openings.recall,
    "opening_precision": lambda each: each.floor_plan.openings.precision,
    "opening_width_mm": lambda each: 1000 * each.floor_plan.opening_widths.mean,
    "pose_error_mm": lambda each: 1000 * each.trajectory.absolute_error if each.trajectory else nan,
}

_GRID_SCORES: Mapping[str, Callable[[GridScore], float]] = {
    "grid_error": lambda each: each.error,
    "grid_occupied_error": lambda each: each.occupied,
    "grid_free_error": lambda each: each.free,
}


def comparison_document(scores: Sequence[MethodScore]) -> dict[str, Any]:
    """Write a comparison as plain numbers.

    Parameters
    ----------
    scores : sequence of MethodScore
        What each method reached.

    Returns
    -------
    dict
        ``methods``: name, summary (as ``summary_document``; null without truth), errors of the grid (null without
        one), cost and trials, each with source, evaluation (as ``evaluation_document``), errors of the grid, cost and
        failure (null where there is a map).
    """
    return {
        "format": "echoplan-comparison/1",
        "version": __version__,
        "methods": [
            {
                "method": score.method,
                "summary": summary_document(score.summary) if score.summary else None,
                **_grid_scores(score.grid_score),
                "seconds_per_1000_pings": _known(score.seconds_per_thousand_pings),
                "peak_memory_mb": _known(score.peak_memory / _MEGABYTE),
                "trials": [_trial(outcome) for outcome in score.outcomes],
            }
            for score in scores
        ],
    }


def comparison_csv(scores: Sequence[MethodScore]) -> str:
    """Write a comparison as a table for a spreadsheet: a row for each method and recording.

    Parameters
    ----------
    scores : sequence of MethodScore
        What each method reached.

    Returns
    -------
    str
        Comma-separated values with a head; cells are empty where something is not known.
    """
    rows = [_row(outcome) for score in scores for outcome in score.outcomes]
    return format_csv(rows, columns=list(rows[0]) if rows else [])


def _trial(outcome: Outcome) -> dict[str, Any]:
    return {
        "source": outcome.trial.subject.name,
        "pings": outcome.trial.subject.pings,
        "evaluation": evaluation_document(outcome.evaluation) if outcome.evaluation else None,
        **_grid_scores(outcome.grid_score),
        **_cost(outcome),
        "failure": outcome.failure or None,
    }


def _row(outcome: Outcome) -> Mapping[str, object]:
    evaluation = outcome.evaluation
    return {
        "source": outcome.trial.subject.name,
        "method": outcome.trial.method,
        "pings": outcome.trial.subject.pings,
        **{name: _known(score(evaluation)) if evaluation else None for name, score in _SCORES.items()},
        **_grid_scores(outcome.grid_score),
        **_cost(outcome),
        "failure": outcome.failure,
    }


def _grid_scores(grid: GridScore | None) -> Mapping[str, float | None]:
    return {name: _known(score(grid)) if grid else None for name, score in _GRID_SCORES.items()}


def _cost(outcome: Outcome) -> Mapping[str, float | None]:
    return {
        "seconds_per_1000_pings": _known(outcome.seconds_per_thousand_pings),
        "peak_memory_mb": _known(outcome.peak_memory / _MEGABYTE),
    }


def _mean(values: Sequence[float]) -> float:
    return fmean(values) if values else nan


def _known(value: float) -> float | None:
    return float(value) if isfinite(value) else None
