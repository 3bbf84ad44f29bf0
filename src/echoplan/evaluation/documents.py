"""Evaluations as documents ready for JSON: the keys are these and stay.

Of one map (``evaluation_document``)::

    method            name of the method
    walls, corners, cylinders
                      wanted, found, right, duplicate, spurious: counts; recall, precision;
                      consistency; deviations: a list with an entry for each true object, with
                      index (from 1), detected_by, estimate (its id in map.json), distance_mm
                      and of a wall angle_deg, of a cylinder radius_mm (estimated less true);
                      walls and cylinders as in truth.json, corners by x, then y
    confusion         {class in truth: {class in map: count}}
    map_error         mean_mm, median_mm, hausdorff_mm, map_to_truth_mm, truth_to_map_mm
    lengths           drawn_m, correct_m, wanted_m, covered_m; recall, precision: numbers; walked_through: drawn walls
                      that the true path crosses
    openings          counts as of walls; recall, precision: numbers; width: errors
    wall_ends         errors along the wall, positive where a wall is drawn too long
    poses             count, ate_mm, heading_deg; null where poses cannot be compared

Of several maps (``summary_document``)::

    recordings        how many
    walls, corners, cylinders
                      counts as above; recall, precision: intervals; consistency; distance_mm
                      and of walls angle_deg, of cylinders radius_mm (without sign): distributions
    confusion, lengths, openings, wall_ends
                      as above
    map_error_mm, hausdorff_mm, ate_mm, heading_deg
                      distributions over recordings

An interval is ``value, low, high``; a distribution is ``count, mean, median, p95, rms, max``, of which mean to rms
are intervals; a consistency is ``count, parameters, mean_nees, accepted_low, accepted_high, share_inside``; errors
are ``count, mean_mm`` (absolute), ``bias_mm`` (signed) and ``share_inside`` (of the 95 % intervals that the map gives).
What is not known is null.
"""

from dataclasses import asdict
from math import degrees, isfinite
from typing import Any, TypeAlias

from echoplan.arrays import IntArray
from echoplan.evaluation.bootstrap import Distribution, Interval
from echoplan.evaluation.confusion import MAP_CLASSES, TRUE_CLASSES
from echoplan.evaluation.consistency import Consistency
from echoplan.evaluation.deviations import Deviation, deviations
from echoplan.evaluation.evaluation import Evaluation
from echoplan.evaluation.floor_plan import FloorPlanScore
from echoplan.evaluation.intervals import IntervalErrors
from echoplan.evaluation.matches import CylinderMatch, Match, WallMatch
from echoplan.evaluation.outlines import MapError
from echoplan.evaluation.summary import ErrorSummary
from echoplan.evaluation.trajectory import Trajectory
from echoplan.model import FeatureClass

__all__ = ["Document", "evaluation_document", "summary_document"]

Document: TypeAlias = dict[str, Any]

_KEYS = {FeatureClass.WALL: "walls", FeatureClass.CORNER: "corners", FeatureClass.CYLINDER: "cylinders"}
_MILLIMETRES = 1000.0
_DEGREES = degrees(1.0)


def evaluation_document(evaluation: Evaluation) -> Document:
    """Write an evaluation as plain numbers.

    Parameters
    ----------
    evaluation : Evaluation
        Of one map.

    Returns
    -------
    dict
        Keys as at the head of this module.
    """
    classes = {
        _KEYS[name]: {
            **asdict(matching.tally),
            "recall": _number(matching.tally.recall),
            "precision": _number(matching.tally.precision),
            "consistency": _consistency(evaluation.consistency[name]),
            "deviations": [_deviation(name, each) for each in deviations(matching)],
        }
        for name, matching in evaluation.matches.by_class.items()
    }
    return {
        "method": evaluation.method,
        **classes,
        "confusion": _confusion(evaluation.confusion),
        "map_error": _map_error(evaluation.map_error),
        **_floor_plan(evaluation.floor_plan),
        "poses": _poses(evaluation.trajectory),
    }


