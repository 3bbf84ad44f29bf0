"""What has changed in a place between two recordings: in words, and drawn."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.geometry import directions
from echoplan.model import Changes, Cylinder
from echoplan.viewer.palette import GONE, NEW
from echoplan.viewer.sections import Definitions
from echoplan.viewer.wording import decimal

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["changed_lines", "changes_in_words", "draw_changes"]


def changes_in_words(changes: Sequence[Changes]) -> tuple[Definitions, ...]:
    """List what has changed.

    Parameters
    ----------
    changes : sequence of Changes
        For each recording that others came before.

    Returns
    -------
    tuple of Definitions
        One; none without such a recording.

    Examples
    --------
    >>> moved = Changes(recording="tuesday", gone_walls=(np.array([[0.0, 0.0], [1.0, 0.0]]),))
    >>> changes_in_words([moved])[0].items
    (('Changed when tuesday was recorded', 'gone: a wall of 1.00 m at x 0.50 m, y 0.00 m'),)
    """
    items = tuple(
        (f"Changed when {each.recording} was recorded", "; ".join(_lists(each)) or "nothing") for each in changes
    )
    return (Definitions(title="Changes", items=items),) if items else ()


def _lists(changes: Changes) -> Iterator[str]:
    for what, walls, cylinders in (
        ("gone", changes.gone_walls, changes.gone_cylinders),
        ("new", changes.new_walls, changes.new_cylinders),
    ):
        lengths = (decimal(float(np.hypot(*(ends_xy[1] - ends_xy[0]))), 2) for ends_xy in walls)
        listed = [
            *(
                f"a wall of {length} m at {_place(ends.mean(axis=0))}"
                for length, ends in zip(lengths, walls, strict=True)
            ),
            *(
                f"a cylinder of {decimal(1000.0 * each.radius, 0)} mm radius at {_place(each.center_xy)}"
                for each in cylinders
            ),
        ]
        if listed:
            yield f"{what}: {', '.join(listed)}"


def _place(point_xy: FloatArray) -> str:
    x, y = point_xy.tolist()
    return f"x {decimal(x, 2)} m, y {decimal(y, 2)} m"


def draw_changes(axes: Axes, changes: Sequence[Changes]) -> None:
    """Draw what is gone as dashed lines, and mark what is new.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Where to draw.
    changes : sequence of Changes
        For each recording that others came before.
    """
    gone, new = changed_lines(changes)
    for lines, color, style, label in ((gone, GONE, (0, (3, 2)), "gone"), (new, NEW, "-", "new")):
        for number, line in enumerate(lines):
            axes.plot(*line.T, color=color, linewidth=1.6, linestyle=style, label=None if number else label)


def changed_lines(changes: Sequence[Changes]) -> tuple[list[FloatArray], list[FloatArray]]:
    """Return the lines that show what is gone and what is new: walls, and the circles of cylinders [m]."""
    gone = [line for each in changes for line in (*each.gone_walls, *_rims(each.gone_cylinders))]
    new = [line for each in changes for line in (*each.new_walls, *_rims(each.new_cylinders))]
    return gone, new


def _rims(cylinders: Sequence[Cylinder]) -> list[FloatArray]:
    """Return the circles of cylinders, shape (73, 2) [m] each."""
    around = directions(np.linspace(0.0, 2 * np.pi, 73))
    return [each.center_xy + each.radius * around for each in cylinders]
