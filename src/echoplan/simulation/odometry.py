"""Dead reckoning: the poses that a robot estimates from its own motion."""

from dataclasses import replace

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.geometry import compose, invert, wrap
from echoplan.model import Odometry, Rig
from echoplan.simulation.settings import OdometryNoise

__all__ = ["dead_reckoning", "with_odometry"]


def dead_reckoning(map_from_base: FloatArray, noise: OdometryNoise, rng: np.random.Generator) -> FloatArray:
    """Add up noisy motions from the true first pose on.

    The variances of a motion are in proportion to the way and the turn, so that it does not matter in how
    many pieces it is measured.

    Parameters
    ----------
    map_from_base : ndarray, shape (n, 3)
        True poses [m, m, rad].
    noise : OdometryNoise
        How large the errors are.
    rng : Generator
        Source of chance.

    Returns
    -------
    ndarray, shape (n, 3)
        Poses as estimated by the robot [m, m, rad]; the true ones if there is no noise.

    Examples
    --------
    >>> poses = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    >>> dead_reckoning(poses, OdometryNoise(along=0.02), np.random.default_rng(1)).round(3)
    array([[0.   , 0.   , 0.   ],
           [1.007, 0.   , 0.   ]])
    """
    if noise == OdometryNoise():
        return map_from_base
    motions = compose(invert(map_from_base[:-1]), map_from_base[1:])
    ways, turns = np.hypot(motions[:, 0], motions[:, 1]), np.abs(motions[:, 2])
    sigmas = np.column_stack(
        [
            noise.along * np.sqrt(ways),
            noise.lateral * np.sqrt(ways),
            np.sqrt(noise.yaw_per_metre**2 * ways + noise.yaw_per_radian**2 * turns),
        ]
    )
    return _add_up(map_from_base[0], _along_way(motions, sigmas * rng.standard_normal(sigmas.shape)))


def _along_way(motions: FloatArray, errors: FloatArray) -> FloatArray:
    # Errors along and across the way, turned into the robot's frame.
    headings = np.arctan2(motions[:, 1], motions[:, 0])
    cosine, sine = np.cos(headings), np.sin(headings)
    return motions + np.column_stack(
        [cosine * errors[:, 0] - sine * errors[:, 1], sine * errors[:, 0] + cosine * errors[:, 1], errors[:, 2]]
    )


def _add_up(first: FloatArray, motions: FloatArray) -> FloatArray:
    yaws = first[2] + np.concatenate([[0.0], np.cumsum(motions[:, 2])])
    cosine, sine = np.cos(yaws[:-1]), np.sin(yaws[:-1])
    steps = np.column_stack(
        [cosine * motions[:, 0] - sine * motions[:, 1], sine * motions[:, 0] + cosine * motions[:, 1]]
    )
    places = first[:2] + np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
    return np.column_stack([places, wrap(yaws)])


def with_odometry(rig: Rig, noise: OdometryNoise) -> Rig:
    """State in a rig how far its dead reckoning may be off, as a careful maker would.

    Parameters
    ----------
    rig : Rig
        The rig.
    noise : OdometryNoise
        How large the errors are.

    Returns
    -------
    Rig
        The same rig if there is no noise.

    Examples
    --------
    >>> from echoplan.io import builtin_rig
    >>> with_odometry(builtin_rig("ring-16"), OdometryNoise(along=0.02)).odometry.along
    0.02
    """
    return rig if noise == OdometryNoise() else replace(rig, odometry=Odometry(**noise.model_dump()))
