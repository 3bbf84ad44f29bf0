"""Model moves: change of class and split of landmarks, given all others."""

import math
from collections.abc import Sequence
from itertools import combinations

import numpy as np

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import FloatArray
from echoplan.geometry import directions, intersections
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.ping_likelihood import PingLikelihood
from echoplan.joint.search.acceptance import AcceptanceTest
from echoplan.joint.search.alternatives import alternatives_to
from echoplan.joint.search.corner_echoes import returns_sound
from echoplan.joint.search.refinement import approach
from echoplan.joint.trace import Decision, Reason, record_event

__all__ = ["reclassified", "split_joined_walls"]

# A landmark of no more supporting stations than this may be one wall per station.
_FEW_STATIONS = 3
# Greatest distance of a corner from the walls that form it, and from a short wall that it may replace [m].
_ON, _AT = 0.03, 0.1


def reclassified(
    likelihood: PingLikelihood, features: Sequence[Hypothesis], acceptance: AcceptanceTest
) -> list[Hypothesis]:
    """Replace landmarks by another class where that explains the pings better.

    Walls may become any class, corners and edges only walls: an object in a corner is hidden by it.
    """
    kept = list(features)
    for place, feature in enumerate(kept):
        if feature.is_known or feature.kind is Kind.CYLINDER:
            continue
        others = [*kept[:place], *kept[place + 1 :]]
        if feature.is_wall:
            alternatives = [*alternatives_to(likelihood, feature, others), *_crossings(likelihood, feature, others)]
        else:
            alternatives = alternatives_to(likelihood, feature, others, (Kind.WALL,))
        best = _better(alternatives, feature, others, acceptance)
        if best and acceptance.is_accepted(best, likelihood.log_densities(others)):
            record_event(Decision.CHANGED, feature, reason=Reason.BETTER_CLASS, becomes=best.kind)
            kept[place] = best
    return kept


