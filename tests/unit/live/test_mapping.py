import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from echoplan.joint.mapper import JointMapper
from echoplan.live.drawing import drawing_of
from echoplan.live.mapping import check_map, draw_map, sensor_faults
from echoplan.live.survey import Survey
from echoplan.mapping import map_source
from echoplan.model import Sweep
from echoplan.preprocessing import SensorFaultKind
from echoplan.sources import open_source
from helpers.fed import RIG, swept


def surveyed(count: int, *, sensor: int, reading: float) -> Survey:
    """Sweeps of a robot that drives and turns, in which one sensor always reads the same."""
    survey, ranges = Survey(name="bench", rig=RIG), swept().ranges
    readings = np.where(swept().sensor_ids == sensor, reading, ranges)
    for number in range(count):
        survey = survey.with_sweep(swept(pose=(float(number), 0.0, 1.5 * number), ranges=readings))
    return survey


@pytest.mark.parametrize("reading", [np.inf, np.nan, -np.inf])
def test_a_silent_sensor_is_found_in_two_sweeps(reading: float) -> None:
    (fault,) = sensor_faults(surveyed(2, sensor=1, reading=reading)).sensors
    assert (fault.sensor_id, fault.kind) == (1, SensorFaultKind.DEAD)
    assert not sensor_faults(surveyed(1, sensor=1, reading=reading)).sensors


def test_a_stuck_sensor_is_found_in_three_sweeps() -> None:
    (fault,) = sensor_faults(surveyed(3, sensor=0, reading=0.431)).sensors
    assert (fault.sensor_id, fault.kind, fault.value) == (0, SensorFaultKind.STUCK, 0.431)


def test_a_survey_without_sweeps_has_no_faults() -> None:
    assert not sensor_faults(Survey(name="bench", rig=RIG)).sensors


@pytest.fixture
def square() -> Survey:
    """A drive through a square room, with a dead sensor."""
    source = open_source("sim:square")
    survey = Survey(name="bench", rig=source.rig)
    for sweep in source:
        survey = survey.with_sweep(replace(sweep, ranges=np.where(sweep.sensor_ids == 0, np.inf, sweep.ranges)))
    return survey


@pytest.fixture
def added(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Numbers of the sweeps that are added to a mapper."""
    numbers, add = list[int](), JointMapper.add

    def noted(mapper: JointMapper, sweep: Sweep) -> None:
        numbers.append(sweep.index)
        add(mapper, sweep)

    monkeypatch.setattr(JointMapper, "add", noted)
    return numbers


def first(survey: Survey, count: int) -> Survey:
    return replace(survey, sweeps=survey.sweeps[:count])


def as_from_the_recording(survey: Survey) -> Any:
    return {"topic": "map", **json.loads(json.dumps(drawing_of(map_source(survey.recording).plan)))}


def test_a_map_that_grows_is_that_of_the_recording_and_takes_each_sweep_once(square: Survey, added: list[int]) -> None:
    for count in range(1, len(square)):
        draw_map(first(square, count))
    added.clear()
    drawn = json.loads(draw_map(square))
    assert added == [len(square) - 1]
    assert len(drawn["walls"]) == 4
    assert drawn == as_from_the_recording(square)


@pytest.mark.parametrize(
    "change",
    [
        Survey.without_last_station,
        lambda survey: survey.with_station_at(1, map_from_base=np.array([0.3, 0.1, 0.0])),
        lambda survey: replace(survey, rig=replace(survey.rig, speed_of_sound=330.0)),
    ],
    ids=["undo", "moved station", "better known rig"],
)
def test_a_survey_that_does_not_begin_with_the_mapped_sweeps_is_mapped_anew(
    square: Survey, added: list[int], change: Callable[[Survey], Survey]
) -> None:
    draw_map(square)
    changed = change(square)
    added.clear()
    drawn = json.loads(draw_map(changed))
    assert added == list(range(len(changed)))
    assert drawn == as_from_the_recording(changed)


def test_the_verdict_is_that_on_the_map_of_the_recording(square: Survey) -> None:
    quality = map_source(square.recording).quality
    message = json.loads(check_map(square))
    assert quality is not None
    assert (message["verdict"], message["reasons"]) == (quality.verdict, list(quality.reasons))
    assert message["sweeps"] == len(square)


def test_a_survey_without_sweeps_has_no_verdict() -> None:
    message = json.loads(check_map(Survey(name="bench", rig=RIG)))
    assert message == {"topic": "verdict", "sweeps": 0, "verdict": "", "headline": "", "reasons": []}