def summary_document(summary: ErrorSummary) -> Document:
    """Write a summary as plain numbers.

    Parameters
    ----------
    summary : ErrorSummary
        Of several maps.

    Returns
    -------
    dict
        Keys as at the head of this module.
    """
    classes = {
        _KEYS[name]: {
            **asdict(of_class.tally),
            "recall": _interval(of_class.recall),
            "precision": _interval(of_class.precision),
            "consistency": _consistency(of_class.consistency),
            "distance_mm": _distribution(of_class.distance, unit=_MILLIMETRES),
        }
        for name, of_class in summary.classes.items()
    }
    classes["walls"]["angle_deg"] = _distribution(summary.wall_angle, unit=_DEGREES)
    classes["cylinders"]["radius_mm"] = _distribution(summary.cylinder_radius, unit=_MILLIMETRES)
    return {
        "recordings": summary.recordings,
        **classes,
        "confusion": _confusion(summary.confusion),
        **_floor_plan(summary.floor_plan),
        "map_error_mm": _distribution(summary.map_error, unit=_MILLIMETRES),
        "hausdorff_mm": _distribution(summary.hausdorff, unit=_MILLIMETRES),
        "ate_mm": _distribution(summary.position, unit=_MILLIMETRES),
        "heading_deg": _distribution(summary.heading, unit=_DEGREES),
    }


def _number(value: float, unit: float = 1.0) -> float | None:
    return float(value) * unit if isfinite(value) else None


def _interval(interval: Interval, unit: float = 1.0) -> Document:
    return {name: _number(value, unit) for name, value in asdict(interval).items()}


def _distribution(distribution: Distribution, *, unit: float) -> Document:
    return {
        "count": distribution.count,
        "mean": _interval(distribution.mean, unit),
        "median": _interval(distribution.median, unit),
        "p95": _interval(distribution.percentile95, unit),
        "rms": _interval(distribution.rms, unit),
        "max": _number(distribution.maximum, unit),
    }


def _consistency(consistency: Consistency) -> Document:
    low, high = consistency.accepted
    return {
        "count": len(consistency.nees),
        "parameters": consistency.parameters,
        "mean_nees": _number(consistency.mean),
        "accepted_low": _number(low),
        "accepted_high": _number(high),
        "share_inside": _number(consistency.share_inside),
    }


def _deviation(name: FeatureClass, deviation: Deviation[Match]) -> Document:
    match = deviation.match
    entry: Document = {
        "index": deviation.index,
        "detected_by": deviation.detected_by,
        "estimate": match.estimate if match else None,
        "distance_mm": match.distance * _MILLIMETRES if match else None,
    }
    if name == FeatureClass.WALL:
        entry["angle_deg"] = match.angle * _DEGREES if isinstance(match, WallMatch) else None
    if name == FeatureClass.CYLINDER:
        entry["radius_mm"] = match.radius_error * _MILLIMETRES if isinstance(match, CylinderMatch) else None
    return entry


def _confusion(confusion: IntArray) -> Document:
    return {
        true: dict(zip(MAP_CLASSES, row, strict=True))
        for true, row in zip(TRUE_CLASSES, confusion.tolist(), strict=True)
    }


def _map_error(error: MapError) -> Document:
    return {
        "mean_mm": _number(error.mean, _MILLIMETRES),
        "median_mm": _number(error.median, _MILLIMETRES),
        "hausdorff_mm": _number(error.hausdorff, _MILLIMETRES),
        "map_to_truth_mm": _number(error.map_to_truth.mean, _MILLIMETRES),
        "truth_to_map_mm": _number(error.truth_to_map.mean, _MILLIMETRES),
    }


def _floor_plan(score: FloorPlanScore) -> Document:
    lengths, openings = score.lengths, score.openings
    return {
        "lengths": {
            **{f"{name}_m": getattr(lengths, name) for name in ("drawn", "correct", "wanted", "covered")},
            "recall": _number(lengths.recall),
            "precision": _number(lengths.precision),
            "walked_through": lengths.walked_through,
        },
        "openings": {
            **asdict(openings),
            "recall": _number(openings.recall),
            "precision": _number(openings.precision),
            "width": _errors(score.opening_widths),
        },
        "wall_ends": _errors(score.wall_ends),
    }


def _errors(errors: IntervalErrors) -> Document:
    return {
        "count": len(errors.errors),
        "mean_mm": _number(errors.mean, _MILLIMETRES),
        "bias_mm": _number(errors.bias, _MILLIMETRES),
        "share_inside": _number(errors.share_inside),
    }


def _poses(trajectory: Trajectory | None) -> Document | None:
    if trajectory is None:
        return None
    return {
        "count": len(trajectory.distances),
        "ate_mm": trajectory.absolute_error * _MILLIMETRES,
        "heading_deg": trajectory.heading_error * _DEGREES,
        "rpe_mm": _number(trajectory.relative_error, _MILLIMETRES),
        "rpe_deg": _number(trajectory.relative_heading_error, _DEGREES),
        "positions": _consistency(trajectory.positions),
        "headings": _consistency(trajectory.headings),
    }