def _crossings(likelihood: PingLikelihood, wall: Hypothesis, others: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Propose corners in place of a wall, where two stronger walls cross at a right angle near it."""
    square = [pair for pair in combinations(_stronger(wall, others), 2) if returns_sound(*pair)]
    crossings = [intersections(*pair) for pair in square]
    proposed = [likelihood.score(np.array([Kind.CORNER, *point, 0.0])) for point in crossings if _is_at(wall, point)]
    return likelihood.score_all(proposed, likelihood.log_densities(others), others)


def _better(
    alternatives: Sequence[Hypothesis], feature: Hypothesis, others: Sequence[Hypothesis], acceptance: AcceptanceTest
) -> Hypothesis | None:
    """Return the alternative with the greatest log evidence, or None if the landmark itself has more."""

    def penalised_llr(each: Hypothesis) -> float:
        """Return the penalised log-likelihood ratio, greater for a corner that makes short walls unnecessary."""
        return acceptance.penalised_llr(each) + acceptance.settings.min_log_likelihood_ratio * _spared_walls(
            each, feature, others
        )

    best = max(alternatives, key=penalised_llr, default=feature)
    return best if penalised_llr(best) > penalised_llr(feature) else None


def _spared_walls(alternative: Hypothesis, feature: Hypothesis, others: Sequence[Hypothesis]) -> int:
    """Return 1 for a corner on two stronger walls at a right angle, 0 for one on other stronger walls, -1 on none.

    The result is 0 for other alternatives.

    A corner that few stations detected from about one direction looks like a short wall across it, but every wall ends
    in corners. A wall that was detected at about one place looks like a corner, but no corner exists without walls.
    """
    if alternative.kind is not Kind.CORNER:
        return 0
    point = alternative.reflector[1:3]
    on = [line for line in _stronger(feature, others) if abs(float(point @ directions(line[0]) - line[1])) < _ON]
    square = any(returns_sound(*pair) for pair in combinations(on, 2))
    return int(square) + bool(on) - 1


def _stronger(wall: Hypothesis, others: Sequence[Hypothesis]) -> list[FloatArray]:
    """Return the lines of the walls with a greater log-likelihood ratio."""
    return [each.line for each in others if each.is_wall and each.llr > wall.llr]


def _is_at(wall: Hypothesis, point_xy: FloatArray) -> bool:
    """Return True if a point lies near the extent of a wall."""
    place = float(point_xy @ directions(wall.line[0] + math.pi / 2))
    across = abs(float(point_xy @ directions(wall.line[0])) - wall.line[1])
    return bool(max(across, wall.extent[0] - place, place - wall.extent[1]) < _AT)


def split_joined_walls(
    likelihood: PingLikelihood, features: list[Hypothesis], acceptance: AcceptanceTest
) -> list[Hypothesis]:
    """Replace walls and cylinders by walls, one for each of a few stations, where these explain the pings better.

    Any two walls detected from one station each have a cylinder that touches both, with fewer parameters. But its echo
    would be weaker, and detectable over a narrower angle. Faces of two boxes that are nearly in line look like one
    wall, although the readings of each fit a slightly different line.
    """
    asked = [each for each in features if each.kind in (Kind.CYLINDER, Kind.WALL) and _may_join(each, acceptance)]
    without = likelihood.log_densities_without(features) if asked else []
    for feature in asked:
        place = next(number for number, each in enumerate(features) if each is feature)
        others = [*features[:place], *features[place + 1 :]]
        walls = _walls_instead(likelihood, feature, others, without[place], acceptance=acceptance)
        if _explain_more(walls, feature, acceptance.settings.min_log_likelihood_ratio):
            record_event(Decision.CHANGED, feature, reason=Reason.BETTER_CLASS, becomes=Kind.WALL)
            features = [*others, *walls]
            without = likelihood.log_densities_without(features)
    return features


def _may_join(feature: Hypothesis, acceptance: AcceptanceTest) -> bool:
    """Return True if few stations support a landmark that has no track history."""
    least = 1 if feature.kind is Kind.CYLINDER else 2
    stations = (feature.llr_by_station > acceptance.settings.min_second_station_llr).sum()
    return bool(least <= stations <= _FEW_STATIONS and not feature.is_known)


def _explain_more(walls: Sequence[Hypothesis], joining: Hypothesis, accept: float) -> bool:
    """Return True if walls explain more than what joins them, at the cost of ``accept`` nats for each wall but one.

    A cylinder has three parameters, so two walls in its place cost nothing.
    """
    gain = sum(each.llr for each in walls) - joining.llr
    if joining.kind is Kind.CYLINDER:
        return gain > 0.0
    return len(walls) > 1 and gain > accept * (len(walls) - 1)


def _walls_instead(
    likelihood: PingLikelihood,
    joining: Hypothesis,
    others: Sequence[Hypothesis],
    log_densities: FloatArray,
    *,
    acceptance: AcceptanceTest,
) -> list[Hypothesis]:
    """Fit a wall to the pings of each supporting station, and return the accepted ones."""
    walls, measurements = list[Hypothesis](), likelihood.measurements
    schedule = ((4 * likelihood.noise, 0.06, 4), (likelihood.noise, 0.03, 4))
    for station in np.flatnonzero(joining.llr_by_station > acceptance.settings.min_second_station_llr):
        pings = joining.ping_scores.pings[joining.ping_scores.densities > log_densities[joining.ping_scores.pings]]
        own = pings[measurements.stations[pings] == station]
        start = joining.reflector if joining.is_wall else _touching(joining, measurements.centers[station])
        wall = likelihood.score(approach(measurements, likelihood.tables, start, own, schedule))
        wall = likelihood.rescored(wall, log_densities, [*others, *walls])
        if acceptance.is_accepted(wall, log_densities):
            walls.append(wall)
            log_densities = likelihood.log_densities([*others, *walls])
    return walls


def _touching(cylinder: Hypothesis, center_xy: FloatArray) -> FloatArray:
    """Return the wall that touches a cylinder at its specular point from a station."""
    away = cylinder.reflector[1:3] - center_xy
    normal = away / np.hypot(*away)
    touched = cylinder.reflector[1:3] - cylinder.reflector[3] * normal
    return np.array([Kind.WALL, np.arctan2(normal[1], normal[0]), touched @ normal, 0.0])
