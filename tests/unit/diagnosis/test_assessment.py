"""Assessment: good maps are called good, others doubtful or failed, with the reason."""

import math
from dataclasses import replace

import numpy as np
import pytest

from echoplan.diagnosis import Measures, assess, examine, find_remedies, verdict_of
from echoplan.joint.mapper import JointMapper
from echoplan.methods import METHODS, map_sweeps
from echoplan.model import Conventions, FeatureMap, Verdict, Wall
from echoplan.preprocessing import Faults, RecordingFault, RecordingFaultKind
from helpers.mistaken import RIG, many_sweeps, misaligned_sweeps, sound_map, sound_sweeps

pytestmark = pytest.mark.slow

TWO_PLACES = Faults(recording=(RecordingFault(kind=RecordingFaultKind.TWO_PLACES),))
SOUND = Measures(share=0.98, confirmed=0.9, features=8)


def test_a_map_of_a_sound_recording_is_good() -> None:
    quality = assess(sound_map(), RIG, sound_sweeps())
    assert (quality.verdict, quality.reasons, quality.next_step) == (Verdict.GOOD, (), "")


@pytest.mark.parametrize("name", ["mdp-fuzzy", "point-plot", "hough", "gmm", "directional-maximum", "grid-bayes"])
def test_a_map_that_no_method_checks_is_doubtful_at_best(name: str) -> None:
    found = map_sweeps(METHODS[name].build(RIG), sound_sweeps())
    quality = assess(found, RIG, sound_sweeps())
    reason = f"{name} does not say how well its map explains the echoes: only the poses and conventions were checked."
    assert (quality.verdict, quality.reasons) == (Verdict.DOUBTFUL, (reason,))
    assert quality.next_step == "Map it with --method joint, which checks its map against the echoes."


def test_a_map_that_no_method_checks_has_failed_if_the_recording_is_written_otherwise() -> None:
    sweeps = [Conventions(servo_sign=-1).undo(sweep) for sweep in sound_sweeps()[:4]]
    quality = assess(map_sweeps(METHODS["point-plot"].build(RIG), sweeps), RIG, sweeps)
    assert quality.verdict is Verdict.FAILED
    assert quality.reasons[0].startswith("The servo seems to turn clockwise: ")
    assert quality.next_step == "Set servo_sign = -1 under [conventions] in rig.toml and map again."


def test_a_long_map_is_judged_by_all_of_it() -> None:
    poses = np.array([sweep.station for sweep in many_sweeps()])
    found = {"found": {"inlier_ratio": 0.98}}
    whole = replace(sound_map(), sweeps=np.arange(len(poses)), poses=poses, parameters=found)
    assert assess(whole, RIG, many_sweeps()).verdict is Verdict.GOOD
    # In the last part the poses are right.
    drifting = poses + np.linspace(1.0, 0.0, len(poses))[:, None] * np.array([1.0, 0.5, 1.0])
    quality = assess(replace(whole, poses=drifting), RIG, many_sweeps())
    assert quality.verdict is not Verdict.GOOD
    assert any(reason.endswith("of the echoes fit together.") for reason in quality.reasons)


def test_a_map_for_which_the_servo_was_calibrated_is_good() -> None:
    sweeps = misaligned_sweeps(0.92, 9.0)
    quality = assess(map_sweeps(JointMapper(RIG), sweeps), RIG, sweeps)
    assert (quality.verdict, quality.reasons) == (Verdict.GOOD, ())


def test_a_servo_that_joint_calibrates_is_no_mistake() -> None:
    sweeps = misaligned_sweeps(1.08, -4.0)
    assert examine(RIG, sweeps).reasons == ()
    assert find_remedies(sweeps, RIG, conventions=Conventions()) == ()


def test_features_without_a_count_of_stations_do_not_make_a_map_doubtful() -> None:
    uncounted = [replace(wall, stations=0) for wall in sound_map().walls]
    assert assess(replace(sound_map(), walls=tuple(uncounted)), RIG, sound_sweeps()).verdict is Verdict.GOOD


def test_an_empty_map_has_failed() -> None:
    quality = assess(FeatureMap(method="joint"), RIG, ())
    assert (quality.verdict, quality.reasons[0]) == (Verdict.FAILED, "No wall, corner or cylinder was found.")


def test_zeros_for_no_echo_are_a_reason_and_make_a_map_doubtful() -> None:
    zeros = [replace(sweep, ranges=np.where(np.isinf(sweep.ranges), 0.0, sweep.ranges)) for sweep in sound_sweeps()]
    quality = assess(map_sweeps(JointMapper(RIG), zeros), RIG, zeros)
    assert quality.verdict is Verdict.DOUBTFUL
    assert "reads 0 m where it has no echo" in quality.reasons[0]


def test_without_positions_no_mistake_in_the_rig_is_suspected() -> None:
    sweeps = [replace(sweep, map_from_base=np.zeros_like(sweep.map_from_base)) for sweep in sound_sweeps()]
    quality = assess(FeatureMap(method="joint"), RIG, sweeps)
    assert quality.verdict is Verdict.FAILED
    assert quality.reasons[0].startswith("There are no positions in this recording")
    assert examine(RIG, sweeps).reasons == quality.reasons[:1]


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
        ({"faults": TWO_PLACES}, Verdict.DOUBTFUL),
        ({"confirmed": 0.6}, Verdict.DOUBTFUL),
        ({"confirmed": 0.2}, Verdict.FAILED),
        ({"confirmed": 0.0, "faults": TWO_PLACES}, Verdict.DOUBTFUL),
        ({"crossed": 1}, Verdict.DOUBTFUL),
        ({"features": 0}, Verdict.FAILED),
    ],
)
def test_a_verdict_follows_from_numbers(changes: dict[str, float], verdict: Verdict) -> None:
    assert verdict_of(replace(SOUND, **changes)) is verdict  # type: ignore[arg-type]
