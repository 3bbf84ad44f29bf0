"""Tables of scores that several benchmarks print."""

from collections.abc import Iterable, Mapping
from math import degrees

import numpy as np

from echoplan.evaluation import ErrorSummary, Evaluation, Interval, pool
from echoplan.model import FeatureClass, Table

__all__ = ["SCORE_COLUMNS", "fault_table", "percent", "score_row"]

SCORE_COLUMNS = ("recording", "walls", "mm", "deg", "corners", "mm", "cylinders", "mm", "radius mm", "seconds")


def score_row(name: str, evaluations: Iterable[Evaluation], seconds: float) -> tuple[str, ...]:
    """Pool the scores of some maps in one row of a table with ``SCORE_COLUMNS``."""
    summary = pool(evaluations, rng=np.random.default_rng(0))
    walls, corners, cylinders = (FeatureClass.WALL, FeatureClass.CORNER, FeatureClass.CYLINDER)
    return (
        name,
        _shares(summary, walls),
        _number(1000 * summary.classes[walls].distance.mean.value),
        _number(degrees(summary.wall_angle.mean.value), digits=2),
        _shares(summary, corners),
        _number(1000 * summary.classes[corners].distance.mean.value),
        _shares(summary, cylinders),
        _number(1000 * summary.classes[cylinders].distance.mean.value),
        _number(1000 * summary.cylinder_radius.mean.value),
        _number(seconds, digits=2),
    )


def fault_table(outcomes: Mapping[int, Evaluation]) -> Table:
    """List the rooms with missing, false or duplicate features: by seed, the numbers of the features."""
    rows = []
    for seed, evaluation in outcomes.items():
        matchings = evaluation.matches.by_class
        missed = [f"{name} {k}" for name, m in matchings.items() for k in sorted(set(m.wanted) - set(m.found))]
        false = [f"{name} {k}" for name, m in matchings.items() for k in m.spurious]
        twice = [f"{name} {match.truth}" for name, m in matchings.items() for match in m.duplicate]
        if missed or false or twice:
            rows.append((str(seed), *(", ".join(names) or "-" for names in (missed, false, twice))))
    return Table(
        title=f"Rooms with faults: {len(rows)} of {len(outcomes)}",
        columns=("seed", "missed", "false", "twice"),
        rows=tuple(rows),
    )


def percent(interval: Interval) -> str:
    """Write a share and its interval in percent."""
    return f"{100 * interval.value:.1f} [{100 * interval.low:.1f}, {100 * interval.high:.1f}]"


def _shares(summary: ErrorSummary, name: FeatureClass) -> str:
    """Recall and precision of a class in percent."""
    of_class = summary.classes[name]
    return f"{_number(100 * of_class.recall.value, digits=0)} / {_number(100 * of_class.precision.value, digits=0)}"


def _number(value: float, *, digits: int = 1) -> str:
    """Format a number, or a dash where there is none."""
    return "-" if np.isnan(value) else f"{value:.{digits}f}"
