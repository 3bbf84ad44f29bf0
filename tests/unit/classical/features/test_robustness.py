"""What one wrong association, or a scale that nobody can know, does to a map of a robot that drifts."""

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.geometry import compose
from echoplan.joint.optimisation.edge_diffraction import edges_of
from echoplan.joint.optimisation.optimiser import Features, OptimiserSettings, Priors, optimise
from echoplan.joint.optimisation.pose_factors import PoseSettings, at_poses, odometry_prior
from echoplan.joint.optimisation.solution import Solution
from echoplan.joint.optimisation.values import Values
from helpers.expectations import NOISE, REACH, ROOM, SONAR, listening, pings_of

# Where the stations of ``listening`` are said to be, and where they are.
GIVEN = np.array([[-0.9, 0.1, 0.0], [-0.2, -0.5, 0.4], [0.5, 0.3, 1.0], [1.1, -0.3, -2.0]])
TRUE = np.concatenate([GIVEN[:1], compose(GIVEN[1:], np.array([0.01, -0.008, 0.02]))])
PRIORS = Priors(
    noise=NOISE,
    offset_sigma=0.0015,
    walk_gain=SONAR.walk_gain,
    has_servo=False,
    scale_sigma=OptimiserSettings().scale_sigma_with_thermometer,
    drifting=True,
    poses=odometry_prior(GIVEN, PoseSettings()),
)


def corrected(*, wrong: float = 0.0, scale: float = 0.0) -> Solution:
    """Poses and walls from readings of a room, of which some of the last station's are of something else."""
    recorded = listening()
    readings_of_room = pings_of(
        at_poses(recorded, GIVEN, TRUE), ROOM, noise=NOISE, rng=np.random.default_rng(1)
    ).readings
    east = (recorded.stations == 3) & (np.abs(recorded.bearings - 2.0) < np.radians(20)) & np.isfinite(readings_of_room)
    readings = np.where(east, readings_of_room - wrong, readings_of_room) / (1.0 + scale)
    extents = np.tile([-REACH, REACH], (4, 1))
    ends = edges_of(ROOM, extents)
    features = Features(
        reflectors=ROOM, extents=extents, attenuations=np.zeros((4, 4)), bias_variances=np.zeros((4, 4)), ends=ends
    )
    start = Values(features=features, model=SONAR, poses=GIVEN)
    return optimise(recorded._replace(readings=readings), start, PRIORS, OptimiserSettings(max_iterations=20))


def farthest(poses: FloatArray) -> float:
    return float(np.hypot(*(poses - TRUE)[:, :2].T).max())


def test_poses_come_to_where_they_are() -> None:
    assert farthest(GIVEN) > 0.01
    assert farthest(corrected().poses) < 0.004


@pytest.mark.parametrize("wrong", [0.03, 0.06, 0.2])
def test_one_wrong_association_bends_no_map(wrong: float) -> None:
    right, bent = corrected(), corrected(wrong=wrong)
    assert bent.poses == pytest.approx(right.poses, abs=0.004)
    assert bent.reflectors[:, 1:] == pytest.approx(right.reflectors[:, 1:], abs=0.004)


def test_a_drifting_robot_does_not_guess_the_scale_and_says_how_little_it_knows() -> None:
    found = corrected(scale=0.003)
    assert found.model.range_scale == pytest.approx(0.0, abs=1e-6)
    assert found.sonar_sigmas()["range_scale"] == pytest.approx(
        OptimiserSettings().scale_sigma_with_thermometer, rel=0.2
    )
