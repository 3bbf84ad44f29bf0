"""Evaluations as tables of text, ready for a terminal or a document."""

from collections.abc import Callable, Mapping
from math import degrees, isnan, nan
from typing import TypeVar

from echoplan.arrays import IntArray
from echoplan.evaluation.bootstrap import Distribution
from echoplan.evaluation.confusion import MAP_CLASSES, TRUE_CLASSES
from echoplan.evaluation.consistency import Consistency
from echoplan.evaluation.deviations import deviations
from echoplan.evaluation.matches import CylinderMatch, Match, Matching, WallMatch
from echoplan.evaluation.summary import ErrorSummary
from echoplan.evaluation.tally import Tally
from echoplan.model import EVERYWHERE, FeatureClass, Table

__all__ = [
    "confusion_table",
    "consistency_table",
    "cylinder_table",
    "deviation_table",
    "tally_table",
    "wall_table",
]

Kind = TypeVar("Kind", bound=Match)

_UNKNOWN = "-"


def wall_table(matching: Matching[WallMatch]) -> Table:
    """Return the table of the deviations of walls (Table 5 of the paper).

    Parameters
    ----------
    matching : Matching of WallMatch
        The walls of one map.

    Returns
    -------
    Table
        A row for each true wall, with dashes where the map lacks it.
    """
    return Table(
        title="Accuracy of the walls",
        columns=("true wall", "distance deviation (mm)", "angle deviation (°)", "stations"),
        rows=_by_object(matching, lambda match: (_millimetres(match.distance), _degrees(match.angle))),
    )


def cylinder_table(matching: Matching[CylinderMatch]) -> Table:
    """Return the table of the deviations of cylinders.

    Parameters
    ----------
    matching : Matching of CylinderMatch
        The cylinders of one map.

    Returns
    -------
    Table
        A row for each true cylinder, with dashes where the map lacks it.
    """
    return Table(
        title="Accuracy of the cylinders",
        columns=("true cylinder", "centre deviation (mm)", "radius deviation (mm)", "stations"),
        rows=_by_object(matching, lambda match: (_millimetres(match.distance), _millimetres(match.radius_error))),
    )


def tally_table(tallies: Mapping[FeatureClass, Tally]) -> Table:
    """Return the table of recall and precision by class.

    Parameters
    ----------
    tallies : mapping of FeatureClass to Tally
        The counts.

    Returns
    -------
    Table
        A row for each class.
    """
    return Table(
        title="Recall and precision",
        columns=("class", "wanted", "found", "recall (%)", "right", "duplicate", "spurious", "precision (%)"),
        rows=tuple(
            (
                name,
                str(tally.wanted),
                str(tally.found),
                _percent(tally.recall),
                str(tally.right),
                str(tally.duplicate),
                str(tally.spurious),
                _percent(tally.precision),
            )
            for name, tally in tallies.items()
        ),
    )


def confusion_table(confusion: IntArray) -> Table:
    """Return the confusion matrix of the classes as a table.

    Parameters
    ----------
    confusion : ndarray of int, shape (4, 4)
        As ``confusion_matrix`` gives it.

    Returns
    -------
    Table
        A row for each true class, a column for each class in the map.
    """
    return Table(
        title="Classification",
        columns=("in truth", *(f"{name} in map" for name in MAP_CLASSES[:-1]), MAP_CLASSES[-1]),
        rows=tuple((name, *map(str, row)) for name, row in zip(TRUE_CLASSES, confusion.tolist(), strict=True)),
    )


def consistency_table(consistencies: Mapping[FeatureClass, Consistency]) -> Table:
    """Return whether the covariances are as great as the errors.

    Parameters
    ----------
    consistencies : mapping of FeatureClass to Consistency
        Errors against covariances.

    Returns
    -------
    Table
        A row for each class, and one for all of them.
    """
    rows = [(name, *_consistency(each)) for name, each in consistencies.items()]
    count = sum(len(each.nees) for each in consistencies.values())
    inside = sum(each.inside for each in consistencies.values())
    # NEES of different numbers of parameters have no common expected mean.
    total = ("all", str(count), *3 * (_UNKNOWN,), _percent(inside / count if count else nan))
    return Table(
        title="Consistency",
        columns=("class", "count", "mean NEES", "ideal", "accepted", "inside 95 % (%)"),
        rows=(*rows, total),
    )


def deviation_table(summary: ErrorSummary) -> Table:
    """Return the table of the mean errors of several maps.

    Parameters
    ----------
    summary : ErrorSummary
        The maps together.

    Returns
    -------
    Table
        A row for each kind of deviation, with confidence intervals in brackets.
    """
    walls, corners, cylinders = (summary.classes[name].distance for name in FeatureClass)
    kinds = (
        ("wall distance (mm)", walls, _millimetres),
        ("wall angle (°)", summary.wall_angle, _degrees),
        ("corner position (mm)", corners, _millimetres),
        ("cylinder centre (mm)", cylinders, _millimetres),
        ("cylinder radius (mm)", summary.cylinder_radius, _millimetres),
        ("outline mean (mm)", summary.map_error, _millimetres),
        ("outline Hausdorff (mm)", summary.hausdorff, _millimetres),
        ("position RMS (mm)", summary.position, _millimetres),
        ("heading RMS (°)", summary.heading, _degrees),
    )
    return Table(
        title="Deviations",
        columns=("deviation", "count", "mean", "median", "95th percentile", "RMS", "maximum"),
        rows=tuple((name, *_distribution(distribution, show)) for name, distribution, show in kinds),
    )


def _by_object(matching: Matching[Kind], cells: Callable[[Kind], tuple[str, str]]) -> tuple[tuple[str, ...], ...]:
    return tuple(
        (
            str(each.index),
            *(cells(each.match) if each.match else (_UNKNOWN, _UNKNOWN)),
            "everywhere" if each.detected_by == EVERYWHERE else str(each.detected_by),
        )
        for each in deviations(matching)
    )


def _consistency(consistency: Consistency) -> tuple[str, ...]:
    low, high = consistency.accepted
    return (
        str(len(consistency.nees)),
        _decimal(consistency.mean),
        str(consistency.parameters),
        _between(low, high, _decimal) or _UNKNOWN,
        _percent(consistency.share_inside),
    )


def _distribution(distribution: Distribution, show: Callable[[float], str]) -> tuple[str, ...]:
    intervals = (distribution.mean, distribution.median, distribution.percentile95, distribution.rms)
    cells = (f"{show(each.value)} {_between(each.low, each.high, show)}".rstrip() for each in intervals)
    return (str(distribution.count), *cells, show(distribution.maximum))


def _between(low: float, high: float, show: Callable[[float], str]) -> str:
    return "" if isnan(low) else f"[{show(low)}, {show(high)}]"


def _millimetres(value: float) -> str:
    return _decimal(1000 * value)


def _degrees(value: float) -> str:
    return _decimal(degrees(value), digits=2)


def _percent(share: float) -> str:
    return _decimal(100 * share)


def _decimal(value: float, *, digits: int = 1) -> str:
    return _UNKNOWN if isnan(value) else f"{value:.{digits}f}"
