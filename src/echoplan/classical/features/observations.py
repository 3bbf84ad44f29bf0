"""Observations: located and classified objects of single sweeps, before they are put together."""

from dataclasses import dataclass

import numpy as np

from echoplan.arrays import FloatArray, checked_floats, store
from echoplan.extraction import LocatedPoint
from echoplan.model import ClassProbabilities

__all__ = ["Observation", "Stack", "shares", "stations_of"]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Observation:
    """One object as one sweep observed it.

    Parameters
    ----------
    sweep : int
        Number of the sweep.
    point : LocatedPoint
        Its nearest point, seen from the hub.
    degrees : ndarray, shape (3,)
        How much it looks like a corner, a cylinder and a wall.
    pings : int
        How many echoes it gave.
    """

    sweep: int
    point: LocatedPoint
    degrees: FloatArray
    pings: int

    def __post_init__(self) -> None:
        store(self, degrees=checked_floats(self.degrees, name="degrees", shape=(3,)))


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Stack:
    """Observations of one object as arrays: what the fits read.

    Parameters
    ----------
    hubs_xy : ndarray, shape (n, 2)
        Positions of the turret's axis [m].
    bearings : ndarray, shape (n,)
        Directions of the object's normal [rad].
    distances : ndarray, shape (n,)
        Distances from the hub [m].
    bearing_sigmas, distance_sigmas : ndarray, shape (n,)
        Standard deviations [rad], [m].
    """

    hubs_xy: FloatArray
    bearings: FloatArray
    distances: FloatArray
    bearing_sigmas: FloatArray
    distance_sigmas: FloatArray

    @classmethod
    def of(cls, observations: list[Observation], *, floor: tuple[float, float] = (0.0, 0.0)) -> "Stack":
        """Stack observations.

        Parameters
        ----------
        observations : list of Observation
            At least one.
        floor : tuple of float, optional
            What neighbouring echoes have in common and a fit therefore cannot see, as standard deviations of
            bearing and distance [rad, m]; added in quadrature.

        Returns
        -------
        Stack
            The same observations as arrays.
        """
        points = [observation.point for observation in observations]
        variances = np.array([np.diag(point.covariance) for point in points])
        sigmas = np.sqrt(variances + np.square(floor))
        return cls(
            hubs_xy=np.array([point.hub_xy for point in points]),
            bearings=np.array([point.bearing for point in points]),
            distances=np.array([point.distance for point in points]),
            bearing_sigmas=sigmas[:, 0],
            distance_sigmas=sigmas[:, 1],
        )


def shares(degrees: FloatArray) -> ClassProbabilities:
    """Turn memberships, or sums of them, into shares.

    Parameters
    ----------
    degrees : ndarray, shape (3,)
        Memberships of corner, cylinder and wall; negative ones count as none.

    Returns
    -------
    ClassProbabilities
        Shares that sum to one; alike where nothing is positive.

    Examples
    --------
    >>> shares(np.array([-0.1, 0.5, 1.5])).wall
    0.75
    """
    positive = np.maximum(degrees, 0.0)
    if not positive.any():
        positive = np.ones(3)
    corner, cylinder, wall = (float(share) for share in positive / positive.sum())
    return ClassProbabilities(corner=corner, cylinder=cylinder, wall=wall)


def stations_of(members: tuple[Observation, ...]) -> int:
    """Count the sweeps that observations come from.

    Parameters
    ----------
    members : tuple of Observation
        Observations of one object.

    Returns
    -------
    int
        How many different sweeps.
    """
    return len({member.sweep for member in members})
