"""The map that follows from displaced waypoints if every echo is assigned to its true wall."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from echoplan.joint.initial_estimate import initial_estimate
from echoplan.joint.mapper import JointSettings
from echoplan.joint.marginalisation import marginalise, survey
from echoplan.joint.optimisation.pose_factors import at_poses, waypoint_prior
from echoplan.joint.pose_model_selection import estimate_map
from echoplan.model import FeatureMap, Rig, Sweep
from echoplan.preprocessing.measurements import join_measurements, measurements_of

__all__ = ["map_with_known_associations"]

# By then nothing moves any more.
_ROUNDS, _STILL = 40, 1e-6


def map_with_known_associations(
    rig: Rig, sweeps: Sequence[Sweep], elsewhere: Sequence[Sweep], *, off: float
) -> FeatureMap:
    """Adjust the map of a recording to other waypoints, without a search for features.

    No feature is added or dropped, headings are free, and the errors of the waypoints are known, as well as which
    walls are at right angles.

    Parameters
    ----------
    rig : Rig
        What made the sweeps.
    sweeps : sequence of Sweep
        As they were recorded: their map gives the associations.
    elsewhere : sequence of Sweep
        The same sweeps with other waypoints.
    off : float
        How far each is from where it was recorded, in some direction [m].

    Returns
    -------
    FeatureMap
        Where the features are by the other waypoints.
    """
    measurements, measured_poses = join_measurements([measurements_of(each, rig) for each in sweeps]), _stations(sweeps)
    moved = estimate_map(initial_estimate(rig, measurements, measured_poses, JointSettings()))
    moved = replace(moved, measured_poses=_stations(elsewhere))
    moved = replace(moved, recorded=at_poses(moved.recorded, measured_poses, moved.measured_poses))
    # A step in some direction has half of its square along either axis.
    sigmas = {"absolute_xy_sigma": max(off, 1e-3) / math.sqrt(2.0), "absolute_yaw_sigma": math.pi}
    poses = waypoint_prior(moved.measured_poses, moved.settings.pose_errors.model_copy(update=sigmas))
    for _ in range(_ROUNDS):
        moved = moved.optimise(moved.noise, poses)
        if moved.solution is None or moved.solution.newton_decrement < _STILL:
            break
    path_xy = moved.poses[:, :2]
    found = survey(moved, marginalise(moved, len(moved.poses)), path_xy)
    return FeatureMap(
        method="joint",
        parameters={},
        walls=found.walls(found.gaps(path_xy)),
        corners=found.corners(),
        cylinders=found.cylinders(),
        sweeps=np.array([sweep.index for sweep in elsewhere]),
        poses=moved.poses,
    )


def _stations(sweeps: Sequence[Sweep]) -> np.ndarray:
    """Take every sweep for a station."""
    return np.array([sweep.station for sweep in sweeps])
