"""The paper's own Table 5, and ours beside it."""

import math
from collections.abc import Mapping, Sequence

from echoplan.evaluation.deviations import deviations
from echoplan.evaluation.evaluation import Evaluation
from echoplan.evaluation.matches import WallMatch
from echoplan.model import Table

__all__ = ["PAPER_ANGLES", "PAPER_DISTANCES", "table5"]

# Table 5 of the paper: how far its eight walls were off [m, rad].
PAPER_DISTANCES = (0.0128, 0.0067, 0.0010, 0.0078, 0.0005, 0.0018, 0.0038, 0.0070)
PAPER_ANGLES = tuple(math.radians(angle) for angle in (3, 2, 0, 3, 0, 0, 1, 1))


def table5(evaluations: Mapping[str, Evaluation]) -> Table:
    """Set deviations of walls beside those that the paper reports.

    Parameters
    ----------
    evaluations : mapping of str to Evaluation
        Maps of one room with eight walls, by the name to print; dashes stand for walls that a map lacks.

    Returns
    -------
    Table
        A row for each wall, and the mean and the greatest of each column; where walls are missing these are of the
        others.
    """
    found = [deviations(each.matches.walls) for each in evaluations.values()]
    distances = [PAPER_DISTANCES, *([_of(each.match, "distance") for each in walls] for walls in found)]
    angles = [PAPER_ANGLES, *([_of(each.match, "angle") for each in walls] for walls in found)]
    columns = [
        *(_column(values, scale=1000.0, digits=1) for values in distances),
        *(_column(values, scale=math.degrees(1.0), digits=2) for values in angles),
    ]
    names = ("paper", *evaluations)
    heads = ("wall", "mean", "greatest")
    rows = (*map(str, range(1, len(PAPER_DISTANCES) + 1)), *heads[1:])
    return Table(
        title="Table 5: deviation of the walls, the paper's beside ours",
        columns=(heads[0], *(f"{name} (mm)" for name in names), *(f"{name} (°)" for name in names)),
        rows=tuple((row, *cells) for row, *cells in zip(rows, *columns, strict=True)),
    )


def _of(match: WallMatch | None, name: str) -> float:
    return math.nan if match is None else float(getattr(match, name))


def _column(values: Sequence[float], *, scale: float, digits: int) -> list[str]:
    known = [value for value in values if not math.isnan(value)]
    ends = [sum(known) / len(known), max(known)] if known else [math.nan, math.nan]
    return ["-" if math.isnan(value) else f"{scale * value:.{digits}f}" for value in (*values, *ends)]
