"""Certainty: how well corrected poses are known, and in which directions nothing but odometry tells them."""

from dataclasses import asdict, dataclass

import numpy as np
from pydantic import BaseModel, Field

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


class ObservabilitySettings(BaseModel, frozen=True, extra="forbid"):
    """When echoes determine a pose."""

    unfixed: float = Field(default=1 / 3, gt=0.0, le=1.0, description="share of odometry's deviation that may be left")
    elongated: float = Field(default=2.0, ge=1.0, description="long axis of an ellipse over its short one")
    least: float = Field(default=0.01, ge=0.0, description="deviation from which on it is worth telling [m]")


@dataclass(frozen=True, slots=True, kw_only=True)
class Undetermined:
    """Poses in a row that odometry alone tells in one direction.

    Parameters
    ----------
    first, last : int
        Stations between which this holds.
    direction : float
        Which way, at the worst of them, modulo half a turn [rad].
    along, across : float
        Standard deviations that way, and between the walls, there [m].
    """

    first: int
    last: int
    direction: float
    along: float
    across: float

    def at_sweeps(self, stations: Stations, sweeps: np.ndarray) -> dict[str, float]:
        """Tell the same with numbers of sweeps instead of stations, ready for JSON.

        Parameters
        ----------
        stations : Stations
            Which sweeps belong to which station.
        sweeps : ndarray of int, shape (w,)
            Numbers of the sweeps.

        Returns
        -------
        dict of str to float
            By the names of the parameters.
        """
        members = sweeps[(stations.numbers >= self.first) & (stations.numbers <= self.last)]
        return {**asdict(self), "first": int(members[0]), "last": int(members[-1])}


def pose_covariances(solution: Solution) -> FloatArray:
    """Take the covariances of the poses out of an adjustment.

    Parameters
    ----------
    solution : Solution
        Features, sonar and poses.

    Returns
    -------
    ndarray, shape (s, 3, 3)
        Of each pose [m, m, rad]; of shape (0, 3, 3) where poses were trusted.
    """
    poses = _poses(solution)
    return _blocks(solution.covariance[poses, poses])


def covariances_between_walls(solution: Solution) -> FloatArray:
    """Take the covariances of the poses as if the walls were known.

    The frame is the first pose, and a single station hears badly which way it faces: seen from there all that is far
    away is uncertain sideways, by one turn of everything.  What echoes fix is the place between the walls: the
    covariance given these, ``P - C W^-1 C'`` with that of the walls ``W`` and that of poses with walls ``C``.

    Parameters
    ----------
    solution : Solution
        Features, sonar and poses.

    Returns
    -------
    ndarray, shape (s, 3, 3)
        Of each pose [m, m, rad]; of shape (0, 3, 3) where poses were trusted.
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
    """Carry covariances of stations over to their sweeps, that stand a little aside.

    Parameters
    ----------
    covariances : ndarray, shape (s, 3, 3)
        Of the stations [m, m, rad].
    stations : Stations
        Which sweeps belong to which station.
    poses : ndarray, shape (w, 3)
        Corrected poses of the sweeps [m, m, rad].

    Returns
    -------
    ndarray, shape (w, 3, 3)
        Of the sweeps.
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


def dead_reckoned_covariances(priors: PosePrior, poses: FloatArray) -> FloatArray:
    """Add up what odometry leaves open of each pose by itself.

    Parameters
    ----------
    priors : PosePrior
        What is believed of its steps.
    poses : ndarray, shape (s, 3)
        Where the robot was [m, m, rad].

    Returns
    -------
    ndarray, shape (s, 3, 3)
        Of each pose in the frame of the map [m, m, rad].
    """
    before, own = between_jacobians(priors.measured_poses, poses)
    noises = np.stack([np.diag(row) for row in priors.sigmas**2])
    covariances = [noises[0]]
    for history, now, noise in zip(before[1:], own[1:], noises[1:], strict=True):
        moved, spread = np.linalg.solve(now, history), np.linalg.inv(now)
        covariances.append(moved @ covariances[-1] @ moved.T + spread @ noise @ spread.T)
    return np.array(covariances)


def undetermined(
    covariances: FloatArray, between: FloatArray, dead_reckoned: FloatArray, settings: ObservabilitySettings
) -> tuple[Undetermined, ...]:
    """Find where echoes fix a position one way, and hardly anything but odometry does so the other way: in a corridor.

    Parameters
    ----------
    covariances : ndarray, shape (s, 3, 3)
        Of corrected poses [m, m, rad].
    between : ndarray, shape (s, 3, 3)
        Of the same poses as if the walls were known.
    dead_reckoned : ndarray, shape (s, 3, 3)
        Of the same poses by odometry alone, with the heading known: that is what walls tell in any case.
    settings : ObservabilitySettings
        When a pose is determined.

    Returns
    -------
    tuple of Undetermined
        One for each row of stations.
    """
    variances, vectors = np.linalg.eigh(between[:, :2, :2])
    across, along_walls = np.sqrt(np.maximum(variances, 0.0)).T
    longest = vectors[:, :, 1]
    along, alone = (_deviations(each, longest) for each in (covariances, dead_reckoned))
    open_ = (along_walls > settings.elongated * across) & (along > settings.unfixed * alone) & (along > settings.least)
    # The first pose is the frame: it is known by decree.
    open_[:1] = False
    edges = np.flatnonzero(np.diff(np.concatenate([[False], open_, [False]]).astype(np.int64)))
    found = []
    for first, end in edges.reshape(-1, 2).tolist():
        worst = first + int(np.argmax(along[first:end]))
        angle = float(wrap(2 * np.arctan2(longest[worst, 1], longest[worst, 0]))) / 2
        deviations = {"along": float(along[worst]), "across": float(across[worst])}
        found.append(Undetermined(first=first, last=end - 1, direction=angle, **deviations))
    return tuple(found)


def _deviations(covariances: FloatArray, directions: FloatArray) -> FloatArray:
    deviations: FloatArray = np.sqrt(np.einsum("ki,kij,kj->k", directions, covariances[:, :2, :2], directions))
    return deviations
