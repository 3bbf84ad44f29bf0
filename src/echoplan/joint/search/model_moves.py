"""Reclassification: features that were taken for something else when not all others were known."""

import math
from collections.abc import Collection, Sequence
from itertools import combinations

import numpy as np

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import FloatArray
from echoplan.geometry import directions, intersections, wrap
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.ping_likelihood import PingLikelihood
from echoplan.joint.search.acceptance import AcceptanceTest
from echoplan.joint.search.alternatives import alternatives_to
from echoplan.joint.search.refinement import approach
from echoplan.joint.search.specular_points import returns_sound
from echoplan.joint.trace import Decision, Reason, record_event

__all__ = ["reclassified", "split_joined_walls"]

# What is known from no more stations may be as many walls.
_FEW_STATIONS = 3
# A corner is as near as this to the walls that make it, and to a short wall that it looks like [m].
_ON, _AT = 0.03, 0.1
# Both sides of a thin wall are turned so far from each other [rad].
_OPPOSITE = math.radians(170.0)
# What may seem to join them while features are searched for, and in the end.
_JOINING, _AT_LAST = (Kind.CYLINDER, Kind.WALL), (Kind.CORNER,)


def reclassified(
    likelihood: PingLikelihood, features: Sequence[Hypothesis], acceptance: AcceptanceTest
) -> list[Hypothesis]:
    """Take walls for what explains their pings best: of poses in error walls bear most, and come before cylinders.

    Corners may turn out to be walls, but no cylinders: what stands in a corner hides in it.  What few stations heard of
    a corner looks like a cylinder behind it, and is none if a corner on a wall explains more.  Both sides of a thin
    wall, heard where they are opposite to each other, look like a corner that is heard from everywhere.

    Parameters
    ----------
    likelihood : PingLikelihood
        The pings.
    features : sequence of Hypothesis
        The features, judged beside each other.
    acceptance : AcceptanceTest
        When a rival is believed.

    Returns
    -------
    list of Hypothesis
        Some of them of another kind, or two walls for a corner.
    """
    kept = split_joined_walls(likelihood, list(features), acceptance, kinds=_AT_LAST)
    for place, feature in enumerate(kept):
        if feature.is_known:
            continue
        # A corner is heard over a wider angle: if that is why it does not hold, what looked like a cylinder is neither.
        is_round = feature.kind is Kind.CYLINDER
        others = [*kept[:place], *kept[place + 1 :]]
        best = _better(_alternatives(likelihood, feature, others), feature, others, acceptance)
        if best and (is_round or acceptance.is_accepted(best, likelihood.log_densities(others))):
            record_event(Decision.CHANGED, feature, reason=Reason.BETTER_CLASS, becomes=best.kind)
            kept[place] = best
    return kept


def _alternatives(likelihood: PingLikelihood, feature: Hypothesis, others: Sequence[Hypothesis]) -> list[Hypothesis]:
    if feature.is_wall:
        return [*alternatives_to(likelihood, feature, others), *_crossings(likelihood, feature, others)]
    if feature.kind is Kind.CYLINDER:
        return _on_walls(likelihood, feature, others)
    return alternatives_to(likelihood, feature, others, (Kind.WALL,))


