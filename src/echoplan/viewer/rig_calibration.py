"""A picture of a calibration: the walls as the sensors saw them, the fitted model, and the values."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from echoplan.hardware.calibration import Calibration, SensorView
from echoplan.hardware.walls import reading_of
from echoplan.model import FeatureClass
from echoplan.viewer.palette import COLORS, FAINT, INK, MUTED
from echoplan.viewer.style import FONT, letter, new_figure, png

if TYPE_CHECKING:
    from matplotlib.projections.polar import PolarAxes

__all__ = ["calibration_png"]

# Heights of a row of pictures and of a line of text [inch].
_ROW, _LINE = 1.8, 0.19
# Distances around those of the walls that are shown, and how much less than the real ones the inner radius is [m].
_MARGIN, _INSIDE = 0.04, 0.2
_MEASURED, _MODEL = COLORS[FeatureClass.CORNER], COLORS[FeatureClass.WALL]


def calibration_png(found: Calibration) -> bytes:
    """Draw what was seen of walls over the servo angle, with the fit, and list the values.

    Parameters
    ----------
    found : Calibration
        The calibration.

    Returns
    -------
    bytes
        A PNG file.
    """
    columns = max(min(len(found.views), 3), 1)
    rows = math.ceil(len(found.views) / columns)
    text = _LINE * (len(found.values) + 3)
    figure = new_figure(width=max(2.6 * columns, 4.2), height=_ROW * rows + text)
    grid = figure.add_gridspec(rows + 1, columns, height_ratios=[*rows * [_ROW], text])
    for place, view in enumerate(found.views):
        axes: PolarAxes = figure.add_subplot(grid[divmod(place, columns)], projection="polar")  # type: ignore[assignment]
        _draw_view(axes, view, found=found)
    below = figure.add_subplot(grid[rows, :])
    below.set_axis_off()
    for line, value in enumerate(found.values):
        height = 1.0 - (line + 0.5) / (len(found.values) + 2.0)
        for x, words in ((0.06, value.name), (0.56, value.text)):
            below.text(x, height, words, fontsize=8.5, fontfamily=FONT, color=INK, va="center")
    note = (
        "Servo angles as recorded; distances in metres, stretched.\nDashed: facing the wall. Dotted: edges of the beam."
    )
    below.text(0.06, 0.0, note, fontsize=6.5, fontfamily=FONT, color=MUTED, va="bottom", in_layout=False)
    return png(figure)


def _draw_view(axes: PolarAxes, view: SensorView, *, found: Calibration) -> None:
    """Draw the readings of walls over the recorded servo angle, and the model; the distances are stretched."""
    from matplotlib.ticker import MaxNLocator  # noqa: PLC0415 - with the rest of matplotlib

    axes.set_theta_zero_location("N")
    bottom = min(float(arc.ranges.min()) for arc in view.arcs) - _MARGIN
    for arc, center, depth in zip(view.arcs, view.fit.centers, view.fit.depths, strict=True):
        axes.plot(arc.angles, arc.ranges, "o", markersize=2.6, color=_MEASURED, mew=0, alpha=0.6)
        angles = np.linspace(arc.angles.min(), arc.angles.max(), 200)
        model = reading_of(
            found.signed_gain * (angles - center.value),
            depth=depth.value,
            ka=view.fit.ka.value,
            walk=view.fit.walk,
            sensor=view.sensor,
            transducer=found.transducer,
            air=found.air,
        )
        axes.plot(angles, model, color=_MODEL, linewidth=1.0, zorder=3)
        axes.plot(2 * [center.value], [bottom, float(model.min())], color=_MODEL, linewidth=0.8, linestyle="--")
        for edge in (arc.lower, arc.upper):
            if not math.isnan(edge):
                axes.plot(2 * [edge], [bottom, float(model.max())], color=MUTED, linewidth=0.6, linestyle=":")
    reach = math.degrees(max(float(np.abs(arc.angles).max()) for arc in view.arcs))
    limit = min(15 * math.ceil(reach / 15), 90)
    axes.set_thetalim(-math.radians(limit), math.radians(limit))
    axes.set_rlim(bottom, max(float(arc.ranges.max()) for arc in view.arcs) + _MARGIN)
    axes.set_rorigin(bottom - _INSIDE)
    axes.yaxis.set_major_locator(MaxNLocator(nbins=3, steps=[1, 2, 5, 10]))
    axes.set_rlabel_position(-limit)
    axes.tick_params(labelsize=6.5, labelfontfamily=FONT, color=MUTED, labelcolor=INK)
    axes.grid(color=FAINT, linewidth=0.4)
    # The angles are those that the device records; the wall itself is flat.
    letter(axes, f"{view.name}: fit to ±{1000 * view.fit.rms:.1f} mm")
