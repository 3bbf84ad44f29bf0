"""Cylinders: circles fitted to the observations of several sweeps."""

import numpy as np
from pydantic import Field

from echoplan.classical.features.association import AssociationSettings
from echoplan.classical.features.fits import fit_circle
from echoplan.classical.features.observations import Observation, Stack, shares, stations_of
from echoplan.model import Cylinder
from echoplan.settings import Settings

__all__ = ["CylinderSettings", "cylinder_of"]


class CylinderSettings(Settings):
    """What is known of cylinders beforehand."""

    radius: float = Field(default=0.1, gt=0.0, description="Expected radius of a cylinder [m].")
    radius_sigma: float = Field(default=0.1, gt=0.0, description="Standard deviation of the expected radius [m].")


def cylinder_of(
    members: tuple[Observation, ...], settings: CylinderSettings, *, association: AssociationSettings
) -> Cylinder | None:
    """Fit a circle to the observations of one cylinder.

    Parameters
    ----------
    members : tuple of Observation
        Observations of one object.
    settings : CylinderSettings
        What is known of the radius.
    association : AssociationSettings
        What the echoes of one sweep have in common.

    Returns
    -------
    Cylinder or None
        None if the radius is negative, so that the object is no cylinder, or if its standard deviation exceeds the
        gate of association: the stations are too close to each other to determine it.
    """
    floor = (association.common_bearing_sigma, association.common_distance_sigma)
    stack = Stack.of(list(members), floor=floor)
    fit = fit_circle(stack, radius=settings.radius, radius_sigma=settings.radius_sigma)
    if fit.parameters[2] <= 0 or fit.covariance[2, 2] > association.point_gate**2:
        return None
    return Cylinder(
        center_xy=fit.parameters[:2],
        radius=float(fit.parameters[2]),
        covariance=fit.covariance,
        class_probabilities=shares(np.sum([member.degrees for member in members], axis=0)),
        pings=sum(member.pings for member in members),
        stations=stations_of(members),
    )