def _on_walls(likelihood: PingLikelihood, cylinder: Hypothesis, others: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Propose corners in place of a cylinder, on walls near which the pings want them; to rays both look alike."""
    if likelihood.hearing.cone:
        return []
    (corner,) = alternatives_to(likelihood, cylinder, others, (Kind.CORNER,))
    point = corner.reflector[1:3]
    normals = [(directions(angle), offset) for angle, offset in _stronger(cylinder, others)]
    feet = [point + (offset - point @ normal) * normal for normal, offset in normals]
    near = [foot for foot in feet if math.dist(foot, point) < _AT]
    proposed = [likelihood.score(np.array([Kind.CORNER, *foot, 0.0])) for foot in near]
    return likelihood.score_all(proposed, likelihood.log_densities(others), others)


def _crossings(likelihood: PingLikelihood, wall: Hypothesis, others: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Propose corners in place of a wall, where others cross at right angles."""
    square = [pair for pair in combinations(_stronger(wall, others), 2) if returns_sound(*pair)]
    crossings = [intersections(*pair) for pair in square]
    proposed = [likelihood.score(np.array([Kind.CORNER, *point, 0.0])) for point in crossings if _is_at(wall, point)]
    return likelihood.score_all(proposed, likelihood.log_densities(others), others)


def _better(
    alternatives: Sequence[Hypothesis], feature: Hypothesis, others: Sequence[Hypothesis], acceptance: AcceptanceTest
) -> Hypothesis | None:
    """Choose the rival that is worth most, if that is more than the feature is."""

    def log_evidence_without_bias(each: Hypothesis) -> float:
        return acceptance.log_evidence_without_bias(each) + acceptance.settings.accept * _spared_walls(
            each, feature, others
        )

    best = max(alternatives, key=log_evidence_without_bias, default=feature)
    return best if log_evidence_without_bias(best) > log_evidence_without_bias(feature) else None


def _spared_walls(alternative: Hypothesis, feature: Hypothesis, others: Sequence[Hypothesis]) -> int:
    """Tell how many walls need not be assumed anew if something is a corner and no wall: one less than it lies on.

    A corner that few stations heard, all from about one direction, looks like a short wall across it; but every wall
    ends in corners.  A wall that stations heard at about one place looks like a corner; but no corner is without walls.
    """
    if alternative.kind is not Kind.CORNER or feature.kind is Kind.CYLINDER:
        return 0
    point = alternative.reflector[1:3]
    on = [line for line in _stronger(feature, others) if abs(float(point @ directions(line[0]) - line[1])) < _ON]
    square = any(returns_sound(*pair) for pair in combinations(on, 2))
    return int(square) + bool(on) - 1


def _stronger(wall: Hypothesis, others: Sequence[Hypothesis]) -> list[FloatArray]:
    return [each.line for each in others if each.is_wall and each.total > wall.total]


def _is_at(wall: Hypothesis, point_xy: FloatArray) -> bool:
    place = float(point_xy @ directions(wall.line[0] + math.pi / 2))
    across = abs(float(point_xy @ directions(wall.line[0])) - wall.line[1])
    return bool(max(across, wall.extent[0] - place, place - wall.extent[1]) < _AT)


def split_joined_walls(
    likelihood: PingLikelihood,
    features: list[Hypothesis],
    acceptance: AcceptanceTest,
    *,
    kinds: Collection[Kind] = _JOINING,
) -> list[Hypothesis]:
    """Replace features by walls, one for each of few stations, where these explain the pings better.

    Any two walls that were heard from one station each have a cylinder that touches both, and it needs fewer
    parameters; but it would be heard less loud, and so over a narrower angle.  Sides of two boxes that stand nearly in
    line look like one wall, though each of them by itself says a little otherwise.

    Parameters
    ----------
    likelihood : PingLikelihood
        The pings.
    features : list of Hypothesis
        The features, judged beside each other.
    acceptance : AcceptanceTest
        When a wall is believed.
    kinds : collection of Kind, optional
        Which of them to ask.

    Returns
    -------
    list of Hypothesis
        The features, some of them replaced.
    """
    asked = [each for each in features if each.kind in kinds and _may_join(each, acceptance)]
    without = likelihood.log_densities_without(features) if asked else []
    for feature in asked:
        place = next(number for number, each in enumerate(features) if each is feature)
        others = [*features[:place], *features[place + 1 :]]
        walls = _walls_instead(likelihood, feature, others, without[place], acceptance=acceptance)
        if _explain_more(walls, feature, acceptance.settings.accept):
            record_event(Decision.CHANGED, feature, reason=Reason.BETTER_CLASS, becomes=Kind.WALL)
            features = [*others, *walls]
            without = likelihood.log_densities_without(features)
    return features


def _may_join(feature: Hypothesis, acceptance: AcceptanceTest) -> bool:
    least = 1 if feature.kind is Kind.CYLINDER else 2
    stations = (feature.llr_by_station > acceptance.settings.second_station).sum()
    return bool(least <= stations <= _FEW_STATIONS and not feature.is_known)


def _explain_more(walls: Sequence[Hypothesis], joining: Hypothesis, accept: float) -> bool:
    """Whether walls explain more than what joins them: two parameters each, as one wall has; a cylinder has three."""
    gain = sum(each.total for each in walls) - joining.total
    if joining.kind is Kind.CYLINDER:
        return gain > 0.0
    possible = len(walls) > 1 if joining.is_wall else _are_back_to_back(walls)
    return possible and gain > accept * (len(walls) - 1)


def _are_back_to_back(walls: Sequence[Hypothesis]) -> bool:
    angles = [each.line[0] for each in walls]
    return len(walls) == 2 and abs(float(wrap(angles[1] - angles[0]))) > _OPPOSITE


def _walls_instead(
    likelihood: PingLikelihood,
    joining: Hypothesis,
    others: Sequence[Hypothesis],
    log_densities: FloatArray,
    *,
    acceptance: AcceptanceTest,
) -> list[Hypothesis]:
    walls, measurements = list[Hypothesis](), likelihood.measurements
    pose_model = ((4 * likelihood.noise, 0.06, 4), (likelihood.noise, 0.03, 4))
    for station in np.flatnonzero(joining.llr_by_station > acceptance.settings.second_station):
        pings = joining.ping_scores.pings[joining.ping_scores.densities > log_densities[joining.ping_scores.pings]]
        own = pings[measurements.stations[pings] == station]
        start = joining.reflector if joining.is_wall else _touching(joining, measurements.centers[station])
        wall = likelihood.score(approach(measurements, likelihood.hearing, start, own, pose_model))
        wall = likelihood.rescored(wall, log_densities, [*others, *walls])
        if acceptance.is_accepted(wall, log_densities):
            walls.append(wall)
            log_densities = likelihood.log_densities([*others, *walls])
    return walls


def _touching(cylinder: Hypothesis, center_xy: FloatArray) -> FloatArray:
    """Make a wall that touches a cylinder where a station hears it."""
    away = cylinder.reflector[1:3] - center_xy
    normal = away / np.hypot(*away)
    touched = cylinder.reflector[1:3] - cylinder.reflector[3] * normal
    return np.array([Kind.WALL, np.arctan2(normal[1], normal[0]), touched @ normal, 0.0])
