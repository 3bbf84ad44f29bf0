"""Pose factors: priors by odometry or waypoints, their residuals and Jacobians, and pings at corrected poses."""

import math
from typing import ClassVar, NamedTuple

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray, IntArray
from echoplan.geometry import compose, invert, wrap
from echoplan.joint.optimisation.factors import LinearFactor
from echoplan.joint.search.duplicates import DuplicateSettings
from echoplan.model import Odometry
from echoplan.preprocessing.measurements import Measurements
from echoplan.settings import Settings

__all__ = [
    "PosePrior",
    "PoseSettings",
    "at_poses",
    "between_jacobians",
    "between_residuals",
    "bridge_variances",
    "continued",
    "dead_reckoned",
    "neighbours_of",
    "odometry_prior",
    "pose_factors",
    "waypoint_prior",
    "waypoint_steps",
]

# Rounding error of a step, due to the digits of recorded poses or the ticks of an encoder [m, m, rad].
_ROUNDED = (5e-4, 5e-4, 5e-4)
# Least length by which the variance of a step is divided [m]: rounding errors dominate shorter steps.
_STEP = 0.05
# Standard deviation of the first pose, which defines the frame of the map and is fixed [m, m, rad].
_FIXED = (1e-4, 1e-4, 1e-5)


class PoseSettings(Settings):
    """Settings of the errors of poses."""

    former_keys: ClassVar = {
        "pair_sigma": "bias_sigma",
        "floor": "min_xy_sigma",
        "turn_per_metre": "yaw_per_metre",
        "turn_share": "yaw_per_radian",
        "turn_floor": "min_yaw_sigma",
        "noises": "annealing_sigmas",
        "tracking_noise": "tracking_sigma",
        "copies": "duplicates",
        "pair_spread": "bias_log_sigma",
        "waypoint": "absolute_xy_sigma",
        "waypoint_turn": "absolute_yaw_sigma",
    }

    along: float = Field(default=0.025, ge=0.0, description="Odometry noise along the path, as a share of its length.")
    across: float = Field(default=0.02, ge=0.0, description="Odometry noise across the path, as a share of its length.")
    # Smallest odometry noise of the position in a step [m].
    min_xy_sigma: ClassVar[float] = 0.003
    yaw_per_metre: float = Field(default=math.radians(2.5), ge=0.0, description="Heading noise of odometry [rad/m].")
    yaw_per_radian: float = Field(
        default=0.05, ge=0.0, description="Heading noise of odometry, as a share of the turn."
    )
    # Smallest heading noise of odometry in a step [rad].
    min_yaw_sigma: ClassVar[float] = math.radians(0.3)
    # Standard deviations of readings in the annealing, from coarse to fine [m].
    annealing_sigmas: ClassVar[tuple[float, ...]] = (0.020, 0.015, 0.012)
    # Standard deviation of readings in the pose tracking [m].
    tracking_sigma: ClassVar[float] = 0.012
    # Gates of duplicate landmarks that pose errors cause.
    duplicates: ClassVar[DuplicateSettings] = DuplicateSettings(angle_gate=math.radians(4), normal_distance_gate=0.05)
    # Standard deviation of the bias of a station's readings of a landmark [m].
    bias_sigma: ClassVar[float] = 0.012
    # Standard deviation of the logarithm of bias_sigma.
    bias_log_sigma: ClassVar[float] = 0.5 * math.log(10.0)
    absolute_xy_sigma: float = Field(
        default=0.02, gt=0.0, description="Standard deviation of a waypoint set by hand [m]."
    )
    absolute_yaw_sigma: float = Field(
        default=0.2, gt=0.0, description="Standard deviation of a heading set by hand [rad]."
    )


