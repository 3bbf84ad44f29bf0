"""Trajectory: poses of the sweeps, their covariances, and where only odometry determines them."""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from echoplan.arrays import FloatArray, IntArray
from echoplan.joint.estimate import Estimate
from echoplan.joint.observability import (
    Undetermined,
    carried_covariances,
    covariances_between_walls,
    dead_reckoned_covariances,
    pose_covariances,
    undetermined,
)
from echoplan.preprocessing.stations import Stations

__all__ = ["Trajectory", "dead_reckoned", "joined", "posed"]


class Trajectory(NamedTuple):
    """Poses of w sweeps."""

    # Numbers of the sweeps, shape (w,).
    sweeps: IntArray
    # Estimated poses [m, m, rad], shape (w, 3).
    poses: FloatArray
    # Covariances of the poses [m, m, rad], shape (w, 3, 3); shape (0, 3, 3) if poses are fixed.
    covariances: FloatArray
    # Runs of sweeps whose position only odometry determines in one direction.
    undetermined: tuple[dict[str, float], ...]

    def first(self, count: int) -> "Trajectory":
        """Return the trajectory of the first ``count`` sweeps."""
        sweeps = self.sweeps[:count]
        rows = [each for each in self.undetermined if len(sweeps) and each["first"] <= sweeps[-1]]
        return Trajectory(
            sweeps=sweeps,
            poses=self.poses[:count],
            covariances=self.covariances[:count],
            undetermined=tuple({**each, "last": min(each["last"], int(sweeps[-1]))} for each in rows),
        )


def posed(estimate: Estimate, stations: Stations, measured_poses: FloatArray, sweeps: IntArray) -> Trajectory:
    """Return the trajectory of the sweeps of some stations.

    ``measured_poses`` are the recorded poses of the sweeps, shape (w, 3) [m, m, rad], ``sweeps`` their numbers, shape
    (w,).
    """
    poses = stations.of_sweeps(measured_poses, estimate.poses)
    covariances = np.zeros((0, 3, 3)) if estimate.solution is None else pose_covariances(estimate.solution)
    return Trajectory(
        sweeps=sweeps,
        poses=poses,
        covariances=carried_covariances(covariances, stations, poses),
        undetermined=tuple(each.at_sweeps(stations, sweeps) for each in _undetermined(estimate, covariances)),
    )


def _undetermined(estimate: Estimate, covariances: FloatArray) -> tuple[Undetermined, ...]:
    """Find the runs of stations whose position only odometry determines in one direction."""
    if estimate.pose_prior is None or not estimate.pose_prior.relative or estimate.solution is None:
        return ()
    between = covariances_between_walls(estimate.solution)
    return undetermined(covariances, between, dead_reckoned(estimate), estimate.settings.observability)


def dead_reckoned(estimate: Estimate) -> FloatArray:
    """Return the covariances of the poses by odometry alone, with known heading, shape (s, 3, 3) [m, m, rad].

    They grow from the first station of the recording on, in the frame of the map.
    """
    assert estimate.pose_prior is not None
    sigmas = estimate.pose_prior.sigmas.copy()
    sigmas[:, 2] = 0.0
    if not estimate.marginal_prior.is_empty:
        sigmas[0] = estimate.marginal_prior.dead_reckoned
    return dead_reckoned_covariances(estimate.pose_prior._replace(sigmas=sigmas), estimate.poses)


def joined(parts: Sequence[Trajectory]) -> Trajectory:
    """Concatenate consecutive trajectories, at least one.

    Fixed poses have zero covariance if poses of another part are estimated.
    """
    return Trajectory(
        sweeps=np.concatenate([part.sweeps for part in parts]),
        poses=np.concatenate([part.poses for part in parts]),
        covariances=_covariances(parts),
        undetermined=_merged([each for part in parts for each in part.undetermined], parts),
    )


def _covariances(parts: Sequence[Trajectory]) -> FloatArray:
    corrected = any(len(part.covariances) for part in parts)
    whole = [part.covariances if len(part.covariances) else np.zeros((len(part.poses), 3, 3)) for part in parts]
    return np.concatenate(whole) if corrected else np.zeros((0, 3, 3))


def _merged(rows: Sequence[dict[str, float]], parts: Sequence[Trajectory]) -> tuple[dict[str, float], ...]:
    """Join runs that continue across a border between parts; direction and deviations are those of the worse one."""
    ends = {
        int(part.sweeps[-1]): int(after.sweeps[0])
        for part, after in pairwise(parts)
        if len(part.sweeps) and len(after.sweeps)
    }
    merged: list[dict[str, float]] = []
    for row in rows:
        if merged and ends.get(int(merged[-1]["last"])) == row["first"]:
            worst = max(merged[-1], row, key=lambda each: each["along"])
            merged[-1] = {**worst, "first": merged[-1]["first"], "last": row["last"]}
        else:
            merged.append(row)
    return tuple(merged)
