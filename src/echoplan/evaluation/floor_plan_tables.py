"""Scores of floor plans as tables of text."""

from collections.abc import Mapping
from math import isnan

from echoplan.evaluation.floor_plan import FloorPlanScore
from echoplan.evaluation.intervals import IntervalErrors
from echoplan.model import Table

__all__ = ["floor_plan_tables"]


def floor_plan_tables(scores: Mapping[str, FloorPlanScore], *, rows: str) -> tuple[Table, ...]:
    """Lay out how much of the walls is drawn, where walls end, and which openings are found.

    Parameters
    ----------
    scores : mapping of str to FloorPlanScore
        By the name of the row.
    rows : str
        What the rows are: head of the first column.

    Returns
    -------
    tuple of Table
        One table of walls, and one of openings if there is any, true or drawn.
    """
    walls = Table(
        title="Wall lengths, and errors of wall ends",
        columns=(rows, "recall (%)", "precision (%)", "walked through", "ends (mm)", "bias (mm)", "inside 95 % (%)"),
        rows=tuple(
            (
                name,
                _percent(score.lengths.recall),
                _percent(score.lengths.precision),
                str(score.lengths.walked_through),
                *_errors(score.wall_ends),
            )
            for name, score in scores.items()
        ),
    )
    openings = Table(
        title="Openings, and errors of their widths",
        columns=(rows, "wanted", "recall (%)", "precision (%)", "width (mm)", "bias (mm)", "inside 95 % (%)"),
        rows=tuple(
            (
                name,
                str(score.openings.wanted),
                _percent(score.openings.recall),
                _percent(score.openings.precision),
                *_errors(score.opening_widths),
            )
            for name, score in scores.items()
        ),
    )
    is_any = any(score.openings.wanted or score.openings.estimates for score in scores.values())
    return (walls, openings) if is_any else (walls,)


def _errors(errors: IntervalErrors) -> tuple[str, ...]:
    return (_number(1000 * errors.mean), _number(1000 * errors.bias), _percent(errors.share_inside))


def _percent(share: float) -> str:
    return _number(100 * share)


def _number(value: float) -> str:
    return "-" if isnan(value) else f"{value:.1f}"
