"""Many evaluations pooled: recordings, seeds, rooms."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from math import isnan
from typing import TypeAlias

import numpy as np

from echoplan.arrays import IntArray, checked_integers, store
from echoplan.evaluation.bootstrap import BootstrapSettings, Distribution, Interval, describe, describe_share
from echoplan.evaluation.confusion import no_confusion
from echoplan.evaluation.consistency import PARAMETERS, Consistency, pool_consistency
from echoplan.evaluation.evaluation import Evaluation
from echoplan.evaluation.floor_plan import FloorPlanScore
from echoplan.evaluation.tally import Tally
from echoplan.model import FeatureClass

__all__ = ["ClassSummary", "ErrorSummary", "pool"]

_Spread: TypeAlias = Callable[[Iterable[Sequence[float]]], Distribution]
_Share: TypeAlias = Callable[[Iterable[tuple[int, int]]], Interval]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class ClassSummary:
    """How right the maps are about one class.

    Parameters
    ----------
    tally : Tally
        Counts over all maps.
    recall, precision : Interval
        Shares over all maps.
    distance : Distribution
        Deviations of the right estimates [m].
    consistency : Consistency
        Errors against the maps' own covariances.
    """

    tally: Tally
    recall: Interval
    precision: Interval
    distance: Distribution
    consistency: Consistency


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class ErrorSummary:
    """What can be said of several maps together.

    Parameters
    ----------
    recordings : int
        How many maps there are.
    classes : mapping of FeatureClass to ClassSummary
        How right they are about each class.
    wall_angle : Distribution
        Angles between right walls and true ones [rad].
    cylinder_radius : Distribution
        Deviations of the radii of right cylinders, without sign [m].
    confusion : ndarray of int, shape (4, 4)
        What stands for what: rows as in ``TRUE_CLASSES``, columns as in ``MAP_CLASSES``.
    map_error, hausdorff : Distribution
        Symmetric mean and Hausdorff distance of the outlines of each map [m].
    floor_plan : FloorPlanScore
        Lengths of walls, openings and ends of walls over all maps.
    position, heading : Distribution
        Root mean square errors of the poses of each map [m], [rad].
    """

    recordings: int
    classes: Mapping[FeatureClass, ClassSummary]
    wall_angle: Distribution
    cylinder_radius: Distribution
    confusion: IntArray
    map_error: Distribution
    hausdorff: Distribution
    floor_plan: FloorPlanScore
    position: Distribution
    heading: Distribution

    def __post_init__(self) -> None:
        store(self, confusion=checked_integers(self.confusion, name="confusion", shape=(4, 4)))


def pool(
    evaluations: Iterable[Evaluation], *, rng: np.random.Generator, settings: BootstrapSettings | None = None
) -> ErrorSummary:
    """Pool evaluations, one or many, into statistics with confidence intervals.

    Parameters
    ----------
    evaluations : iterable of Evaluation
        One for each recording.
    rng : numpy.random.Generator
        Source of the bootstrap's draws.
    settings : BootstrapSettings, optional
        How many draws, which interval.

    Returns
    -------
    ErrorSummary
        Of all of them together; nan where nothing was measured.
    """
    every = list(evaluations)
    spread = partial(describe, rng=rng, settings=settings)
    share = partial(describe_share, rng=rng, settings=settings)
    return ErrorSummary(
        recordings=len(every),
        classes={name: _of_class(name, every, spread=spread, share=share) for name in FeatureClass},
        wall_angle=spread(map(_wall_angles, every)),
        cylinder_radius=spread(map(_radius_errors, every)),
        confusion=sum((each.confusion for each in every), start=no_confusion()),
        map_error=spread(_known(each.map_error.mean) for each in every),
        hausdorff=spread(_known(each.map_error.hausdorff) for each in every),
        floor_plan=sum((each.floor_plan for each in every), start=FloorPlanScore()),
        position=spread(map(_position_error, every)),
        heading=spread(map(_heading_error, every)),
    )


def _of_class(name: FeatureClass, evaluations: list[Evaluation], *, spread: _Spread, share: _Share) -> ClassSummary:
    matchings = [each.matches.by_class[name] for each in evaluations]
    tallies = [matching.tally for matching in matchings]
    consistencies = (each.consistency[name] for each in evaluations)
    return ClassSummary(
        tally=sum(tallies, start=Tally()),
        recall=share((tally.found, tally.wanted) for tally in tallies),
        precision=share((tally.right, tally.estimates) for tally in tallies),
        distance=spread([match.distance for match in matching.right] for matching in matchings),
        consistency=pool_consistency(consistencies, parameters=PARAMETERS[name]),
    )


def _wall_angles(evaluation: Evaluation) -> list[float]:
    return [match.angle for match in evaluation.matches.walls.right]


def _radius_errors(evaluation: Evaluation) -> list[float]:
    return [abs(match.radius_error) for match in evaluation.matches.cylinders.right]


def _position_error(evaluation: Evaluation) -> list[float]:
    return [evaluation.trajectory.absolute_error] if evaluation.trajectory else []


def _heading_error(evaluation: Evaluation) -> list[float]:
    return [evaluation.trajectory.heading_error] if evaluation.trajectory else []


def _known(value: float) -> list[float]:
    return [] if isnan(value) else [value]
