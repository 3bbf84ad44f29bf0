"""Events of decisions about landmarks."""

import logging
from functools import cache

import numpy as np
import pytest

from echoplan.acoustics.predicted_echo import Kind
from echoplan.joint.mapper import JointMapper
from echoplan.joint.trace import Decision, Event, Reason, collect_events
from echoplan.model import FeatureMap
from library.rooms import random_simulation

pytestmark = pytest.mark.slow


@cache
def mapped() -> tuple[FeatureMap, tuple[Event, ...]]:
    simulation = random_simulation(501)
    mapper = JointMapper(simulation.rig)
    for sweep in simulation:
        mapper.add(sweep)
    with collect_events() as events:
        found = mapper.result()
    return found, tuple(events)


def added() -> list[Event]:
    return [each for each in mapped()[1] if each.decision is Decision.ADDED]


def test_each_wall_of_a_map_was_added_with_a_log_likelihood_ratio_above_the_threshold() -> None:
    walls = [each for each in added() if each.kind is Kind.WALL]
    for wall in mapped()[0].walls:
        near = [each for each in walls if np.allclose(each.parameters, (wall.normal_angle, wall.offset), atol=0.1)]
        assert near
        assert all(each.log_likelihood_ratio > each.threshold == 12.0 for each in near)


def test_detections_and_missed_detections_add_up_to_the_log_likelihood_ratio() -> None:
    for each in added():
        assert each.detections > 0.0 >= each.missed_detections
        assert each.detections + each.missed_detections == pytest.approx(each.log_likelihood_ratio, abs=0.01)
        assert (each.worst_station is None) == (each.missed_detections == 0.0)


def test_rejected_landmarks_have_the_reason_of_the_failed_test() -> None:
    refused = [each for each in mapped()[1] if each.decision in (Decision.REMOVED, Decision.REJECTED)]
    assert refused
    for each in refused:
        assert (each.reason is Reason.EVIDENCE) <= (each.log_likelihood_ratio <= each.threshold)


def test_collecting_events_does_not_change_the_map() -> None:
    simulation = random_simulation(501)
    mapper = JointMapper(simulation.rig)
    for sweep in simulation:
        mapper.add(sweep)
    again = mapper.result()
    assert [each.offset for each in again.walls] == [each.offset for each in mapped()[0].walls]


def test_collecting_events_ends_with_the_block() -> None:
    logger = logging.getLogger("echoplan.joint")
    before = (logger.level, list(logger.handlers))
    with collect_events():
        assert logger.isEnabledFor(logging.DEBUG)
    assert (logger.level, list(logger.handlers)) == before


def test_an_event_moves_with_the_frame() -> None:
    wall = next(each for each in added() if each.kind is Kind.WALL)
    angle, offset = wall.translated((2.0, -1.0)).parameters
    assert angle == wall.parameters[0]
    assert offset == pytest.approx(wall.parameters[1] + 2.0 * np.cos(angle) - np.sin(angle))
    point = next(each for each in added() if each.kind is not Kind.WALL)
    assert point.translated((2.0, -1.0)).parameters[:2] == pytest.approx(np.add(point.parameters[:2], (2.0, -1.0)))
