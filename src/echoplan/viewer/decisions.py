"""Why landmarks are in a map or not: the estimator's decisions in words."""

import math
from collections.abc import Sequence

import numpy as np

from echoplan.acoustics.predicted_echo import Kind
from echoplan.geometry import wrap
from echoplan.joint.trace import Decision, Event, Reason
from echoplan.model import FeatureMap
from echoplan.viewer.sections import Definitions
from echoplan.viewer.wording import decimal, plural

__all__ = ["decisions_in_words"]

# Decisions about walls less than this apart in angle [rad] and offset [m], or points this far apart [m], are about one
# landmark: estimates move by centimetres between the rounds of the search.
_SAME_ANGLE, _SAME_PLACE = math.radians(5.0), 0.1

_REASONS = {
    Reason.UNDERDETERMINED: "no more readings than parameters",
    Reason.MISSED: "most stations that should detect it do not",
    Reason.WEAKLY_DETECTED: "its best station detects too little of it",
    Reason.SINGLE_STATION: "only one station supports it, and not over the whole beam",
    Reason.MULTIPATH: "an echo over two walls explains its readings",
    Reason.DUPLICATE: "a duplicate of another wall",
    Reason.INCONSISTENT: "most stations that should detect it do not, or detect it through a wall",
}


def decisions_in_words(events: Sequence[Event], feature_map: FeatureMap) -> Definitions:
    """Say why each landmark is in the map, and why others that were in it once are not.

    Parameters
    ----------
    events : sequence of Event
        Decisions in the order in which they were made, in the frame of the map.
    feature_map : FeatureMap
        The map that came of them.

    Returns
    -------
    Definitions
        Landmarks and sentences: first those in the map, then those that were removed or changed.
    """
    kept, gone = dict[tuple[str, int], str](), list[tuple[str, str]]()
    for own in _by_landmark(events):
        births = [each for each in own if each.decision is Decision.ADDED]
        name = _name_in_map(own[-1], feature_map)
        if name and births:
            kept[name] = _added(births[-1])
        elif births and own[-1] is not births[-1]:
            gone.append((_place(own[-1]), _lost(own[-1])))
    items = [(f"{kind} {number}", text) for (kind, number), text in sorted(kept.items())]
    return Definitions(title="Why landmarks are in the map or not", items=(*items, *gone), folded=True)


def _by_landmark(events: Sequence[Event]) -> list[list[Event]]:
    """Collect the decisions about each landmark."""
    landmarks: list[list[Event]] = []
    for event in events:
        same = next((each for each in landmarks if _are_one(each[-1], event)), None)
        if same is None:
            landmarks.append([event])
        else:
            same.append(event)
    return landmarks


def _are_one(one: Event, other: Event) -> bool:
    """Return True if two decisions are about the same landmark."""
    return (one.kind is Kind.WALL) == (other.kind is Kind.WALL) and _is_near(one, other.parameters)


def _is_near(event: Event, parameters: Sequence[float]) -> bool:
    if event.kind is Kind.WALL:
        turn = abs(float(wrap(event.parameters[0] - parameters[0])))
        return turn < _SAME_ANGLE and abs(event.parameters[1] - parameters[1]) < _SAME_PLACE
    return math.dist(event.parameters[:2], parameters[:2]) < _SAME_PLACE


def _name_in_map(event: Event, feature_map: FeatureMap) -> tuple[str, int] | None:
    """Return the landmark's class and number in the map, None if it is not there."""
    if event.kind is Kind.WALL:
        groups = {"wall": [(each.normal_angle, each.offset) for each in feature_map.walls]}
    else:
        groups = {
            "corner": [tuple(np.asarray(each.position_xy)) for each in feature_map.corners],
            "cylinder": [tuple(np.asarray(each.center_xy)) for each in feature_map.cylinders],
        }
    for kind, places in groups.items():
        for number, place in enumerate(places):
            if _is_near(event, place):
                return kind, number
    return None


def _place(event: Event) -> str:
    """Say where a landmark that is not in the map would be."""
    kind = event.kind.name.lower()
    if event.kind is Kind.WALL:
        angle, offset = event.parameters
        return f"{kind} with normal {decimal(math.degrees(angle), 1)}° and offset {decimal(offset, 3)} m"
    x, y = event.parameters[:2]
    return f"{kind} at ({decimal(x, 3)}, {decimal(y, 3)}) m"


def _added(event: Event) -> str:
    ratio, threshold = decimal(event.log_likelihood_ratio, 1), decimal(event.threshold, 1)
    return f"added: log-likelihood ratio {ratio} > {threshold}; {_terms(event)}"


def _lost(event: Event) -> str:
    if event.becomes is not None:
        return f"changed: a {event.becomes.name.lower()} explains its readings better; {_terms(event)}"
    if event.reason is Reason.EVIDENCE:
        ratio, threshold = decimal(event.log_likelihood_ratio, 1), decimal(event.threshold, 1)
        return f"{event.decision}: log-likelihood ratio {ratio} < {threshold}; {_terms(event)}"
    return f"{event.decision}: {_REASONS[event.reason]}; {_terms(event)}"


def _terms(event: Event) -> str:
    """Give the two parts of the log-likelihood ratio, and the station that speaks most against the landmark."""
    terms = f"detections +{decimal(event.detections, 1)} from {plural(event.stations, 'station')}"
    if event.worst_station is None:
        return terms
    return f"{terms}, missed detections {decimal(event.missed_detections, 1)}, most at station {event.worst_station}"
