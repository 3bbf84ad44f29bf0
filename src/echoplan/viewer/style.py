"""One look for all figures: thin lines, one font, units on every axis, nothing that is not data."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.viewer.palette import FAINT, INK, MUTED

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["FONT", "add_legend", "dress", "dress_map", "letter", "map_height", "new_figure", "png", "printable"]

# Comes with matplotlib, so figures are the same everywhere.
FONT = "DejaVu Sans"
_SMALL, _NORMAL = 7.5, 8.5
_DPI = 200


def new_figure(*, width: float = 6.3, height: float = 3.4) -> Figure:
    """Make an empty figure; no global state of matplotlib is touched.

    Parameters
    ----------
    width, height : float, optional
        Size in inches; the width is that of the text on A4.

    Returns
    -------
    matplotlib.figure.Figure
        With its Agg canvas.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415 - half a second of import
    from matplotlib.figure import Figure  # noqa: PLC0415

    figure = Figure(figsize=(width, height), layout="constrained", facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def map_height(points_xy: FloatArray, *, width: float) -> float:
    """Find how high a panel must be to show points with both directions alike.

    Parameters
    ----------
    points_xy : ndarray, shape (n, 2)
        What is to be shown [m].
    width : float
        Width of the panel [inch].

    Returns
    -------
    float
        Height [inch]: neither a strip nor more than a page.
    """
    if not len(points_xy):
        return width
    across, along = np.ptp(points_xy, axis=0).tolist()
    return float(np.clip(width * along / max(across, 1e-9), 0.4 * width, 7.5))


def dress(axes: Axes, *, x: str, y: str) -> None:
    """Give axes the common look.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        What to dress.
    x, y : str
        Names of the quantities, with their units.
    """
    axes.spines[["top", "right"]].set_visible(False)
    for spine in axes.spines.values():
        spine.set(linewidth=0.6, color=MUTED)
    axes.tick_params(labelsize=_SMALL, labelfontfamily=FONT, length=3, width=0.6, color=MUTED, labelcolor=INK)
    axes.set_xlabel(x, fontsize=_NORMAL, fontfamily=FONT, color=INK)
    axes.set_ylabel(y, fontsize=_NORMAL, fontfamily=FONT, color=INK)
    axes.set_axisbelow(True)


def dress_map(axes: Axes) -> None:
    """Give axes the look of a map: both directions alike, a faint grid.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        What to dress.
    """
    from matplotlib.ticker import MaxNLocator  # noqa: PLC0415 - with the rest of matplotlib

    dress(axes, x="x (m)", y="y (m)")
    axes.set_aspect("equal")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(nbins=6, steps=[1, 2, 5, 10]))
    axes.grid(color=FAINT, linewidth=0.4)


def letter(axes: Axes, text: str) -> None:
    """Name a panel, as in ``(a) before``.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        The panel.
    text : str
        Its name.
    """
    axes.set_title(text, loc="left", fontsize=_NORMAL, fontfamily=FONT, color=INK)


def add_legend(axes: Axes, *, columns: int = 1, where: str = "best") -> None:
    """Explain the marks that have a label; where none has, say nothing.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        What to explain.
    columns : int, optional
        In how many columns.
    where : str, optional
        A place of matplotlib's, or ``above`` for a line over the axes.
    """
    if not axes.get_legend_handles_labels()[1]:
        return
    place = {"loc": "lower left", "bbox_to_anchor": (0.0, 1.0)} if where == "above" else {"loc": where}
    legend = axes.legend(
        **place,
        ncols=columns,
        frameon=False,
        prop={"family": FONT, "size": _SMALL},
        labelcolor=INK,
        handletextpad=0.4,
        columnspacing=1.2,
        borderaxespad=0.2,
    )
    for handle in legend.legend_handles:
        if handle is not None:
            handle.set_alpha(1.0)


def png(figure: Figure) -> bytes:
    """Render a figure.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        The figure.

    Returns
    -------
    bytes
        A PNG file of 200 dots an inch; the same figure gives the same bytes.
    """
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=_DPI, metadata={"Software": None})
    return buffer.getvalue()


def printable(text: str) -> str:
    """Replace what the font of the figures has no letter for, and all kinds of white space by blanks."""
    from matplotlib.font_manager import findfont, get_font  # noqa: PLC0415 - with the rest of matplotlib

    letters = get_font(findfont(FONT)).get_charmap()
    return "".join(each if ord(each) in letters else "?" for each in " ".join(text.split()))
