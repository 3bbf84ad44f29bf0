"""Assessment: good maps are called good, others doubtful or failed, with the reason."""

import math
from dataclasses import replace

import numpy as np
import pytest

from echoplan.diagnosis import Measures, assess, verdict_of
from echoplan.methods import map_sweeps
from echoplan.methods.joint import JointMapper
from echoplan.model import Conventions, FeatureMap, Verdict, Wall
from mistaken import RIG, sound_map, sound_sweeps

SOUND = Measures(share=0.98, confirmed=0.9, places=3, features=8)


def test_a_map_of_a_sound_recording_is_good() -> None:
    quality = assess(sound_map(), RIG, sound_sweeps())
    assert (quality.verdict, quality.reasons, quality.next_step) == (Verdict.GOOD, (), "")


def test_a_map_of_another_method_is_assessed_too() -> None:
    assert assess(replace(sound_map(), method="hough", parameters={}), RIG, sound_sweeps()).verdict is Verdict.GOOD


def test_a_map_from_a_servo_that_turns_clockwise_has_failed_and_says_why() -> None:
    sweeps = [Conventions(servo_sign=-1).undo(sweep) for sweep in sound_sweeps()]
    quality = assess(map_sweeps(JointMapper(RIG), sweeps), RIG, sweeps)
    assert quality.verdict is Verdict.FAILED
    assert quality.reasons[0].startswith("The servo seems to turn clockwise: ")
    assert quality.next_step == "Set servo_sign = -1 under [conventions] in rig.toml and map again."


def test_an_empty_map_has_failed() -> None:
    quality = assess(FeatureMap(method="joint"), RIG, ())
    assert (quality.verdict, quality.reasons[0]) == (Verdict.FAILED, "No wall, corner or cylinder was found.")


def test_what_others_find_wrong_is_listed_and_makes_a_map_doubtful() -> None:
    quality = assess(sound_map(), RIG, sound_sweeps(), findings=("Sensor 1 is stuck.",))
    assert (quality.verdict, quality.reasons) == (Verdict.DOUBTFUL, ("Sensor 1 is stuck.",))


def test_a_wall_across_the_path_is_a_reason_against_a_map() -> None:
    wall = Wall(
        normal_angle=0.0, offset=0.8, endpoints_xy=np.array([[0.8, -1.0], [0.8, 1.0]]), covariance=1e-6 * np.eye(2)
    )
    path = np.column_stack([np.linspace(0.6, 1.1, 3), np.zeros((3, 2))])
    crossed = FeatureMap(method="joint", walls=(wall,), sweeps=np.arange(3), poses=path)
    assert "1 wall lies across the path of the robot." in assess(crossed, RIG, ()).reasons


@pytest.mark.parametrize(
    ("changes", "verdict"),
    [
        ({}, Verdict.GOOD),
        ({"share": 0.7}, Verdict.DOUBTFUL),
        ({"share": 0.3}, Verdict.FAILED),
        ({"share": math.nan}, Verdict.FAILED),
        ({"places": 2}, Verdict.DOUBTFUL),
        ({"confirmed": 0.4}, Verdict.DOUBTFUL),
        ({"confirmed": 0.2}, Verdict.FAILED),
        ({"confirmed": 0.0, "places": 1}, Verdict.DOUBTFUL),
        ({"crossed": 1}, Verdict.DOUBTFUL),
        ({"features": 0}, Verdict.FAILED),
    ],
)
def test_a_verdict_follows_from_numbers(changes: dict[str, float], verdict: Verdict) -> None:
    assert verdict_of(replace(SOUND, **changes)) is verdict  # type: ignore[arg-type]
