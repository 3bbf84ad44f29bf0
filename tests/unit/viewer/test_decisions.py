"""Why landmarks are in a map or not, in words."""

import math
from dataclasses import replace
from typing import Any

from echoplan.acoustics.predicted_echo import Kind
from echoplan.geometry import directions
from echoplan.joint.trace import Decision, Event, Reason
from echoplan.viewer import decisions_in_words
from helpers import maps

FOUND = maps.drawn(maps.wall((0.0, 3.0), (4.0, 3.0)))


def event(**changes: Any) -> Event:
    values: dict[str, Any] = {
        "decision": Decision.ADDED,
        "reason": Reason.EVIDENCE,
        "kind": Kind.WALL,
        "parameters": (FOUND.walls[0].normal_angle, FOUND.walls[0].offset),
        "log_likelihood_ratio": 31.0,
        "threshold": 12.0,
        "detections": 31.0,
        "missed_detections": 0.0,
        "stations": 3,
        "worst_station": None,
    }
    return Event(**(values | changes))


def test_a_wall_in_the_map_says_why_it_was_added() -> None:
    (item,) = decisions_in_words([event()], FOUND).items
    assert item == ("wall 0", "added: log-likelihood ratio 31.0 > 12.0; detections +31.0 from 3 stations")


def round_wall(radius: float) -> Event:
    """A round wall whose centre is 2 m from the middle of the wall in the map."""
    (wall,) = FOUND.walls
    x, y = wall.endpoints_xy.mean(axis=0) - 2.0 * directions(wall.normal_angle)
    return event(kind=Kind.ROUND, parameters=(float(x), float(y), radius))


def test_a_chord_of_a_round_wall_says_so() -> None:
    (name, text), *_ = decisions_in_words([event(), round_wall(2.0)], FOUND).items
    assert name == "wall 0"
    assert text.startswith("part of a round wall about (2.000, ")
    assert text.endswith("m with radius 2.000 m, detections +31.0 from 3 stations")


def test_a_round_wall_that_was_removed_does_not_matter() -> None:
    added = round_wall(2.0)
    removed = replace(added, decision=Decision.REMOVED)
    (name, text), *_ = decisions_in_words([event(), added, removed], FOUND).items
    assert name == "wall 0"
    assert text.startswith("added: log-likelihood ratio")


def test_a_round_wall_elsewhere_does_not_matter() -> None:
    (name, text), *_ = decisions_in_words([event(), round_wall(1.5)], FOUND).items
    assert name == "wall 0"
    assert text.startswith("added: log-likelihood ratio")


def test_a_wall_that_was_removed_says_where_it_was_and_which_station_missed_it() -> None:
    there = {"parameters": (math.pi / 2 - 2.0 * math.pi, 7.0)}
    lost = event(decision=Decision.REMOVED, log_likelihood_ratio=9.1, missed_detections=-21.9, worst_station=4, **there)
    _, (name, text) = decisions_in_words([event(**there), lost], FOUND).items
    assert name == "wall with normal 90.0° and offset 7.000 m"
    assert text.startswith("removed: log-likelihood ratio 9.1 < 12.0; detections +31.0 from 3 stations, ")
    assert text.endswith(", missed detections -21.9, most at station 4")


def test_what_was_never_in_the_map_is_not_listed() -> None:
    rejected = event(decision=Decision.REJECTED, reason=Reason.SINGLE_STATION, parameters=(0.3, 2.0))
    assert [name for name, _ in decisions_in_words([rejected], FOUND).items] == ["wall 0"]


def test_a_wall_that_no_decision_is_near_says_so() -> None:
    (item,) = decisions_in_words([event(parameters=(0.3, 2.0))], FOUND).items
    assert item[0] == "wall 0"
    assert item[1].startswith("no decision near this place")


def test_a_method_that_records_no_decisions_has_nothing_to_say() -> None:
    assert decisions_in_words([], FOUND).items == ()


def test_a_change_of_class_names_the_new_class() -> None:
    there = {"parameters": (1.0, 2.0, 0.1), "kind": Kind.CYLINDER}
    changed = event(decision=Decision.CHANGED, reason=Reason.BETTER_CLASS, becomes=Kind.CORNER, **there)
    _, item = decisions_in_words([event(**there), changed], FOUND).items
    assert item[0] == "cylinder at (1.000, 2.000) m"
    assert item[1].startswith("changed: a corner explains its readings better")


def test_every_reason_has_a_sentence() -> None:
    for reason in Reason:
        lost = event(decision=Decision.REMOVED, reason=reason, becomes=None, parameters=(0.3, 2.0))
        added = event(parameters=(0.3, 2.0))
        if reason is not Reason.BETTER_CLASS:
            assert decisions_in_words([added, lost], FOUND).items[1][1].startswith("removed: ")
