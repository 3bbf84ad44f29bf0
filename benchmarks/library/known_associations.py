"""Told: the map that comes out of way-points set elsewhere if somebody tells which echo is of which wall."""

import copy
import math
from collections.abc import Sequence

import numpy as np

from echoplan.joint.estimate import Account
from echoplan.joint.mapper import JointSettings
from echoplan.joint.marginalisation import survey
from echoplan.joint.optimisation.pose_factors import displaced, waypoint_beliefs
from echoplan.joint.pose_model_selection import explained
from echoplan.model import FeatureMap, Rig, Sweep
from echoplan.preprocessing.ping_arrays import join_soundings, soundings_of

__all__ = ["told_map"]

# By then nothing moves any more.
_ROUNDS, _STILL = 40, 1e-6


def told_map(rig: Rig, sweeps: Sequence[Sweep], elsewhere: Sequence[Sweep], *, off: float) -> FeatureMap:
    """Adjust the right map to way-points that were put elsewhere, without looking for anything.

    Nothing is searched for and nothing dropped, headings are free, and how far way-points are off is known, as well as
    which walls stand at right angles.

    Parameters
    ----------
    rig : Rig
        What made the sweeps.
    sweeps : sequence of Sweep
        As they were recorded: what is made of these is told.
    elsewhere : sequence of Sweep
        The same with other way-points.
    off : float
        How far each is from where it was recorded, in some direction [m].

    Returns
    -------
    FeatureMap
        Where the features are by the other way-points.
    """
    heard, given = join_soundings([soundings_of(each, rig) for each in sweeps]), _stations(sweeps)
    moved = copy.copy(explained(Account(rig, heard, given, JointSettings())))
    moved.given = _stations(elsewhere)
    moved.recorded = displaced(moved.recorded, given, moved.given)
    # A step in some direction has half of its square along either axis.
    beliefs = {"waypoint": max(off, 1e-3) / math.sqrt(2.0), "waypoint_turn": math.pi}
    poses = waypoint_beliefs(moved.given, moved.settings.pose_errors.model_copy(update=beliefs))
    for _ in range(_ROUNDS):
        moved.adjust(moved.noise, poses)
        if moved.adjusted is None or moved.adjusted.left < _STILL:
            break
    path_xy = moved.poses[:, :2]
    found = survey(moved, path_xy)
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