class PosePrior(NamedTuple):
    """Prior of the poses of s stations.

    Attributes
    ----------
    measured_poses : ndarray, shape (s, 3)
        Poses as recorded [m, m, rad].
    sigmas : ndarray, shape (s, 3)
        Standard deviations [m, m, rad]: of x, y and yaw of absolute poses, else of the step to each pose, along it,
        across it and in yaw.
    relative : bool
        Whether errors accumulate from one pose to the next.
    specified : bool
        Whether the rig specifies some of the standard deviations; else they are defaults that may be estimated anew.
    """

    measured_poses: FloatArray
    sigmas: FloatArray
    relative: bool
    specified: bool = False

    @property
    def reaches(self) -> FloatArray:
        """Standard deviations in the frame of each pose, shape (s, 3) [m, m, rad]."""
        if not self.relative:
            return self.sigmas
        steps = _steps(self.measured_poses)
        turned = _ways(steps) - steps[:, 2]
        squares = np.stack([np.cos(turned) ** 2, np.sin(turned) ** 2], axis=1)
        reaches = self.sigmas.copy()
        for axis, shares in enumerate((squares, squares[:, ::-1])):
            reaches[1:, axis] = np.sqrt(np.sum(shares * self.sigmas[1:, :2] ** 2, axis=1))
        return reaches


def odometry_prior(measured_poses: FloatArray, settings: PoseSettings, specified: Odometry | None = None) -> PosePrior:
    """Return the prior of steps between poses, the first fixed; what the rig does not specify has default sigmas."""
    steps = _steps(measured_poses)
    length, turn = np.hypot(steps[:, 0], steps[:, 1]), np.abs(steps[:, 2])
    sigmas = (
        _guessed(length, turn, settings) if specified is None else _specified_sigmas(length, turn, specified, settings)
    )
    return PosePrior(measured_poses, np.concatenate([[_FIXED], sigmas]), relative=True, specified=specified is not None)


def _guessed(length: FloatArray, turn: FloatArray, settings: PoseSettings) -> FloatArray:
    floor = np.full(len(turn), settings.min_yaw_sigma)
    turning = np.stack([settings.yaw_per_metre * length, settings.yaw_per_radian * turn, floor])
    return np.column_stack(
        [
            settings.along * length + settings.min_xy_sigma,
            settings.across * length + settings.min_xy_sigma,
            np.sqrt((turning**2).sum(axis=0)),
        ]
    )


def _specified_sigmas(length: FloatArray, turn: FloatArray, specified: Odometry, settings: PoseSettings) -> FloatArray:
    along, across = settings.along * length + settings.min_xy_sigma, settings.across * length + settings.min_xy_sigma
    by_way, by_turn = settings.yaw_per_metre * length, np.hypot(settings.yaw_per_radian * turn, settings.min_yaw_sigma)
    variances = [
        _variance(specified.along, length, along),
        _variance(specified.lateral, length, across),
        _variance(specified.yaw_per_metre, length, by_way) + _variance(specified.yaw_per_radian, turn, by_turn),
    ]
    return np.sqrt(np.column_stack(variances) + np.square(_ROUNDED))


def _variance(specified: float | None, way: FloatArray, guessed: FloatArray) -> FloatArray:
    """Return the variance of a random walk over a way, or the square of a default standard deviation."""
    return guessed**2 if specified is None else specified**2 * way


def waypoint_prior(measured_poses: FloatArray, settings: PoseSettings) -> PosePrior:
    """Return the prior of waypoints: every pose is absolute."""
    sigmas = (settings.absolute_xy_sigma, settings.absolute_xy_sigma, settings.absolute_yaw_sigma)
    return PosePrior(measured_poses, np.tile(sigmas, (len(measured_poses), 1)), relative=False)


def waypoint_steps(measured_poses: FloatArray, settings: PoseSettings) -> PosePrior:
    """Return the prior of steps between waypoints, the first fixed.

    The positions of both ends have errors, and the yaw error of the first end rotates the step.
    """
    steps, place, turn = (
        _steps(measured_poses),
        math.sqrt(2.0) * settings.absolute_xy_sigma,
        settings.absolute_yaw_sigma,
    )
    across = np.hypot(place, turn * np.hypot(steps[:, 0], steps[:, 1]))
    sigmas = np.column_stack([np.full(len(steps), place), across, np.full(len(steps), math.sqrt(2.0) * turn)])
    return PosePrior(measured_poses, np.concatenate([[_FIXED], sigmas]), relative=True)


