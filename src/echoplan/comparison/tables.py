"""Comparisons as tables of text."""

from collections.abc import Sequence
from math import degrees, isnan

from echoplan.comparison.scores import MethodScore
from echoplan.comparison.trials import Outcome
from echoplan.evaluation import floor_plan_tables
from echoplan.model import FeatureClass, Table

__all__ = ["comparison_tables", "failure_table", "score_table"]

_UNKNOWN = "-"
_MEANING = "; percentages are recall / precision, for grids the errors of occupied / free cells"
_COST = ("ms / 1000 pings", "memory (MB)")
_RIGHTNESS = (
    "walls (%)",
    "offset (mm)",
    "angle (°)",
    "corners (%)",
    "cylinders (%)",
    "map error (mm)",
    "grid (%)",
    "poses (mm)",
)


def comparison_tables(scores: Sequence[MethodScore]) -> tuple[Table, ...]:
    """Lay out all that a comparison says.

    Parameters
    ----------
    scores : sequence of MethodScore
        What each method reached.

    Returns
    -------
    tuple of Table
        Scores, walls and openings as on a floor plan, and failures; without those that would be empty.
    """
    plans = {score.method: score.summary.floor_plan for score in scores if score.summary}
    failures = failure_table([outcome for score in scores for outcome in score.outcomes])
    tables = (score_table(scores), *floor_plan_tables(plans, rows="method"), failures)
    return tuple(table for table in tables if table.rows)


def score_table(scores: Sequence[MethodScore]) -> Table:
    """Set methods side by side.

    Parameters
    ----------
    scores : sequence of MethodScore
        What each reached.

    Returns
    -------
    Table
        A row a method: recall / precision of walls, corners and cylinders, mean deviations of the right walls, mean
        map error, mean errors of the occupied / free cells of its grid (Murphy 2000), mean error of the poses, cost.
        Columns that need ground truth are left out where there is none.
    """
    scored = any(score.summary for score in scores)
    return Table(
        title="Methods on the same recordings" + (_MEANING if scored else ""),
        columns=("method", "maps", *(_RIGHTNESS if scored else ()), *_COST),
        rows=tuple(
            (
                score.method,
                f"{score.maps} of {len(score.outcomes)}",
                *(_rightness(score) if scored else ()),
                _number(1000 * score.seconds_per_thousand_pings),
                _number(score.peak_memory / 1e6),
            )
            for score in scores
        ),
    )


def failure_table(outcomes: Sequence[Outcome]) -> Table:
    """List what failed, and why.

    Parameters
    ----------
    outcomes : sequence of Outcome
        Of all trials.

    Returns
    -------
    Table
        A row for each trial without a map.
    """
    return Table(
        title="What failed",
        columns=("method", "recording", "reason"),
        rows=tuple((each.trial.method, each.trial.subject.name, each.failure) for each in outcomes if each.failure),
    )


def _rightness(score: MethodScore) -> tuple[str, ...]:
    summary = score.summary
    if summary is None:
        return (_UNKNOWN,) * len(_RIGHTNESS)
    walls, corners, cylinders = (
        f"{_number(100 * found.recall.value)} / {_number(100 * found.precision.value)}"
        for found in (summary.classes[name] for name in FeatureClass)
    )
    grid = score.grid_score
    cells = _UNKNOWN if grid is None else f"{_number(100 * grid.occupied)} / {_number(100 * grid.free)}"
    return (
        walls,
        _number(1000 * summary.classes[FeatureClass.WALL].distance.mean.value, digits=1),
        _number(degrees(summary.wall_angle.mean.value), digits=2),
        corners,
        cylinders,
        _number(1000 * summary.map_error.mean.value, digits=1),
        cells,
        _number(1000 * summary.position.mean.value),
    )


def _number(value: float, *, digits: int = 0) -> str:
    return _UNKNOWN if isnan(value) else f"{value:.{digits}f}"
