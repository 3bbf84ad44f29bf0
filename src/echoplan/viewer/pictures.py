"""The figures of the paper as files and as sections of a report, made of one run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from echoplan.geometry import lines_through
from echoplan.model import FeatureClass
from echoplan.viewer.figures import (
    class_figure,
    cluster_figure,
    filter_figure,
    fit_figure,
    membership_figure,
    plan_figure,
    range_figure,
)
from echoplan.viewer.plan import Plan
from echoplan.viewer.sections import Picture
from echoplan.viewer.stages import SweepStages, example, fitted_cluster, wall_profile
from echoplan.viewer.style import png

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["PAPER_FIGURES", "map_picture", "paper_pictures"]

_OF_A_MAP = "Walls, corners and cylinders, the stations in their order, and the true room where it is known."
# By the stem of the file: title and caption.
_WORDS: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "figure-02-ranges": (
            "Distance of one wall and its error",
            "Against the angle between beam and normal. Hollow: as measured. Full: after compensation of the arm.",
        ),
        "figure-05-fit": (
            "Locating an object",
            "The echoes of one cluster after compensation, the polynomial fitted to them, and its minimum.",
        ),
        "figure-07-memberships": (
            "Membership functions",
            "What a cluster of a given width is taken for; the answer changes at the widths L1 and L2.",
        ),
        "figure-10-filter": (
            "Echoes before and after the filter",
            "Every echo from all stations (crosses), as the point that it would mean if sound were a ray.",
        ),
        "figure-11-clusters": (
            "Clusters of one station",
            "Neighbouring clusters take turns in shade; echoes that the filter dropped are in none.",
        ),
        "figure-12-classes": (
            "Classified clusters",
            "Echoes of all stations in the colour of the class of their cluster, and the minimum of each cluster.",
        ),
        "figure-13-map": ("The map of the paper's method", _OF_A_MAP),
        "map": ("The map", _OF_A_MAP),
    }
)
# The stems of the figures of the paper.
PAPER_FIGURES = tuple(name for name in _WORDS if name != "map")


def paper_pictures(stages: Sequence[SweepStages], plan: Plan) -> tuple[Picture, ...]:
    """Make the figures of the paper of one run.

    Parameters
    ----------
    stages : sequence of SweepStages
        All sweeps.
    plan : Plan
        The map and, if it is known, the true room.

    Returns
    -------
    tuple of Picture
        In the order of the paper; without those of a wall or a station if nothing of the kind was detected.
    """
    made = (*_of_one_wall(stages, plan), *_of_the_classes(stages), ("figure-13-map", plan_figure(plan)))
    return tuple(_picture(name, figure) for name, figure in made)


def map_picture(plan: Plan) -> Picture:
    """Make a picture of a map.

    Parameters
    ----------
    plan : Plan
        The map and, if it is known, the true room.

    Returns
    -------
    Picture
        Called ``map``.
    """
    return _picture("map", plan_figure(plan))


def _picture(name: str, figure: Figure) -> Picture:
    title, caption = _WORDS[name]
    return Picture(name=name, title=title, caption=caption, png=png(figure))


def _of_one_wall(stages: Sequence[SweepStages], plan: Plan) -> Iterator[tuple[str, Figure]]:
    wall = example(stages, FeatureClass.WALL)
    if wall is None:
        return
    # Distances are compared with those of the true walls where these are known.
    if plan.truth is not None:
        lines = lines_through(plan.truth.walls_xy[:, 0], plan.truth.walls_xy[:, 1])
    else:
        lines = np.array([[each.normal_angle, each.offset] for each in plan.feature_map.walls]).reshape(-1, 2)
    profile = wall_profile(wall, lines)
    if profile is not None:
        yield "figure-02-ranges", range_figure(profile)
    fitted = fitted_cluster(wall)
    if fitted is not None:
        yield "figure-05-fit", fit_figure(fitted)


def _of_the_classes(stages: Sequence[SweepStages]) -> Iterator[tuple[str, Figure]]:
    yield "figure-07-memberships", membership_figure()
    if not stages:
        return
    yield "figure-10-filter", filter_figure(stages)
    yield "figure-11-clusters", cluster_figure(max(stages, key=lambda each: len(each.located)))
    yield "figure-12-classes", class_figure(stages)
