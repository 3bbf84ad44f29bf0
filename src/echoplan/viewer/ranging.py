"""Pictures of distances against angle: one wall and its error (Figure 2 of the paper), one fit (Figure 5)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.model import FeatureClass
from echoplan.viewer.palette import COLORS, INK, MUTED
from echoplan.viewer.stages import Fitted, WallProfile
from echoplan.viewer.style import add_legend, dress
from echoplan.viewer.wording import in_degrees, in_metres

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["draw_fit", "draw_range_errors", "draw_ranges"]

_BEFORE, _AFTER = COLORS[FeatureClass.CORNER], COLORS[FeatureClass.WALL]


def draw_ranges(axes: Axes, profile: WallProfile) -> None:
    """Draw the distances of one wall against the angle from its normal (Figure 2a).

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Where to draw.
    profile : WallProfile
        The distances.
    """
    axes.axhline(profile.distance, color=MUTED, linewidth=0.8, label=f"wall at {profile.distance:.3f} m")
    _draw_both(axes, profile, profile.measured, profile.compensated)
    dress(axes, x="angle from the wall's normal (°)", y="distance (m)")
    add_legend(axes, columns=3, where="above")


def draw_range_errors(axes: Axes, profile: WallProfile) -> None:
    """Draw the errors of the distances of one wall (Figure 2a): measured less true.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Where to draw.
    profile : WallProfile
        The distances.
    """
    errors = [1000 * (each - profile.distance) for each in (profile.measured, profile.compensated)]
    axes.axhline(0.0, color=MUTED, linewidth=0.8)
    _draw_both(axes, profile, *errors)
    dress(axes, x="angle from the wall's normal (°)", y="error (mm)")


def draw_fit(axes: Axes, fitted: Fitted) -> None:
    """Draw one cluster, its polynomial and the minimum-distance point (Figure 5).

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Where to draw.
    fitted : Fitted
        The cluster and its fit.
    """
    degrees = np.degrees(fitted.cluster.bearings)
    ends = fitted.cluster.bearings[[0, -1]]
    bearings = np.linspace(ends[0], ends[1], 200)
    a0, a1, a2 = fitted.parabola.coefficients
    x = bearings - fitted.parabola.center
    axes.plot(degrees, fitted.distances, "o", markersize=3, color=MUTED, alpha=0.7, mew=0, label="compensated echoes")
    axes.plot(np.degrees(bearings), a0 + a1 * x + a2 * x**2, color=_AFTER, linewidth=1.2, label="polynomial")
    minimum = (float(np.degrees(fitted.point.bearing)), fitted.point.distance)
    axes.plot(*minimum, "v", markersize=7, color=_BEFORE, label="minimum-distance point")
    axes.annotate(
        f"{in_degrees(fitted.point.bearing)}, {in_metres(fitted.point.distance)}",
        minimum,
        xytext=(0, -14),
        textcoords="offset points",
        ha="center",
        fontsize=7.5,
        color=INK,
    )
    axes.margins(y=0.25)
    dress(axes, x="bearing (°)", y="distance from the hub (m)")
    add_legend(axes, columns=3, where="above")


def _draw_both(axes: Axes, profile: WallProfile, measured: FloatArray, compensated: FloatArray) -> None:
    degrees = np.degrees(profile.angles)
    axes.plot(degrees, measured, "o", markersize=3.2, mfc="none", mew=0.8, color=_BEFORE, label="measured")
    axes.plot(degrees, compensated, "o", markersize=2.6, mew=0, color=_AFTER, label="after compensation (Eq. 1)")
