"""Maps against the truth: matching, Table 5 of the paper, scores, consistency and statistics."""

from echoplan.evaluation.all_tables import evaluation_tables
from echoplan.evaluation.bootstrap import BootstrapSettings, Distribution, Interval
from echoplan.evaluation.confusion import MAP_CLASSES, TRUE_CLASSES
from echoplan.evaluation.consistency import Consistency
from echoplan.evaluation.deviations import Deviation, deviations
from echoplan.evaluation.documents import evaluation_document, summary_document
from echoplan.evaluation.evaluation import Evaluation, EvaluationSettings, evaluate
from echoplan.evaluation.floor_plan import FloorPlanScore
from echoplan.evaluation.floor_plan_tables import floor_plan_tables
from echoplan.evaluation.grids import GridScore, pool_grid_scores, score_grid, true_grid
from echoplan.evaluation.intervals import IntervalErrors
from echoplan.evaluation.lengths import WallLengths
from echoplan.evaluation.map_error import map_error
from echoplan.evaluation.matches import CylinderMatch, Match, Matches, Matching, WallMatch
from echoplan.evaluation.matching import MatchingSettings, match_map
from echoplan.evaluation.outlines import MapError, Outline, OutlineSettings
from echoplan.evaluation.paper import PAPER_ANGLES, PAPER_DISTANCES, table5
from echoplan.evaluation.summary import ClassSummary, ErrorSummary, pool
from echoplan.evaluation.tables import (
    confusion_table,
    consistency_table,
    cylinder_table,
    deviation_table,
    tally_table,
    wall_table,
)
from echoplan.evaluation.tally import Tally
from echoplan.evaluation.trajectory import Trajectory, trajectory_table

__all__ = [
    "MAP_CLASSES",
    "PAPER_ANGLES",
    "PAPER_DISTANCES",
    "TRUE_CLASSES",
    "BootstrapSettings",
    "ClassSummary",
    "Consistency",
    "CylinderMatch",
    "Deviation",
    "Distribution",
    "ErrorSummary",
    "Evaluation",
    "EvaluationSettings",
    "FloorPlanScore",
    "GridScore",
    "Interval",
    "IntervalErrors",
    "MapError",
    "Match",
    "Matches",
    "Matching",
    "MatchingSettings",
    "Outline",
    "OutlineSettings",
    "Tally",
    "Trajectory",
    "WallLengths",
    "WallMatch",
    "confusion_table",
    "consistency_table",
    "cylinder_table",
    "deviation_table",
    "deviations",
    "evaluate",
    "evaluation_document",
    "evaluation_tables",
    "floor_plan_tables",
    "map_error",
    "match_map",
    "pool",
    "pool_grid_scores",
    "score_grid",
    "summary_document",
    "table5",
    "tally_table",
    "trajectory_table",
    "true_grid",
    "wall_table",
]
