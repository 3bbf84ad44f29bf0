"""Whole figures, after those of the paper."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.preprocessing import echo_points
from echoplan.viewer.echoes import draw_classes, draw_clusters, draw_echoes
from echoplan.viewer.maps import draw_plan
from echoplan.viewer.membership import draw_memberships
from echoplan.viewer.plan import Plan
from echoplan.viewer.ranging import draw_fit, draw_range_errors, draw_ranges
from echoplan.viewer.stages import Fitted, SweepStages, WallProfile
from echoplan.viewer.style import letter, map_height, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = [
    "class_figure",
    "cluster_figure",
    "filter_figure",
    "fit_figure",
    "membership_figure",
    "plan_figure",
    "range_figure",
]


def range_figure(profile: WallProfile) -> Figure:
    """Show the distances of one wall and their errors (Figure 2a of the paper).

    Parameters
    ----------
    profile : WallProfile
        The distances.

    Returns
    -------
    matplotlib.figure.Figure
        Two panels.
    """
    figure = new_figure(height=4.2)
    above, below = figure.subplots(2, 1, sharex=True)
    draw_ranges(above, profile)
    draw_range_errors(below, profile)
    above.set_xlabel("")
    return figure


def fit_figure(fitted: Fitted) -> Figure:
    """Show one cluster with its polynomial and its minimum (Figure 5 of the paper).

    Parameters
    ----------
    fitted : Fitted
        The cluster and its fit.

    Returns
    -------
    matplotlib.figure.Figure
        One panel.
    """
    figure = new_figure(height=3.0)
    draw_fit(figure.subplots(), fitted)
    return figure


def membership_figure() -> Figure:
    """Show the membership functions (Figure 7 of the paper).

    Returns
    -------
    matplotlib.figure.Figure
        One panel.
    """
    figure = new_figure(height=2.8)
    draw_memberships(figure.subplots())
    return figure


def filter_figure(stages: Sequence[SweepStages]) -> Figure:
    """Show all echoes before and after the K-means filter (Figure 10 of the paper).

    Parameters
    ----------
    stages : sequence of SweepStages
        Some sweeps.

    Returns
    -------
    matplotlib.figure.Figure
        Two panels on the same axes.
    """
    figure = new_figure(height=0.8 + map_height(_points(stages), width=2.7))
    before, after = figure.subplots(1, 2, sharex=True, sharey=True)
    draw_echoes(before, [each.valid for each in stages])
    draw_echoes(after, [each.kept for each in stages])
    letter(before, f"(a) {sum(len(each.valid) for each in stages)} echoes")
    letter(after, f"(b) {sum(len(each.kept) for each in stages)} kept by the filter")
    after.set_ylabel("")
    return figure


def cluster_figure(stages: SweepStages) -> Figure:
    """Show the clusters of one station and their minima (Figure 11 of the paper).

    Parameters
    ----------
    stages : SweepStages
        One sweep.

    Returns
    -------
    matplotlib.figure.Figure
        One panel.
    """
    figure = new_figure(height=3.0)
    draw_clusters(figure.subplots(), stages)
    return figure


def class_figure(stages: Sequence[SweepStages]) -> Figure:
    """Show what each cluster was taken for (Figure 12 of the paper).

    Parameters
    ----------
    stages : sequence of SweepStages
        Some sweeps.

    Returns
    -------
    matplotlib.figure.Figure
        One panel.
    """
    figure = new_figure(height=0.8 + map_height(_points(stages), width=5.4))
    draw_classes(figure.subplots(), stages)
    return figure


def plan_figure(plan: Plan) -> Figure:
    """Show the map (Figure 13 of the paper).

    Parameters
    ----------
    plan : Plan
        The map and, if it is known, the true room.

    Returns
    -------
    matplotlib.figure.Figure
        One panel.
    """
    # The legend may take three rows, and the axis its label.
    figure = new_figure(height=1.3 + map_height(plan.bounds_xy, width=5.6))
    draw_plan(figure.subplots(), plan)
    return figure


def _points(stages: Sequence[SweepStages]) -> FloatArray:
    return np.concatenate([np.zeros((0, 2)), *(echo_points(each.valid) for each in stages)])
