"""Observability: covariances of estimated poses, and directions in which only odometry determines them."""

from dataclasses import asdict, dataclass
from typing import NamedTuple

import numpy as np

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import FloatArray
from echoplan.geometry import wrap
from echoplan.joint.optimisation.pose_factors import PosePrior, between_jacobians
from echoplan.joint.optimisation.solution import Solution
from echoplan.preprocessing.stations import Stations

__all__ = [
    "ObservabilitySettings",
    "Undetermined",
    "carried_covariances",
    "covariances_between_walls",
    "dead_reckoned_covariances",
    "pose_covariances",
    "undetermined",
]


class ObservabilitySettings(NamedTuple):
    """Criteria for poses that are determined by odometry only."""

    # Largest ratio of a standard deviation to that of odometry alone at which echoes determine a pose.
    max_sigma_ratio: float = 1 / 3
    # Smallest ratio of the axes of an error ellipse of a pose that is undetermined along one direction.
    min_axis_ratio: float = 2.0
    # Smallest standard deviation of an undetermined pose that is reported [m].
    min_sigma: float = 0.01


@dataclass(frozen=True, slots=True, kw_only=True)
class Undetermined:
    """A run of poses that only odometry determines in one direction."""

    # First and last station of the run.
    first: int
    last: int
    # Direction at the worst of these stations, modulo half a turn [rad].
    direction: float
    # Standard deviations in this direction, and across it given the walls, at the worst station [m].
    along: float
    across: float

    def at_sweeps(self, stations: Stations, sweeps: np.ndarray) -> dict[str, float]:
        """Return the fields as a dictionary for JSON, with sweep numbers, shape (w,), instead of station indices."""
        members = sweeps[(stations.numbers >= self.first) & (stations.numbers <= self.last)]
        return {**asdict(self), "first": int(members[0]), "last": int(members[-1])}


def pose_covariances(solution: Solution) -> FloatArray:
    """Return the covariances of the poses of a solution, shape (s, 3, 3) [m, m, rad]; (0, 3, 3) if poses are fixed."""
    poses = _poses(solution)
    return _blocks(solution.covariance[poses, poses])


def covariances_between_walls(solution: Solution) -> FloatArray:
    """Return the covariances of the poses given the walls, shape (s, 3, 3) [m, m, rad]; (0, 3, 3) if poses are fixed.

    The first pose is the frame, and a single station determines its own heading poorly. Therefore everything far away
    has a large common uncertainty sideways. What echoes determine is the position relative to the walls, which the
    conditional covariance ``P - C W^-1 C'`` describes: P of the poses, W of the walls, C between poses and walls.
    """
    layout, poses = solution.layout, _poses(solution)
    walls = (layout.starts[layout.kinds == Kind.WALL][:, None] + np.arange(2)).ravel()
    with_walls = solution.covariance[poses, walls]
    explained_by_walls = with_walls @ np.linalg.solve(solution.covariance[np.ix_(walls, walls)], with_walls.T)
    return _blocks(solution.covariance[poses, poses] - explained_by_walls)


def _poses(solution: Solution) -> slice:
    first = solution.layout.pose
    return slice(first, first + 3 * solution.layout.poses)


def _blocks(covariance: FloatArray) -> FloatArray:
    count = len(covariance) // 3
    blocks = covariance.reshape(count, 3, count, 3)[np.arange(count), :, np.arange(count)]
    symmetric: FloatArray = 0.5 * (blocks + blocks.transpose(0, 2, 1))
    return symmetric


def carried_covariances(covariances: FloatArray, stations: Stations, poses: FloatArray) -> FloatArray:
    """Propagate covariances of stations, shape (s, 3, 3), to their sweeps, shape (w, 3, 3) [m, m, rad].

    ``poses`` are the estimated poses of the sweeps, shape (w, 3) [m, m, rad], at a small distance from the station's
    pose.
    """
    if not len(covariances):
        return covariances
    own = stations.numbers
    firsts = np.searchsorted(own, np.arange(own[-1] + 1))
    aside = poses[:, :2] - poses[firsts[own], :2]
    jacobian = np.tile(np.eye(3), (len(own), 1, 1))
    jacobian[:, 0, 2], jacobian[:, 1, 2] = -aside[:, 1], aside[:, 0]
    carried: FloatArray = np.einsum("kij,kjl,kml->kim", jacobian, covariances[own], jacobian)
    return carried


def dead_reckoned_covariances(pose_prior: PosePrior, poses: FloatArray) -> FloatArray:
    """Return the covariances of the poses by odometry alone in the map frame, shape (s, 3, 3) [m, m, rad].

    ``priors`` holds the standard deviations of the steps, ``poses`` the estimated poses, shape (s, 3) [m, m, rad].
    """
    before, own = between_jacobians(pose_prior.measured_poses, poses)
    noises = np.stack([np.diag(row) for row in pose_prior.sigmas**2])
    covariances = [noises[0]]
    for by_previous, by_own, noise in zip(before[1:], own[1:], noises[1:], strict=True):
        moved, spread = np.linalg.solve(by_own, by_previous), np.linalg.inv(by_own)
        covariances.append(moved @ covariances[-1] @ moved.T + spread @ noise @ spread.T)
    return np.array(covariances)


def undetermined(
    covariances: FloatArray, between: FloatArray, dead_reckoned: FloatArray, settings: ObservabilitySettings
) -> tuple[Undetermined, ...]:
    """Find runs of stations whose position is determined by echoes in one direction only, as in a corridor.

    All covariances have the shape (s, 3, 3) [m, m, rad]: those of the poses, those given the walls (``between``), and
    those by odometry alone with the heading known (``dead_reckoned``), since walls determine the heading in any case. A
    pose is undetermined along the major axis of its ellipse given the walls if that ellipse is elongated and if a large
    share of the standard deviation of odometry remains in that direction.
    """
    variances, vectors = np.linalg.eigh(between[:, :2, :2])
    across, along_walls = np.sqrt(np.maximum(variances, 0.0)).T
    longest = vectors[:, :, 1]
    along, alone = (
        np.sqrt(np.einsum("ki,kij,kj->k", longest, each[:, :2, :2], longest)) for each in (covariances, dead_reckoned)
    )
    open_ = (
        (along_walls > settings.min_axis_ratio * across)
        & (along > settings.max_sigma_ratio * alone)
        & (along > settings.min_sigma)
    )
    # The first pose defines the frame.
    open_[:1] = False
    edges = np.flatnonzero(np.diff(np.concatenate([[False], open_, [False]]).astype(np.int64)))
    found = []
    for first, end in edges.reshape(-1, 2).tolist():
        worst = first + int(np.argmax(along[first:end]))
        angle = float(wrap(2 * np.arctan2(longest[worst, 1], longest[worst, 0]))) / 2
        deviations = {"along": float(along[worst]), "across": float(across[worst])}
        found.append(Undetermined(first=first, last=end - 1, direction=angle, **deviations))
    return tuple(found)
