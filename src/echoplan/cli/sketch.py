"""A sweep in characters, for any terminal and for pipes."""

import math
from dataclasses import replace

import numpy as np

from echoplan.model import Pings, Rig, Sweep

__all__ = ["sketch_sweep"]

# Size of the picture [characters]: it fits a terminal of 80 columns and 24 rows with a prompt below it.
_COLUMNS, _ROWS = 61, 17
# A character of a terminal is about twice as high as it is wide.
_ASPECT = 2.0


def sketch_sweep(sweep: Sweep, rig: Rig) -> str:
    """Draw the echoes of a sweep around the robot, which looks up: ``R`` the robot, ``o`` an echo, ``O`` several."""
    seen = Pings.from_sweep(replace(sweep, map_from_base=np.zeros((len(sweep), 3))), rig)
    echoes = seen[np.isfinite(seen.ranges)]
    if not len(echoes):
        return "The first sweep has no echo.\n"
    directions = np.column_stack([np.cos(echoes.bearings), np.sin(echoes.bearings)])
    ahead, left = (echoes.origins_xy + echoes.ranges[:, None] * directions).T
    top, bottom = max(float(ahead.max()), 0.0), min(float(ahead.min()), 0.0)
    right, leftmost = min(float(left.min()), 0.0), max(float(left.max()), 0.0)
    # Metres in a column of characters: 1, 2 or 5 times a power of ten, as on a ruler.
    least = max((leftmost - right) / (_COLUMNS - 1), (top - bottom) / (_ROWS - 1) / _ASPECT, 1e-3)
    power = 10.0 ** math.floor(math.log10(least))
    cell = next(factor * power for factor in (1.0, 2.0, 5.0, 10.0) if factor * power >= least * (1.0 - 1e-9))
    rows = np.rint((top - np.append(ahead, 0.0)) / (_ASPECT * cell)).astype(int)
    columns = np.rint((leftmost - np.append(left, 0.0)) / cell).astype(int)
    canvas = np.full((rows.max() + 1, columns.max() + 1), " ")
    for row, column in zip(rows[:-1], columns[:-1], strict=True):
        canvas[row, column] = "o" if canvas[row, column] == " " else "O"
    canvas[rows[-1], columns[-1]] = "R"
    lines = ["".join(line).rstrip() for line in canvas]
    head = f"First sweep: {len(sweep)} pings, {len(echoes)} echoes, seen from above; the robot R looks up."
    return (
        "\n".join([head, *lines, f"One column is {100.0 * cell:g} cm, one row {100.0 * _ASPECT * cell:g} cm."]) + "\n"
    )
