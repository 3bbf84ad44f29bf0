"""Figures as they are asked about in tests: their lines by label, their data, their words."""

from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.lines import Line2D
from matplotlib.text import Annotation

from echoplan.arrays import FloatArray
from echoplan.viewer.style import new_figure


def axes_of(draw: Callable[[Axes], None]) -> Axes:
    """New axes with something drawn on them."""
    axes = new_figure().subplots()
    draw(axes)
    return axes


def data(line: Line2D) -> FloatArray:
    """Points of a line, shape (n, 2)."""
    return np.array([line.get_xdata(), line.get_ydata()], dtype=np.float64).T


def lines(axes: Axes, label: str) -> list[Line2D]:
    """All lines with a label."""
    return [each for each in axes.lines if each.get_label() == label]


def line(axes: Axes, label: str) -> Line2D:
    """The only line with a label."""
    (only,) = lines(axes, label)
    return only


def legend(axes: Axes) -> list[str]:
    """What the legend says; empty where there is none."""
    found = axes.get_legend()
    return [] if found is None else [each.get_text() for each in found.get_texts()]


def names(axes: Axes) -> tuple[str, str]:
    """Names of both axes."""
    return axes.get_xlabel(), axes.get_ylabel()


def notes(axes: Axes) -> list[Annotation]:
    """The annotations."""
    return [each for each in axes.texts if isinstance(each, Annotation)]


def color(line: Line2D) -> str:
    """Colour of a line, as ``#17375e``."""
    return to_hex(line.get_color())