def continued(measured_poses: FloatArray, known: FloatArray) -> FloatArray:
    """Return the known poses, shape (k, 3), and the others by the recorded steps from them, shape (s, 3) in total."""
    if not len(known) or (known == measured_poses[: len(known)]).all():
        return measured_poses
    rest = compose(known[-1], compose(invert(measured_poses[len(known) - 1]), measured_poses[len(known) :]))
    return np.concatenate([known, rest])


def dead_reckoned(measured_poses: FloatArray, poses: FloatArray, station: int) -> FloatArray:
    """Return the pose of a station by the recorded step from the present pose before it [m, m, rad], shape (3,)."""
    step = compose(invert(measured_poses[station - 1]), measured_poses[station])
    return compose(poses[station - 1], step)


def at_poses(measurements: Measurements, measured_poses: FloatArray, poses: FloatArray) -> Measurements:
    """Return the pings moved from the recorded poses to other ones, both of shape (s, 3) [m, m, rad].

    The correction of a ping that was made while the robot drove lies between those of its station and of the
    neighbouring one: the expectation of an error of odometry that accumulates with the way, given both.
    """
    turn = np.exp(1j * (poses[:, 2] - measured_poses[:, 2]))
    before, behind = measured_poses[:, 0] + 1j * measured_poses[:, 1], poses[:, 0] + 1j * poses[:, 1]
    own = measurements.stations
    places = behind[own] + turn[own] * (measurements.x + 1j * measurements.y - before[own])
    centers = behind + turn * (measurements.centers[:, 0] + 1j * measurements.centers[:, 1] - before)
    turns = turn[own]
    if measurements.ways.any():
        others, shares = neighbours_of(measurements, measured_poses)
        beside = behind[others] + turn[others] * (measurements.x + 1j * measurements.y - before[others])
        places += shares * (beside - places)
        turns = turns * np.exp(1j * shares * np.angle(turn[others] / turns))
    axes = turns * (measurements.ux + 1j * measurements.uy)
    arms = turns * (measurements.arms_x + 1j * measurements.arms_y)
    return measurements._replace(
        x=places.real.copy(),
        y=places.imag.copy(),
        ux=axes.real.copy(),
        uy=axes.imag.copy(),
        arms_x=arms.real.copy(),
        arms_y=arms.imag.copy(),
        centers=np.column_stack([centers.real, centers.imag]),
    )


