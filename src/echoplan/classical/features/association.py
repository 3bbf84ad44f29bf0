"""Association over stations: which observations are one object."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from echoplan.arrays import FloatArray
from echoplan.classical.features.fits import Fit, fit_line
from echoplan.classical.features.observations import Observation, Stack, stations_of
from echoplan.geometry import directions, signed_distances, wrap
from echoplan.settings import Settings

__all__ = ["AssociationSettings", "Group", "absorb", "group_lines", "group_points"]


class AssociationSettings(Settings):
    """What may be put together; the paper names no numbers for it."""

    former_keys: ClassVar = {"bearing_floor": "common_bearing_sigma", "distance_floor": "common_distance_sigma"}

    bearing_gate: float = Field(
        default=0.14, gt=0.0, description="Largest residual of the direction of a normal [rad]."
    )
    distance_gate: float = Field(default=0.03, gt=0.0, description="Largest residual of the distance from a line [m].")
    point_gate: float = Field(default=0.15, gt=0.0, description="Largest distance between points of one object [m].")
    common_bearing_sigma: float = Field(
        default=0.0175,
        gt=0.0,
        description="Standard deviation of the bearing error that all echoes of a sweep share [rad]: a step of 1 "
        "degree.",
    )
    common_distance_sigma: float = Field(
        default=0.003,
        gt=0.0,
        description="Standard deviation of the range error that all echoes of a sweep share [m]: range walk that "
        "no compensation removes.",
    )


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Group:
    """Observations of one object and what was fitted to them.

    Parameters
    ----------
    members : tuple of Observation
        The observations.
    fit : Fit
        Line or circle through them.
    """

    members: tuple[Observation, ...]
    fit: Fit

    @property
    def stations(self) -> int:
        """Number of sweeps that detected the object."""
        return stations_of(self.members)

    @property
    def pings(self) -> int:
        """How many echoes it gave in all."""
        return sum(member.pings for member in self.members)

    @property
    def degrees(self) -> FloatArray:
        """Sum of its memberships in corner, cylinder and wall, shape (3,)."""
        total: FloatArray = np.array([member.degrees for member in self.members]).sum(axis=0)
        return total


def group_lines(observations: list[Observation], settings: AssociationSettings) -> list[Group]:
    """Put observations together that one line explains.

    The surest observation opens a group; each further one joins the group whose line, fitted again with it,
    leaves the least residual within the gates, or opens another.

    Parameters
    ----------
    observations : list of Observation
        Observations of flats.
    settings : AssociationSettings
        The gates.

    Returns
    -------
    list of Group
        Each with its line; empty if there are no observations.
    """
    groups: list[Group] = []
    for observation in sorted(observations, key=lambda each: each.point.covariance[0, 0]):
        if not _joined(groups, observation, settings):
            groups.append(_line_group((observation,), settings))
    return groups


def absorb(groups: list[Group], observations: list[Observation], settings: AssociationSettings) -> list[Observation]:
    """Let lines take the observations that lie on them, whatever they looked like by themselves.

    Parameters
    ----------
    groups : list of Group
        Lines; changed in place.
    observations : list of Observation
        Observations of other classes.
    settings : AssociationSettings
        The gates.

    Returns
    -------
    list of Observation
        Those that lie on no line.
    """
    return [observation for observation in observations if not _joined(groups, observation, settings)]


def group_points(
    observations: list[Observation], settings: AssociationSettings, *, depth: ArrayLike = 0.0
) -> list[tuple[Observation, ...]]:
    """Put observations together that lie close to each other.

    Parameters
    ----------
    observations : list of Observation
        Observations of cylinders or corners.
    settings : AssociationSettings
        The gate.
    depth : array_like, optional
        How far behind its nearest point the middle of each object lies [m]; broadcasts to shape (n,).

    Returns
    -------
    list of tuple of Observation
        Groups in which every member is linked to another by less than the gate.
    """
    from scipy.sparse.csgraph import connected_components  # noqa: PLC0415
    from scipy.spatial import cKDTree  # noqa: PLC0415 - only mappers need it

    if not observations:
        return []
    nearest = np.array([each.point.position_xy for each in observations])
    inward = directions(np.array([each.point.bearing for each in observations]))
    middles = nearest + np.broadcast_to(depth, len(observations))[:, None] * inward
    tree = cKDTree(middles)
    near = tree.sparse_distance_matrix(tree, settings.point_gate)
    count, labels = connected_components(near > 0, directed=False)
    return [
        tuple(each for each, own in zip(observations, labels, strict=True) if own == label) for label in range(count)
    ]


def _joined(groups: list[Group], observation: Observation, settings: AssociationSettings) -> bool:
    """Add an observation to the group that it fits best; return whether it fits any."""
    near = [number for number, group in enumerate(groups) if _is_near(group, observation, settings)]
    wider = {number: _line_group((*groups[number].members, observation), settings) for number in near}
    misfits = {number: _misfit(group, settings) for number, group in wider.items()}
    best = min(misfits, key=misfits.__getitem__, default=None)
    if best is None or misfits[best] > 1.0:
        return False
    groups[best] = wider[best]
    return True


def _is_near(group: Group, observation: Observation, settings: AssociationSettings) -> bool:
    """Return whether a group's line is near enough to try a fit with the observation.

    A line fitted to one point is uncertain by the gate of the bearing, so its miss grows with the distance of the hubs.
    """
    angle, offset = group.fit.parameters
    point = observation.point
    turn = abs(float(wrap(point.bearing - angle)))
    way = float(np.hypot(*(point.hub_xy - group.members[0].point.hub_xy)))
    miss = abs(float(signed_distances(np.array([angle, offset]), point.position_xy)))
    return turn <= 2 * settings.bearing_gate and miss <= settings.distance_gate + 2 * settings.bearing_gate * way


def _line_group(members: tuple[Observation, ...], settings: AssociationSettings) -> Group:
    floor = (settings.common_bearing_sigma, settings.common_distance_sigma)
    return Group(members=members, fit=fit_line(Stack.of(list(members), floor=floor)))


def _misfit(group: Group, settings: AssociationSettings) -> float:
    """Greatest residual over its gate: more than one means that something does not belong."""
    return float(
        max(
            np.abs(group.fit.bearing_residuals).max() / settings.bearing_gate,
            np.abs(group.fit.distance_residuals).max() / settings.distance_gate,
        )
    )
