"""Pictures of echoes: raw and filtered (Figure 10 of the paper), clustered (11) and classified (12)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from echoplan.extraction import Cluster, hub_distances
from echoplan.geometry import wrap
from echoplan.model import FeatureClass, Pings
from echoplan.preprocessing import echo_points
from echoplan.viewer.palette import COLORS, MARKERS, MUTED
from echoplan.viewer.stages import SweepStages
from echoplan.viewer.style import add_legend, dress, dress_map

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["draw_classes", "draw_clusters", "draw_echoes"]

# Neighbouring clusters take turns.
_SHADES = (COLORS[FeatureClass.WALL], "#7f9cc4")

_NAMES = {FeatureClass.WALL: "flat", FeatureClass.CYLINDER: "cylinder", FeatureClass.CORNER: "corner"}


def draw_echoes(axes: Axes, pings: Sequence[Pings]) -> None:
    """Draw where echoes would lie if sound were a ray (Figure 10).

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Where to draw.
    pings : sequence of Pings
        Pings with finite ranges, one item a station.
    """
    points = np.concatenate([np.zeros((0, 2)), *(echo_points(each) for each in pings)])
    stations = np.array([each.hubs_xy.mean(axis=0) for each in pings if len(each)]).reshape(-1, 2)
    axes.plot(*points.T, ".", markersize=1.6, color=COLORS[FeatureClass.WALL], alpha=0.55, mew=0)
    axes.plot(*stations.T, "x", markersize=4, color=COLORS[FeatureClass.CORNER], mew=0.9)
    dress_map(axes)


def draw_clusters(axes: Axes, stages: SweepStages) -> None:
    """Draw the clusters of one station by bearing and distance, with their minima (Figure 11).

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Where to draw.
    stages : SweepStages
        What was made of the sweep.
    """
    axes.plot(
        np.degrees(wrap(stages.stray.bearings)),
        hub_distances(stages.stray),
        "x",
        markersize=3,
        mew=0.6,
        color=MUTED,
        label="in no cluster",
    )
    minima = []
    for number, located in enumerate(stages.located):
        bearings = located.cluster.bearings + _turn(located.cluster)
        axes.plot(np.degrees(bearings), located.cluster.distances, ".", markersize=4, color=_SHADES[number % 2])
        if located.observation is not None:
            point = located.observation.point
            minima.append((np.degrees(point.bearing + _turn(located.cluster)), point.distance))
    axes.plot(
        *np.array(minima).reshape(-1, 2).T,
        "v",
        markersize=6,
        color=COLORS[FeatureClass.CORNER],
        mec="white",
        mew=0.5,
        label="minimum-distance point",
    )
    dress(axes, x="bearing (°)", y="distance from the hub (m)")
    axes.set(ylim=(0, None), xticks=np.arange(-180, 181, 45))
    add_legend(axes, columns=2, where="above")


def draw_classes(axes: Axes, stages: Sequence[SweepStages]) -> None:
    """Draw what each cluster was taken for (Figure 12).

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Where to draw.
    stages : sequence of SweepStages
        What was made of each sweep.
    """
    located = [each for sweep in stages for each in sweep.located]
    for feature_class, name in _NAMES.items():
        own = [each for each in located if each.feature_class is feature_class]
        points = [echo_points(each.cluster.pings) for each in own]
        minima = [each.observation.point.position_xy for each in own if each.observation]
        color = COLORS[feature_class]
        axes.plot(*np.concatenate([np.zeros((0, 2)), *points]).T, ".", markersize=1.6, color=color, alpha=0.4, mew=0)
        axes.plot(
            *np.array(minima).reshape(-1, 2).T,
            MARKERS[feature_class],
            markersize=5,
            color=color,
            mec="white",
            mew=0.5,
            label=f"{name} ({len(own)})",
        )
    dress_map(axes)
    add_legend(axes, columns=3, where="above")


def _turn(cluster: Cluster) -> float:
    """Whole turns by which the middle of a cluster comes to lie in [-pi, pi), so that it is not split."""
    middle = float(cluster.bearings[[0, -1]].mean())
    return float(wrap(middle)) - middle
