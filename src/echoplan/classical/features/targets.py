"""Line, point and circle targets: which object explains observations from several stations best.

The regions of a plane touch one line, those of a corner cross in one point, those of a cylinder touch one circle
(Leonard and Durrant-Whyte, *Directed Sonar Sensing for Mobile Robot Navigation*, 1992).  From one station the three
look alike, so the hypotheses compete for the views from several.
"""

from dataclasses import dataclass
from enum import Enum

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.classical.features.association import AssociationSettings, Group, group_lines
from echoplan.classical.features.cylinders import CylinderSettings
from echoplan.classical.features.fits import fit_circle, fit_line
from echoplan.classical.features.observations import Observation, Stack
from echoplan.geometry import wrap

__all__ = ["Target", "TargetKind", "find_targets"]

# A point is a circle whose radius is known to be 0, up to so much [m].
_POINT = 1e-6


class TargetKind(Enum):
    """What the observations of a target have in common: a tangent, a point or a circle."""

    LINE = "line"
    POINT = "point"
    CIRCLE = "circle"


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Target:
    """A group of observations with the line or circle that explains it.

    Parameters
    ----------
    kind : TargetKind
        What was fitted; a point is a circle of radius 0.
    group : Group
        The observations and the fit.
    chi_squares : ndarray, shape (n,)
        Squared residuals of each observation over their variances.
    prior : float
        The same of the radius against its prior.
    """

    kind: TargetKind
    group: Group
    chi_squares: FloatArray
    prior: float = 0.0

    @property
    def gain(self) -> float:
        """By how much the Akaike information criterion falls when one target replaces an object per observation.

        An object of its own costs an observation two for each of two parameters and leaves no residual, so none loses
        more by joining a target.
        """
        parameters = 3 if self.kind is TargetKind.CIRCLE else 2
        return float(np.maximum(4.0 - self.chi_squares, 0.0).sum()) - 2.0 * parameters - self.prior


def find_targets(
    observations: list[Observation],
    gates: AssociationSettings,
    cylinders: CylinderSettings,
    *,
    min_stations: int = 2,
) -> list[Target]:
    """Explain observations by lines, points and circles, each observation by one of them.

    The hypothesis of the greatest gain is accepted first.  It keeps its observations, and the others are fitted again
    without them.

    Parameters
    ----------
    observations : list of Observation
        Observations of any objects.
    gates : AssociationSettings
        Greatest residuals of an observation that belongs to a target.
    cylinders : CylinderSettings
        Prior of the radius of circles.
    min_stations : int, optional
        A target seen from fewer stations is none.

    Returns
    -------
    list of Target
        In the order in which they were accepted.  Observations that no target explains are in none.
    """
    hypotheses = [_fitted(TargetKind.LINE, each.members, gates, cylinders) for each in group_lines(observations, gates)]
    for kind in (TargetKind.POINT, TargetKind.CIRCLE):
        hypotheses += _grown(kind, observations, gates, cylinders)
    accepted: list[Target] = []
    while hopeful := [each for each in hypotheses if each.gain > 0 and each.group.stations >= min_stations]:
        best = max(hopeful, key=lambda each: each.gain)
        accepted.append(best)
        rest = (_without(best.group.members, each, gates, cylinders) for each in hopeful if each is not best)
        hypotheses = [each for each in rest if each is not None]
    return accepted


def _fitted(
    kind: TargetKind, members: tuple[Observation, ...], gates: AssociationSettings, cylinders: CylinderSettings
) -> Target:
    """Fit a target of a kind to observations."""
    stack = Stack.of(list(members), floor=(gates.common_bearing_sigma, gates.common_distance_sigma))
    prior = 0.0
    if kind is TargetKind.LINE:
        fit = fit_line(stack)
    elif kind is TargetKind.POINT:
        fit = fit_circle(stack, radius=0.0, radius_sigma=_POINT)
    else:
        fit = fit_circle(stack, radius=cylinders.radius, radius_sigma=cylinders.radius_sigma)
        prior = float((fit.parameters[2] - cylinders.radius) / cylinders.radius_sigma) ** 2
    bearings, distances = fit.bearing_residuals / stack.bearing_sigmas, fit.distance_residuals / stack.distance_sigmas
    return Target(kind=kind, group=Group(members=members, fit=fit), chi_squares=bearings**2 + distances**2, prior=prior)


def _grown(
    kind: TargetKind, observations: list[Observation], gates: AssociationSettings, cylinders: CylinderSettings
) -> list[Target]:
    """Let points or circles grow: the surest observation opens one, each further one joins where it fits best."""
    targets: list[Target] = []
    for observation in sorted(observations, key=lambda each: each.point.covariance[0, 0]):
        wider = {
            number: _fitted(kind, (*target.group.members, observation), gates, cylinders)
            for number, target in enumerate(targets)
            if _is_near(target, observation, gates)
        }
        fitting = {number: target for number, target in wider.items() if _is_within(target, gates)}
        if fitting:
            best = min(
                fitting, key=lambda number: fitting[number].chi_squares.sum() - targets[number].chi_squares.sum()
            )
            targets[best] = fitting[best]
        else:
            targets.append(_fitted(kind, (observation,), gates, cylinders))
    return targets


def _is_near(target: Target, observation: Observation, gates: AssociationSettings) -> bool:
    """Return whether an observation is so near that a fit with it may succeed: a fit may move the centre."""
    x, y, radius = target.group.fit.parameters
    point, depth = observation.point, target.group.members[0].point.distance
    away = np.array([x, y]) - point.hub_xy
    turn = abs(float(wrap(np.arctan2(away[1], away[0]) - point.bearing)))
    miss = abs(float(np.hypot(*away)) - radius - point.distance)
    slack = 2 * gates.bearing_gate * depth
    return miss <= gates.distance_gate + slack and turn <= 2 * gates.bearing_gate + slack / max(point.distance, slack)


def _is_within(target: Target, gates: AssociationSettings) -> bool:
    """Return whether all residuals lie within the gates and the radius is none that no object has."""
    fit = target.group.fit
    bearing, distance = np.abs(fit.bearing_residuals).max(), np.abs(fit.distance_residuals).max()
    return bool(bearing <= gates.bearing_gate and distance <= gates.distance_gate and fit.parameters[2] > -3 * _POINT)


def _without(
    taken: tuple[Observation, ...], target: Target, gates: AssociationSettings, cylinders: CylinderSettings
) -> Target | None:
    """Fit a target again without some observations; None if nothing is left."""
    left = tuple(each for each in target.group.members if not any(each is other for other in taken))
    if len(left) == len(target.group.members):
        return target
    return _fitted(target.kind, left, gates, cylinders) if left else None
