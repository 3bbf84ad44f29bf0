"""Least-squares lines and circles through located points, with their covariances.

A located point says two things of its object: how far it is from the hub, and in which direction its normal lies.
A line and a circle each predict both; Gauss-Newton makes the squares of what is left over least.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.classical.features.observations import Stack
from echoplan.geometry import circular_mean, directions, signed_distances, wrap

__all__ = ["Fit", "fit_circle", "fit_line"]

# Predicted bearings and distances (2, n) and their derivatives by the parameters (2, n, p).
Prediction: TypeAlias = tuple[FloatArray, FloatArray]

_STEPS = 30
_CONVERGED = 1e-10


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Fit:
    """A line or a circle fitted to n located points.

    Parameters
    ----------
    parameters : ndarray, shape (p,)
        ``(normal_angle, offset)`` of a line whose normal points away from the hubs [rad, m], or
        ``(x, y, radius)`` of a circle [m].
    covariance : ndarray, shape (p, p)
        Of the parameters, in that order.
    bearing_residuals, distance_residuals : ndarray, shape (n,)
        Observed less predicted [rad], [m].
    """

    parameters: FloatArray
    covariance: FloatArray
    bearing_residuals: FloatArray
    distance_residuals: FloatArray


def fit_line(stack: Stack) -> Fit:
    """Fit the line that all located points touch.

    Parameters
    ----------
    stack : Stack
        At least one located point.

    Returns
    -------
    Fit
        ``(normal_angle, offset)`` [rad, m].

    Examples
    --------
    >>> stack = Stack(
    ...     hubs_xy=np.array([[0.0, 0.0], [1.0, 0.0]]), bearings=np.array([1.55, 1.59]),
    ...     distances=np.array([2.0, 2.0]), bearing_sigmas=np.full(2, 0.02), distance_sigmas=np.full(2, 0.003))
    >>> fit_line(stack).parameters.round(3)
    array([1.571, 2.   ])
    """

    def predict(line: FloatArray) -> Prediction:
        """Return the bearing [rad] and distance [m] at which each hub measures a line, and their Jacobians."""
        along = stack.hubs_xy @ directions(line[0] + np.pi / 2)
        one, zero = np.ones_like(along), np.zeros_like(along)
        predicted = np.stack([line[0] * one, -signed_distances(line, stack.hubs_xy)])
        slopes = np.stack([np.stack([one, zero], axis=1), np.stack([-along, one], axis=1)])
        return predicted, slopes

    angle = circular_mean(stack.bearings)
    offset = float(np.mean(stack.distances + stack.hubs_xy @ directions(angle)))
    fit = _gauss_newton(predict, stack, start=np.array([angle, offset]), prior=np.zeros((2, 2)))
    fit.parameters[0] = wrap(fit.parameters[0])
    return fit


def fit_circle(stack: Stack, *, radius: float, radius_sigma: float) -> Fit:
    """Fit the circle that all located points touch.

    Parameters
    ----------
    stack : Stack
        At least one located point.
    radius, radius_sigma : float
        Prior of the radius, as mean and standard deviation [m]: seen from one side, a radius cannot be
        distinguished from a distance.

    Returns
    -------
    Fit
        ``(x, y, radius)`` [m]; the radius may come out negative where the points contradict a circle.

    Examples
    --------
    >>> stack = Stack(
    ...     hubs_xy=np.array([[0.0, 0.0], [1.0, -1.0], [2.0, 0.0]]), bearings=np.array([0.0, np.pi / 2, np.pi]),
    ...     distances=np.full(3, 0.8), bearing_sigmas=np.full(3, 0.02), distance_sigmas=np.full(3, 0.003))
    >>> fit_circle(stack, radius=0.1, radius_sigma=0.1).parameters.round(3) + 0.0
    array([1. , 0. , 0.2])
    """

    def predict(circle: FloatArray) -> Prediction:
        """Return the bearing [rad] and distance [m] at which each hub measures a circle, and their Jacobians."""
        away = circle[:2] - stack.hubs_xy
        depths = np.maximum(np.hypot(*away.T), _CONVERGED)
        unit = away / depths[:, None]
        predicted = np.stack([np.arctan2(away[:, 1], away[:, 0]), depths - circle[2]])
        turns = np.stack([-unit[:, 1], unit[:, 0], np.zeros_like(depths)], axis=1) / depths[:, None]
        return predicted, np.stack([turns, np.column_stack([unit, -np.ones_like(depths)])])

    centers = stack.hubs_xy + (stack.distances + radius)[:, None] * directions(stack.bearings)
    prior = np.diag([0.0, 0.0, radius_sigma**-2])
    return _gauss_newton(predict, stack, start=np.append(centers.mean(axis=0), radius), prior=prior)


def _gauss_newton(
    predict: Callable[[FloatArray], Prediction], stack: Stack, *, start: FloatArray, prior: FloatArray
) -> Fit:
    """Least squares from a start; the prior is the information that the start itself carries.

    A step that makes the squares greater is halved until it does not: far from the minimum a circle would run away.
    """
    sigmas = np.stack([stack.bearing_sigmas, stack.distance_sigmas])

    def linearised(parameters: FloatArray) -> tuple[float, FloatArray, FloatArray]:
        """Return the weighted sum of squares with the prior, the residuals [rad, m], and the Jacobians."""
        predicted, slopes = predict(parameters)
        residuals = np.stack([wrap(stack.bearings - predicted[0]), stack.distances - predicted[1]])
        off = parameters - start
        return float(np.square(residuals / sigmas).sum() + off @ prior @ off), residuals, slopes

    parameters = start.copy()
    cost, residuals, slopes = linearised(parameters)
    for _ in range(_STEPS):
        jacobian = (slopes / sigmas[..., None]).reshape(-1, len(start))
        information = jacobian.T @ jacobian + prior
        gradient = jacobian.T @ (residuals / sigmas).ravel() + prior @ (start - parameters)
        change = np.linalg.solve(information, gradient)
        trial = linearised(parameters + change)
        while trial[0] > cost and np.abs(change).max() >= _CONVERGED:
            change = change / 2
            trial = linearised(parameters + change)
        parameters = parameters + change
        cost, residuals, slopes = trial
        if np.abs(change).max() < _CONVERGED:
            break
    covariance = np.asarray(np.linalg.inv(information), dtype=np.float64)
    return Fit(
        parameters=parameters,
        covariance=covariance,
        bearing_residuals=residuals[0],
        distance_residuals=residuals[1],
    )