def neighbours_of(measurements: Measurements, measured_poses: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return the station nearest to each ping on the path besides its own, and how far it is towards that, 0 to 1.

    The first and the last station have a neighbour on one side; on the other one, the share is 0.
    """
    own, ways, last = measurements.stations, measurements.ways, len(measured_poses) - 1
    before, after = np.zeros(last + 1), np.zeros(last + 1)
    np.maximum.at(before, own, -ways)
    np.maximum.at(after, own, ways)
    steps = _steps(measured_poses)
    # A path that bends is longer than the step from one station to the next.
    lengths = np.hypot(steps[:, 0], steps[:, 1]) + np.abs(steps[:, 2])
    lengths = np.concatenate([[np.inf], np.maximum(lengths, after[:-1] + before[1:]), [np.inf]])
    others = np.clip(own + np.sign(ways).astype(np.int64), 0, last)
    shares: FloatArray = np.abs(ways) / np.maximum(lengths[own + (ways > 0.0)], 1e-9)
    return others, shares


def bridge_variances(measurements: Measurements, priors: PosePrior) -> FloatArray:
    """Return by how much positions of pings scatter about their interpolation, shape (n,) [m^2]: 0 if the robot stood.

    Errors of odometry that accumulate with the way are a Brownian motion. Between two stations it is a Brownian bridge:
    a share s of a way with error variance v has the variance v s (1 - s) if both ends are known. Before the first and
    after the last station the way counts from that station.
    """
    variances, steps = np.square(priors.sigmas[1:, :2]).max(axis=1), _steps(priors.measured_poses)
    per_metre = variances / np.maximum(np.hypot(steps[:, 0], steps[:, 1]) + np.abs(steps[:, 2]), _STEP)
    usual = float(np.median(per_metre)) if len(per_metre) else 0.0
    _, shares = neighbours_of(measurements, priors.measured_poses)
    scatter: FloatArray = usual * np.abs(measurements.ways) * (1.0 - np.minimum(shares, 1.0))
    return scatter


def pose_factors(priors: PosePrior, poses: FloatArray, first: int) -> LinearFactor:
    """Return the factor of the pose prior, three rows per pose; ``first`` is the position of the first pose."""
    count = len(poses)
    own = first + np.arange(3 * count).reshape(count, 1, 3) + np.zeros((1, 3, 1), dtype=np.int64)
    if not priors.relative:
        residuals = priors.measured_poses - poses
        residuals[:, 2] = wrap(residuals[:, 2])
        jacobian = np.broadcast_to(np.eye(3), (count, 3, 3))
        return _flat(own, jacobian, residuals, priors.sigmas)
    before = np.concatenate([np.full((1, 3, 3), -1), own[:-1]])
    start = priors.measured_poses[:1] - poses[:1]
    start[:, 2] = wrap(start[:, 2])
    residuals = np.concatenate([start, between_residuals(priors.measured_poses, poses)])
    from_before, from_own = between_jacobians(priors.measured_poses, poses)
    columns = np.concatenate([before, own], axis=2)
    return _flat(columns, np.concatenate([from_before, from_own], axis=2), residuals, priors.sigmas)


def between_residuals(measured_poses: FloatArray, poses: FloatArray) -> FloatArray:
    """Return recorded minus present steps between poses, shape (s - 1, 3) [m, m, rad].

    Columns are along the recorded step, across it to the left, and yaw.
    """
    recorded = _steps(measured_poses)
    residuals = recorded - _steps(poses)
    residuals[:, 2] = wrap(residuals[:, 2])
    turned: FloatArray = np.einsum("kij,kj->ki", _along_ways(recorded), residuals)
    return turned


def _ways(steps: FloatArray) -> FloatArray:
    """Return the directions of steps in the frame of the pose before, shape (k,) [rad]."""
    directions: FloatArray = np.arctan2(steps[:, 1], steps[:, 0])
    return directions


def _along_ways(steps: FloatArray) -> FloatArray:
    """Return the rotations from the frame of the pose before to along and across the step, shape (k, 3, 3)."""
    ways, turns = _ways(steps), np.tile(np.eye(3), (len(steps), 1, 1))
    turns[:, 0, 0] = turns[:, 1, 1] = np.cos(ways)
    turns[:, 0, 1], turns[:, 1, 0] = np.sin(ways), -np.sin(ways)
    return turns


def _steps(poses: FloatArray) -> FloatArray:
    return compose(invert(poses[:-1]), poses[1:])


def between_jacobians(measured_poses: FloatArray, poses: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Differentiate each step by the pose before and by its own: ``p = R' (t - t0)``, ``dp/dyaw0 = (p_y, -p_x)``.

    Both results have shape (s, 3, 3), with rows along and across the recorded step and in yaw. The first pose has none
    before it and counts as a step of its own.
    """
    count, steps = len(poses), _steps(poses)
    cosine, sine = np.cos(poses[:-1, 2]), np.sin(poses[:-1, 2])
    own, before = np.tile(np.eye(3), (count, 1, 1)), np.zeros((count, 3, 3))
    own[1:, 0, :2] = np.column_stack([cosine, sine])
    own[1:, 1, :2] = np.column_stack([-sine, cosine])
    before[1:] = -own[1:]
    before[1:, 0, 2], before[1:, 1, 2] = steps[:, 1], -steps[:, 0]
    turns = _along_ways(_steps(measured_poses))
    before[1:], own[1:] = turns @ before[1:], turns @ own[1:]
    return before, own


def _flat(columns: IntArray, jacobian: FloatArray, residuals: FloatArray, sigmas: FloatArray) -> LinearFactor:
    width = columns.shape[2]
    return LinearFactor(
        columns.reshape(-1, width).astype(np.int64),
        jacobian.reshape(-1, width).astype(np.float64),
        residuals.ravel(),
        (sigmas**-2.0).ravel(),
    )
