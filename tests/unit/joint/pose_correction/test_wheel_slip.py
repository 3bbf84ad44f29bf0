"""A wheel slip in a hall in which only a pillar determines the position along it."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from echoplan.evaluation import evaluate
from echoplan.geometry import compose
from echoplan.io import builtin_rig
from echoplan.joint import pose_model_selection
from echoplan.joint.estimate import Estimate
from echoplan.joint.initial_estimate import initial_estimate
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.mapper import JointMapper, JointSettings
from echoplan.joint.optimisation.pose_factors import at_poses
from echoplan.joint.pose_correction.annealing import refine
from echoplan.joint.pose_correction.wheel_slip import without_wheel_slip
from echoplan.joint.pose_model_selection import estimate_map
from echoplan.joint.settings import EstimateSettings, PoseMode
from echoplan.methods import map_sweeps
from echoplan.model import Pillar, Polyline, Route, World
from echoplan.preprocessing.measurements import Measurements, join_measurements, measurements_of
from echoplan.simulation import OdometryNoise, Simulation, SimulationSettings

pytestmark = pytest.mark.slow

HALL = World(
    name="hall",
    polylines=(Polyline(points_xy=np.array([[0.0, 0.0], [9.0, 0.0], [9.0, 3.0], [0.0, 3.0]]), closed=True),),
    pillars=(Pillar(center_xy=np.array([4.2, 1.6]), radius=0.25),),
)
WAY = np.array(
    [
        [1.8, 1.2, 0.1],
        [2.1, 1.9, 0.6],
        [1.9, 1.0, 0.4],
        [2.0, 1.6, 1.0],
        [3.1, 1.2, 0.2],
        [3.0, 2.2, 1.5],
        [3.1, 0.7, 2.6],
    ]
)
# In a far corner of this room a single sensor detects only one known wall while the robot turns.
CHAMBER = World(
    name="chamber",
    polylines=(
        Polyline(points_xy=np.array([[0.0, 0.0], [5.264, 0.0], [5.264, 3.193], [0.0, 3.193]]), closed=True),
        Polyline(points_xy=np.array([[2.144, 1.213], [2.896, 1.213], [2.896, 1.988], [2.144, 1.988]]), closed=True),
    ),
    pillars=(Pillar(center_xy=np.array([3.392, 2.465]), radius=0.163),),
)
DRIVE = np.array(
    [
        [4.07, 1.3, -2.33],
        [3.56, 0.75, -2.39],
        [3.14, 0.36, 0.99],
        [3.46, 0.84, -3.01],
        [2.51, 0.72, -3.02],
        [1.47, 0.58, -2.84],
        [0.77, 0.37, 1.25],
        [1.06, 1.25, -1.71],
        [1.01, 0.83, 1.96],
        [0.64, 1.73, 1.2],
        [0.84, 2.25, 0.84],
        [1.37, 2.84, -1.31],
    ]
)
DRIFT = OdometryNoise(along=0.02, yaw_per_metre=np.radians(2.0), yaw_per_radian=np.radians(2.0))
STEP, SLIP = 4, np.array([0.13, 0.0, 0.0])


@cache
def detected() -> Measurements:
    simulation = Simulation(
        world=HALL,
        rig=builtin_rig("rotary-array"),
        route=Route(map_from_base=WAY),
        settings=SimulationSettings(),
        seed=1,
    )
    return join_measurements([measurements_of(sweep, simulation.rig) for sweep in simulation])


@cache
def estimate(*, slips: bool) -> Estimate:
    """Return the estimate of the true path, or of one that is shifted along the hall from one step on."""
    measured_poses = np.concatenate([WAY[:STEP], compose(SLIP, WAY[STEP:])]) if slips else WAY
    settings = EstimateSettings(poses=PoseMode.CORRECT, max_waypoints=0)
    estimate = initial_estimate(
        builtin_rig("rotary-array"), at_poses(detected(), WAY, measured_poses), measured_poses, settings
    )
    if not slips:
        return refine(estimate, estimate.odometry())
    features = [part for each in right().features for part in parted(each)]
    return replace(estimate, model=right().model, noise=right().noise, features=features)


def right() -> Estimate:
    return estimate(slips=False)


def parted(feature: Hypothesis) -> list[Hypothesis]:
    """Return two pillars instead of one, before and after the slip; walls along the hall are unchanged."""
    if feature.is_wall:
        return [feature]
    before, after = np.arange(len(WAY)) < STEP, np.arange(len(WAY)) >= STEP
    there = feature.reflector + np.array([0.0, *SLIP[:2], 0.0])
    return [
        replace(feature, llr_by_station=feature.llr_by_station * before),
        replace(feature, llr_by_station=feature.llr_by_station * after, reflector=there),
    ]


def parted_in_place(feature: Hypothesis) -> list[Hypothesis]:
    """Return two pillars in one place, detected before and after the step."""
    before = np.arange(len(WAY)) < STEP
    return [replace(feature, llr_by_station=feature.llr_by_station * part) for part in (before, ~before)]


def test_a_slip_that_duplicates_a_pillar_is_corrected() -> None:
    slipped = estimate(slips=True)
    proposed = without_wheel_slip(slipped, slipped.odometry())
    assert proposed is not None
    assert proposed.poses[:STEP] == pytest.approx(WAY[:STEP])
    assert np.hypot(*(proposed.poses - WAY)[:, :2].T).max() < 0.02


def test_a_wrong_turn_is_corrected() -> None:
    drive = Simulation(
        world=CHAMBER,
        rig=builtin_rig("hc-sr04-servo"),
        route=Route(map_from_base=DRIVE),
        settings=SimulationSettings(dropout=0.02, stray=0.02, odometry=DRIFT),
        seed=46,
    )
    found = map_sweeps(JointMapper(drive.rig, JointSettings(poses=PoseMode.CORRECT)), drive)
    evaluation = evaluate(found, drive.truth)
    assert evaluation.trajectory is not None
    assert evaluation.trajectory.absolute_error < 0.02
    assert found.parameters["found"]["poses"]["has_slips"]  # type: ignore[index]


def test_without_duplicates_no_slip_is_found() -> None:
    assert without_wheel_slip(right(), right().odometry()) is None


def test_a_pose_that_already_fits_best_is_no_slip() -> None:
    """A pillar that two landmarks share makes the step suspect, but the poses already fit best."""
    pillar = next(each for each in right().features if not each.is_wall)
    twins = [each for each in right().features if each is not pillar] + parted_in_place(pillar)
    same = replace(right(), features=twins)
    assert without_wheel_slip(same, same.odometry()) is None


def test_landmarks_duplicated_by_a_slip_are_merged(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pose_model_selection, "register_in_order", lambda estimate, *_: estimate)
    monkeypatch.setattr(pose_model_selection, "agrees", lambda _: False)
    found = estimate_map(estimate(slips=True))
    assert sum(not each.is_wall for each in found.features) == 1
    assert np.hypot(*(found.poses - WAY)[:, :2].T).max() < 0.02
    assert found.pose_status.has_slips
