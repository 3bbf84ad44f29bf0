"""The paper's own Table 5, and ours beside it."""

import math
from collections.abc import Mapping, Sequence

from echoplan.evaluation.deviations import Deviation, deviations
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
        A row for each wall, and the mean and the worst of each column; where walls are missing these are of the
        others.
    """
    names, found = ("paper", *evaluations), [deviations(each.matches.walls) for each in evaluations.values()]
    columns = [
        *_columns(PAPER_DISTANCES, found, "distance", scale=1000.0, digits=1),
        *_columns(PAPER_ANGLES, found, "angle", scale=math.degrees(1.0), digits=2),
    ]
    heads = (*map(str, range(1, len(PAPER_DISTANCES) + 1)), "mean", "worst")
    return Table(
        title="Table 5: deviation of the walls (paper: a real room; ours: a simulated one)",
        columns=("wall", *(f"{name} (mm)" for name in names), *(f"{name} (°)" for name in names)),
        rows=tuple((head, *cells) for head, *cells in zip(heads, *columns, strict=True)),
    )


def _columns(
    paper: Sequence[float],
    found: Sequence[Sequence[Deviation[WallMatch]]],
    name: str,
    *,
    scale: float,
    digits: int,
) -> list[list[str]]:
    ours = [[math.nan if each.match is None else float(getattr(each.match, name)) for each in walls] for walls in found]
    return [_column(values, scale=scale, digits=digits) for values in (paper, *ours)]


def _column(values: Sequence[float], *, scale: float, digits: int) -> list[str]:
    known = [value for value in values if not math.isnan(value)]
    ends = [sum(known) / len(known), max(known)] if known else [math.nan, math.nan]
    return ["-" if math.isnan(value) else f"{scale * value:.{digits}f}" for value in (*values, *ends)]
