"""A picture of the membership functions of the width of a cluster (Figure 7 of the paper)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from echoplan.classical.fuzzy import BIG, CROSSINGS, MEDIUM, SMALL, memberships
from echoplan.model import FeatureClass
from echoplan.viewer.palette import COLORS, INK, MUTED
from echoplan.viewer.style import add_legend, dress

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["draw_memberships"]

_STATES = (
    ("small: corner", FeatureClass.CORNER, "--"),
    ("medium: cylinder", FeatureClass.CYLINDER, "-."),
    ("big: flat", FeatureClass.WALL, "-"),
)


def draw_memberships(axes: Axes) -> None:
    """Draw the memberships of Eq. 14-16 and where they cross (Eq. 17).

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Where to draw.
    """
    widths = np.linspace(0.0, 1.0, 1001)
    for (name, feature_class, dashes), degrees in zip(_STATES, memberships(widths).T, strict=True):
        axes.plot(widths, degrees, dashes, color=COLORS[feature_class], linewidth=1.4, label=name)
    for number, crossing in enumerate(CROSSINGS, start=1):
        height = np.sort(memberships(crossing))[-1]
        axes.vlines(crossing, 0.0, height, color=MUTED, linewidth=0.7, linestyle=":")
        axes.plot(crossing, height, "o", markersize=3.5, color=INK)
        axes.annotate(
            f"$L_{number}$ = {crossing:.4f}",
            (crossing, 0.0),
            xytext=(4, 6),
            textcoords="offset points",
            fontsize=8,
            color=INK,
        )
    dress(axes, x="width of the cluster (1)", y="membership (1)")
    names = {0.0: "", SMALL: "$L_s$", MEDIUM: "$L_m$", BIG: "$L_b$", 1.0: "$L_{max}$"}
    axes.set_xticks(list(names), labels=[f"{width:.2f}\n{name}" for width, name in names.items()])
    axes.set(xlim=(0, 1), ylim=(0, 1.08), yticks=[0, 0.5, 1])
    add_legend(axes, columns=3, where="above")
