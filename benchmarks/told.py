"""Told: the map that comes out of way-points set elsewhere if somebody tells which echo is of which wall."""

import math
from collections.abc import Sequence

import numpy as np

from echoplan.mapping.joint.account import Account
from echoplan.mapping.joint.adjustment.poses import displaced, waypoint_beliefs
from echoplan.mapping.joint.explaining import explained
from echoplan.mapping.joint.legacy import survey
from echoplan.methods.joint import JointSettings
from echoplan.model import FeatureMap, Rig, Sweep
from echoplan.preprocessing.soundings import join_soundings, soundings_of

__all__ = ["told_map"]

# What an adjustment that starts from the right map is told of that map: all but where things are.
_TOLD = ("model", "noise", "loudness", "independence", "pair_sigma", "square_sigma", "is_along_axes", "is_polished")
# By then nothing moves any more.
_ROUNDS, _STILL = 40, 1e-6


def told_map(rig: Rig, sweeps: Sequence[Sweep], elsewhere: Sequence[Sweep], *, off: float) -> FeatureMap:
    """Adjust the right map to way-points that were put elsewhere, without looking for anything.

    Nothing is searched for and nothing dropped, headings are free, and how far way-points are off is known, as well as
    which walls stand at right angles: no method that must find this by itself can be expected to come nearer.

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
    known, moved = explained(_account(rig, sweeps)), _account(rig, elsewhere)
    for name in _TOLD:
        setattr(moved, name, getattr(known, name))
    moved.features, moved.poses = known.features, known.poses.copy()
    moved.soundings = displaced(moved.recorded, moved.given, moved.poses)
    # A step in some direction has half of its square along either axis.
    beliefs = {"waypoint": max(off, 1e-3) / math.sqrt(2.0), "waypoint_turn": math.pi}
    poses = waypoint_beliefs(moved.given, moved.settings.pose_errors.model_copy(update=beliefs))
    for _ in range(_ROUNDS):
        moved.adjust(moved.noise, poses)
        if moved.adjusted is None or moved.adjusted.left < _STILL:
            break
    found = survey(moved)
    return FeatureMap(
        method="joint",
        parameters={},
        walls=found.walls(),
        corners=found.corners(),
        cylinders=found.cylinders(),
        sweeps=np.array([sweep.index for sweep in elsewhere]),
        poses=moved.poses,
    )


def _account(rig: Rig, sweeps: Sequence[Sweep]) -> Account:
    """Take every sweep for a station."""
    heard, given = [soundings_of(sweep, rig) for sweep in sweeps], np.array([sweep.station for sweep in sweeps])
    return Account(rig, join_soundings(heard), given, JointSettings())
