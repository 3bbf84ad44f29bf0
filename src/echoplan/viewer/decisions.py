"""Why landmarks are in a map or not: the estimator's decisions in words."""

import math
from collections.abc import Sequence

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

_TITLE = "Why landmarks are in the map or not"
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
        The resulting map.

    Returns
    -------
    Definitions
        Landmarks and sentences: first those in the map, then those that were removed or changed; empty without
        decisions, as of methods that record none.
    """
    if not events:
        return Definitions(title=_TITLE, items=(), folded=True)
    landmarks, births = _by_landmark(events), [each for each in events if each.decision is Decision.ADDED]
    places = _places(feature_map)
    there = [(name, _why_curved(place, landmarks) or _why_there(place, births)) for name, place in places.items()]
    gone = [
        (_name_of(own[-1]), _why_gone(own[-1]))
        for own in landmarks
        if _was_removed(own) and not any(_is_near(own[-1], place) for place in places.values())
    ]
    return Definitions(title=_TITLE, items=(*there, *gone), folded=True)


def _places(feature_map: FeatureMap) -> dict[str, tuple[bool, Sequence[float]]]:
    """Return by the name of each landmark whether it is a wall, and its first two parameters."""
    walls = {f"wall {n}": (True, (each.normal_angle, each.offset)) for n, each in enumerate(feature_map.walls)}
    corners = {f"corner {n}": (False, each.position_xy.tolist()) for n, each in enumerate(feature_map.corners)}
    cylinders = {f"cylinder {n}": (False, each.center_xy.tolist()) for n, each in enumerate(feature_map.cylinders)}
    return walls | corners | cylinders


def _by_landmark(events: Sequence[Event]) -> list[list[Event]]:
    """Collect the decisions about each landmark."""
    landmarks: list[list[Event]] = []
    for event in events:
        same = next(
            (each for each in landmarks if _is_near(each[-1], (event.kind is Kind.WALL, event.parameters))), None
        )
        if same is None:
            landmarks.append([event])
        else:
            same.append(event)
    return landmarks


def _was_removed(decisions: Sequence[Event]) -> bool:
    """Return True if the last decision about a landmark that was in the map took it out of it."""
    made = [each.decision for each in decisions]
    return Decision.ADDED in made and made[-1] is not Decision.ADDED


def _is_near(event: Event, place: tuple[bool, Sequence[float]]) -> bool:
    """Return True if a decision is about the landmark at a place."""
    is_wall, parameters = place
    if is_wall is not (event.kind is Kind.WALL):
        return False
    if is_wall:
        turn = abs(float(wrap(event.parameters[0] - parameters[0])))
        return turn < _SAME_ANGLE and abs(event.parameters[1] - parameters[1]) < _SAME_PLACE
    return math.dist(event.parameters[:2], parameters[:2]) < _SAME_PLACE


def _name_of(event: Event) -> str:
    """Say where a landmark that is not in the map would be."""
    kind = "round wall" if event.kind is Kind.ROUND else event.kind.name.lower()
    if event.kind is Kind.WALL:
        angle, offset = event.parameters
        return f"{kind} with normal {decimal(math.degrees(wrap(angle)), 1)}° and offset {decimal(offset, 3)} m"
    x, y = event.parameters[:2]
    return f"{kind} at ({decimal(x, 3)}, {decimal(y, 3)}) m"


def _why_curved(place: tuple[bool, Sequence[float]], landmarks: Sequence[Sequence[Event]]) -> str:
    """Say of which round wall of the map a wall is a chord; empty if of none."""
    is_wall, parameters = place
    for event in (own[-1] for own in landmarks):
        if is_wall and event.kind is Kind.ROUND and event.decision is Decision.ADDED:
            x, y, radius = event.parameters
            offset = x * math.cos(parameters[0]) + y * math.sin(parameters[0]) + radius
            if abs(offset - parameters[1]) < _SAME_PLACE:
                about = f"({decimal(x, 3)}, {decimal(y, 3)}) m with radius {decimal(radius, 3)} m"
                return f"part of a round wall about {about}, {_terms(event)}"
    return ""


def _why_there(place: tuple[bool, Sequence[float]], births: Sequence[Event]) -> str:
    event = next((each for each in reversed(births) if _is_near(each, place)), None)
    if event is None:
        return "no decision near this place: drawn where two walls meet, or moved since by a correction of poses"
    ratio, threshold = decimal(event.log_likelihood_ratio, 1), decimal(event.threshold, 1)
    return f"added: log-likelihood ratio {ratio} > {threshold}; {_terms(event)}"


def _why_gone(event: Event) -> str:
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
