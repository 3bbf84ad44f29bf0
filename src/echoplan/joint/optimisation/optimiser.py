"""Adjustment: all features and the calibration of the recording in one robust least-squares problem.

Gauss-Newton on the readings that the features explain, damped where a step would make them fit worse (Levenberg 1944),
with analytic derivatives, weights by Geman and McClure, ties between corners and the walls that make them, and priors
from the rig for what the readings do not determine.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import FloatArray, IntArray
from echoplan.compiled import compiled
from echoplan.joint.optimisation.corner_factors import corner_factors
from echoplan.joint.optimisation.factors import InformationPrior, LinearFactor, held, normal_equations, prior, solve
from echoplan.joint.optimisation.heading_factors import NO_BEARINGS, Bearings, bearing_rows, bearings_of
from echoplan.joint.optimisation.layout import SONAR_UNKNOWNS, Layout
from echoplan.joint.optimisation.manhattan import manhattan_factor
from echoplan.joint.optimisation.pose_factors import at_poses, pose_factors
from echoplan.joint.optimisation.priors import OptimiserSettings, Priors, sonar_prior
from echoplan.joint.optimisation.range_factors import (
    Association,
    Features,
    associate,
    differentiate_readings,
    residuals_of,
)
from echoplan.joint.optimisation.solution import Solution
from echoplan.joint.optimisation.values import Values
from echoplan.preprocessing.measurements import Measurements
from echoplan.preprocessing.servo import late_by, turned_by

__all__ = [
    "Features",
    "OptimiserSettings",
    "Priors",
    "heading_factors",
    "optimise",
    "range_factors",
]

_CYLINDER = int(Kind.CYLINDER)
# Information about features that holds them in place where no reading does.
_HOLD = 0.1
# What the prior alone holds needs no other hold: readings tell of a number what leaves so much of its variance.
_TOLD = 0.5
# What is added to the information of all unknowns until a step does not make readings fit worse (Levenberg 1944): from
# what is known to 3 rad or m to what is known to 0.1 mrad or mm, beyond which nothing is left to move.
_DAMPINGS = tuple(10.0 ** np.arange(-1, 9))


def optimise(
    measurements: Measurements,
    start: Values,
    priors: Priors,
    settings: OptimiserSettings,
    *,
    known: InformationPrior | None = None,
) -> Solution:
    """Adjust features, sonar and, if they may be off, poses to all readings.

    Parameters
    ----------
    measurements : Measurements
        The pings, as heard from the poses that were given.
    start : Values
        Where to start.
    priors : Priors
        What is believed of the sonar.
    settings : OptimiserSettings
        Priors and weights.
    known : InformationPrior, optional
        What readings that are no longer at hand said.

    Returns
    -------
    Solution
        Features, sonar and covariance.
    """
    layout = start.layout
    now, bearings = start, _bearings(measurements, start, priors)
    for _ in range(settings.rounds):
        matched, readings = _linearised(_with_attenuation(measurements, now, priors), now, priors, settings)
        of_readings, reading_gradient = normal_equations([_placed(readings, layout)], layout.size)
        rest, right = normal_equations([bearing_rows(bearings, now)], layout.size)
        if known is not None:
            rest[np.ix_(known.columns, known.columns)] += known.information
            right[known.columns] += known.vector - known.information @ now.values[known.columns]
        detected = of_readings + rest
        information, pull = normal_equations(list(_held_by(now, layout, priors, settings)), layout.size)
        rest, right = rest + information, right + pull
        information = of_readings + rest
        linear = _Linear(matched, readings, rest, right)
        for damping in (0.0, *_DAMPINGS):
            step = _step(information + damping * np.eye(layout.size), reading_gradient + right, now, priors, settings)
            moved = now.moved(step)
            if _rise(measurements, now, moved, priors=priors, linear=linear) <= 0.0:
                break
        now, left = moved, float(step @ information @ step)
        if left < settings.rest:
            break
    return Solution(
        reflectors=now.features.reflectors,
        model=now.model,
        latency=now.latency,
        servo=now.servo,
        poses=now.poses,
        layout=layout,
        information=information,
        detected=detected,
        information_inflation=priors.information_inflation,
        extents=now.features.extents,
        owners=matched.owners,
        residuals=matched.residuals,
        excesses=matched.excesses,
        newton_decrement=left,
    )


def _rise(measurements: Measurements, now: Values, moved: Values, *, priors: Priors, linear: "_Linear") -> float:
    """Return by how much a move raises the weighted squares of the residuals, twice a robust negative log likelihood.

    A wall that turns about the foot of a sensor's axis changes readings by the square of the turn: derivatives say
    nothing of that, and a full step may lead anywhere.  With the weights and owners of the readings held, a fall of the
    squares is a fall of the robust cost, too.  All but the readings is as good as linear.
    """
    change = moved.values - now.values
    detected, hearing = _with_attenuation(measurements, moved, priors), moved.model.tabulated()
    left = residuals_of(detected, hearing, moved.features, linear.matched.owners)
    of_readings = linear.readings.weights @ (left**2 - linear.readings.residuals**2)
    return float(of_readings + change @ (linear.information @ change - 2.0 * linear.right))


def _step(
    information: FloatArray, right: FloatArray, now: Values, priors: Priors, settings: OptimiserSettings
) -> FloatArray:
    """Solve, but keep consider parameters of the sonar at their prior means (Schmidt 1966).

    The exponent of the range walk is one: maps are no better with one that is estimated.  Where the poses drift, two
    more are: all that is left to tell the range scale are the arms of the array, a few centimetres long, and an error
    of the beam's shape by tenths of a millimetre would pass for a percent; and a servo that lags looks like a robot
    that turns a little too far one way and back again, sweep by sweep (it never leads).  Their uncertainty stays in the
    covariance.
    """
    considered = ("walk_exponent", "range_scale", "servo_latency")
    exponent, scale, latency = (now.layout.sonar + SONAR_UNKNOWNS.index(each) for each in considered)
    changes = {exponent: 1.0 - now.model.walk_exponent}
    if priors.drifting:
        changes[scale] = priors.range_scale - now.model.range_scale
    units = np.eye(len(right))[[*changes, latency]]
    step, *columns, by_latency = solve(information, np.column_stack([right, *units])).T
    step = held(step, columns, changes)
    if not priors.drifting:
        return step
    by_latency = held(by_latency, columns, dict.fromkeys(changes, 0.0))
    change, variance = step[latency], by_latency[latency]
    reading_gradient = variance < _TOLD * settings.latency_sigma**2
    if reading_gradient and now.latency + change < settings.determined * math.sqrt(variance):
        return held(step, [by_latency], {latency: -now.latency})
    return step


def range_factors(measurements: Measurements, now: Values, priors: Priors, settings: OptimiserSettings) -> LinearFactor:
    """Linearise the readings that features explain.

    Parameters
    ----------
    measurements : Measurements
        The pings, as heard from the poses that were given.
    now : Values
        Features, sonar and poses.
    priors : Priors
        What is believed of the sonar.
    settings : OptimiserSettings
        Weights.

    Returns
    -------
    LinearFactor
        One a reading.
    """
    _, readings = _linearised(_with_attenuation(measurements, now, priors), now, priors, settings)
    return _placed(readings, now.layout)


def heading_factors(measurements: Measurements, now: Values, priors: Priors) -> LinearFactor:
    """Linearise the bearings of walls, where these tell which way stations face.

    Parameters
    ----------
    soundings, now, beliefs
        As those of ``range_factors``.

    Returns
    -------
    LinearFactor
        One a wall and station; none unless headings are free and walls stand along the axes.
    """
    return bearing_rows(_bearings(measurements, now, priors), now)


def _bearings(measurements: Measurements, now: Values, priors: Priors) -> Bearings:
    """Find the bearings of walls; those of walls that may lie anyhow determine the servo but not the headings."""
    poses, square = priors.poses, priors.squareness
    along_axes = poses is not None and not poses.relative and square is not None and square.along_axes
    if not priors.bearings or not (along_axes or priors.servo is not None):
        return NO_BEARINGS
    detected = _with_attenuation(measurements, now, priors)
    headings = now.poses[:, 2] if len(now.poses) else np.zeros(len(measurements.centers))
    return bearings_of(
        detected, now.model.tabulated(), now.features, headings, servo=None if priors.servo is None else now.servo
    )


class _Readings(NamedTuple):
    """Linearised readings: whose they are, from which station, which wall ends theirs, derivatives and so on."""

    owners: IntArray
    stations: IntArray
    neighbours: IntArray
    jacobian: FloatArray
    residuals: FloatArray
    weights: FloatArray


class _Linear(NamedTuple):
    """Everything about one state: readings with their owners, and normal equations of all that holds it besides."""

    matched: Association
    readings: _Readings
    information: FloatArray
    right: FloatArray


def _with_attenuation(measurements: Measurements, now: Values, priors: Priors) -> Measurements:
    """Place the pings where the servo and the robot were."""
    turned = late_by(measurements, now.latency)
    if priors.servo is not None:
        turned = turned_by(turned, error=now.servo, before=priors.servo)
    return turned if priors.poses is None else at_poses(turned, priors.poses.measured_poses, now.poses)


def _linearised(
    measurements: Measurements, now: Values, priors: Priors, settings: OptimiserSettings
) -> tuple[Association, _Readings]:
    hearing = now.model.tabulated()
    matched = associate(measurements, hearing, now.features, max(0.025, 6.0 * priors.noise))
    explained = np.flatnonzero(matched.owners >= 0)
    model = now.model
    walk = (model.range_offset, model.walk_gain, model.reference_walk, model.walk_exponent)
    jacobian, neighbours = differentiate_readings(measurements, hearing, now.features, matched, explained, walk)
    residuals, excesses = matched.residuals[explained], matched.excesses[explained]
    variances = now.model.variances(excesses, noise=priors.noise)
    bias_variances = variances * (1.0 + residuals**2 / (settings.robust**2 * variances)) ** 2
    counts = priors.effective_sample_ratio * measurements.weights[explained]
    owners, stations = matched.owners[explained], measurements.stations[explained]
    readings = _Readings(
        owners=owners,
        stations=stations,
        neighbours=neighbours,
        jacobian=jacobian if len(now.poses) else jacobian[:, : 5 + len(SONAR_UNKNOWNS)],
        residuals=residuals,
        weights=_capped(counts / bias_variances, owners, stations, _common(now.features.bias_variances, priors)),
    )
    if len(now.poses):
        _add_leverage(jacobian, measurements, explained, now.poses)
    return matched, readings


def _common(bias_variances: FloatArray, priors: Priors) -> FloatArray:
    """Variance of what is wrong together in all that a station says of a feature [m^2], by feature and station.

    Of way-points that is learned from what is left of the readings, whatever the reason.
    """
    by_hand = priors.poses is not None and not priors.poses.relative
    return priors.bias_sigma**2 + (np.zeros_like(bias_variances) if by_hand else bias_variances)


def _capped(weights: FloatArray, owners: IntArray, stations: IntArray, common: FloatArray) -> FloatArray:
    """Let all that a station says of a feature count no more than its common error allows."""
    sums = np.zeros(common.shape)
    np.add.at(sums, (owners, stations), weights)
    capped: FloatArray = weights / (1.0 + (sums * common)[owners, stations])
    return capped


@compiled
def _add_leverage(jacobian: FloatArray, measurements: Measurements, explained: IntArray, poses: FloatArray) -> None:
    """Let a turn of the robot move its sensors, and so the readings."""
    for row, ping in enumerate(explained):
        base = poses[measurements.stations[ping]]
        ahead, aside = measurements.x[ping] - base[0], measurements.y[ping] - base[1]
        jacobian[row, -1] += jacobian[row, -2] * ahead - jacobian[row, -3] * aside


def _placed(readings: _Readings, layout: Layout) -> LinearFactor:
    """Give the derivatives of readings their places among the unknowns."""
    columns = _columns(readings, layout.columns, (layout.sonar, layout.pose))
    return LinearFactor(columns, readings.jacobian, readings.residuals, readings.weights)


@compiled
def _columns(readings: _Readings, of_features: IntArray, starts: tuple[int, int]) -> IntArray:
    """Where parameters of its feature, of the neighbour, of the sonar and of its pose stand, for each reading."""
    columns: IntArray = np.empty(readings.jacobian.shape, np.int64)
    owners, neighbours, stations = readings.owners, readings.neighbours, readings.stations
    (sonar, pose), first = starts, 5 + starts[1] - starts[0]
    for row in range(len(columns)):
        for place in range(3):
            columns[row, place] = of_features[owners[row], place]
        # Of most there is none: that is the last row.
        for place in range(3, 5):
            columns[row, place] = of_features[neighbours[row], place - 3]
        for place in range(5, first):
            columns[row, place] = sonar + place - 5
        for place in range(first, columns.shape[1]):
            columns[row, place] = pose + 3 * stations[row] + place - first
    return columns


def _held_by(now: Values, layout: Layout, priors: Priors, settings: OptimiserSettings) -> Iterator[LinearFactor]:
    """Collect what holds the unknowns besides the pings: priors, and ties of corners to their walls."""
    yield sonar_prior(now, layout.sonar, priors, settings)
    if priors.squareness is not None:
        yield manhattan_factor(priors.squareness, now.features.reflectors[:, 1], layout.starts)
    if priors.poses is not None:
        yield pose_factors(priors.poses, now.poses, layout.pose)
    yield prior(np.arange(layout.sonar), sigma=1.0 / _HOLD, residual=0.0)
    columns = np.flatnonzero(layout.kinds == _CYLINDER)
    residuals = settings.radius - now.features.reflectors[columns, 3]
    yield prior(layout.starts[columns] + 2, sigma=settings.radius_sigma, residual=residuals)
    yield from corner_factors(now.features.reflectors, layout, settings.ties)
