"""A map against the truth: all that can be said of one map."""

from collections.abc import Mapping
from dataclasses import dataclass

from pydantic import Field

from echoplan.arrays import IntArray, checked_integers, store
from echoplan.evaluation.confusion import confusion_matrix
from echoplan.evaluation.consistency import Consistency, check_consistency
from echoplan.evaluation.floor_plan import FloorPlanScore, score_floor_plan
from echoplan.evaluation.matches import Matches
from echoplan.evaluation.matching import MatchingSettings, match_map
from echoplan.evaluation.outlines import MapError, OutlineSettings, compare_outlines
from echoplan.evaluation.trajectory import Trajectory, compare_poses
from echoplan.model import FeatureClass, FeatureMap, Truth
from echoplan.settings import Settings

__all__ = ["Evaluation", "EvaluationSettings", "evaluate"]


class EvaluationSettings(Settings):
    """How a map is compared with the truth."""

    matching: MatchingSettings = Field(
        default=MatchingSettings(), description="Gates of the matching of estimates with true objects."
    )
    outlines: OutlineSettings = Field(default=OutlineSettings(), description="Comparison of outlines.")


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Evaluation:
    """What is right and what is wrong about one map.

    Parameters
    ----------
    method : str
        The method that made the map.
    matches : Matches
        Which estimate is of which true object, with deviations and counts.
    confusion : ndarray of int, shape (4, 4)
        What stands for what: rows as in ``TRUE_CLASSES``, columns as in ``MAP_CLASSES``.
    consistency : mapping of FeatureClass to Consistency
        Errors against the map's own covariances.
    map_error : MapError
        Distance between the outlines.
    floor_plan : FloorPlanScore
        Lengths of walls, openings and ends of walls.
    trajectory : Trajectory or None
        Errors of the poses; None where they cannot be compared.
    """

    method: str
    matches: Matches
    confusion: IntArray
    consistency: Mapping[FeatureClass, Consistency]
    map_error: MapError
    floor_plan: FloorPlanScore
    trajectory: Trajectory | None

    def __post_init__(self) -> None:
        store(self, confusion=checked_integers(self.confusion, name="confusion", shape=(4, 4)))


def evaluate(feature_map: FeatureMap, truth: Truth, settings: EvaluationSettings | None = None) -> Evaluation:
    """Compare a map with ground truth.

    Parameters
    ----------
    feature_map : FeatureMap
        The map, in the frame of the truth.
    truth : Truth
        What it should say.
    settings : EvaluationSettings, optional
        How near is near enough.

    Returns
    -------
    Evaluation
        Of this map alone; ``pool`` gives the statistics of one or many.

    Examples
    --------
    >>> import numpy as np
    >>> from echoplan.model import Wall
    >>> truth = Truth(walls_xy=[[[0, 2], [4, 2]], [[4, 2], [4, 0]]], walls_detected_by=[5, 3])
    >>> wall = Wall(normal_angle=np.pi / 2, offset=2.01, endpoints_xy=[[1, 2.01], [3, 2.01]], covariance=np.eye(2))
    >>> evaluate(FeatureMap(method="by hand", walls=(wall,)), truth).matches.walls.tally.recall
    0.5
    """
    settings = settings or EvaluationSettings()
    matches = match_map(feature_map, truth, settings.matching)
    return Evaluation(
        method=feature_map.method,
        matches=matches,
        confusion=confusion_matrix(feature_map, truth, matches, settings.matching),
        consistency=check_consistency(feature_map, truth, matches),
        map_error=compare_outlines(
            feature_map, truth, min_stations=settings.matching.min_stations, settings=settings.outlines
        ),
        floor_plan=score_floor_plan(
            feature_map, truth, matches.walls, matching=settings.matching, outlines=settings.outlines
        ),
        trajectory=compare_poses(feature_map, truth),
    )
