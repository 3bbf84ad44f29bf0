"""The optimiser: all landmarks, the calibration and the poses in one robust least-squares problem.

Gauss-Newton with analytic Jacobians on the associated readings, damped if a full step raises the cost (Levenberg 1944),
the robust kernel of Geman and McClure (1985), factors between corners and their walls, and priors of the rig for what
the readings do not determine.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import FloatArray, IntArray
from echoplan.compiled import compiled
from echoplan.joint.optimisation.corner_factors import corner_factors
from echoplan.joint.optimisation.factors import InformationPrior, LinearFactor, normal_equations, prior
from echoplan.joint.optimisation.heading_factors import (
    NO_HEADINGS,
    HeadingMeasurements,
    heading_factor,
    heading_measurements_of,
)
from echoplan.joint.optimisation.layout import (
    LANDMARK_COLUMNS,
    NEIGHBOUR_COLUMNS,
    POSE_COLUMNS,
    SONAR_COLUMNS,
    SONAR_UNKNOWNS,
    Layout,
)
from echoplan.joint.optimisation.manhattan import manhattan_factor
from echoplan.joint.optimisation.pose_factors import at_poses, bridge_variances, neighbours_of, pose_factors
from echoplan.joint.optimisation.priors import OptimiserSettings, Priors, sonar_prior
from echoplan.joint.optimisation.range_factors import (
    Association,
    Features,
    associate,
    range_jacobian,
    residuals_of,
)
from echoplan.joint.optimisation.solution import Solution
from echoplan.joint.optimisation.solver import held, solve
from echoplan.joint.optimisation.values import Values
from echoplan.preprocessing.measurements import Measurements
from echoplan.preprocessing.servo import apply_servo_latency, turned_by

__all__ = [
    "Features",
    "OptimiserSettings",
    "Priors",
    "Problem",
    "consider_parameters",
    "geman_mcclure_variances",
    "heading_factors",
    "optimise",
    "range_factors",
]

_CYLINDER = int(Kind.CYLINDER)
# Inverse standard deviation of the weak prior of landmarks that no reading determines [1/m, 1/rad].
_HOLD = 0.1
# Largest share of the squared noise that may be drift of odometry within sweeps; the rest is noise of the readings.
# Chosen on drives 2 and 3 of benchmarks/moving_head.py --wait.
_DRIFT = 0.9
# The latency counts as determined by the readings if these leave less than this share of its prior variance.
_DETERMINED = 0.5
# Damping that is added to the information until a step does not raise the cost (Levenberg 1944): from a prior of 3 m or
# rad to one of 0.1 mm or mrad.
_DAMPINGS = tuple(10.0 ** np.arange(-1, 9))


class Problem(NamedTuple):
    """The arguments of ``optimise``."""

    measurements: Measurements
    start: Values
    priors: Priors
    settings: OptimiserSettings
    known: InformationPrior | None = None


def optimise(
    measurements: Measurements,
    start: Values,
    priors: Priors,
    settings: OptimiserSettings,
    known: InformationPrior | None = None,
) -> Solution:
    """Return the landmarks, calibration and, if they have a prior, poses that fit all readings best.

    ``measurements`` are placed by the poses as recorded. ``known`` is the marginal prior of readings that are no longer
    available.
    """
    layout, latency = start.layout, start.layout.sonar + SONAR_UNKNOWNS.index("servo_latency")
    now, headings, units = start, _heading_measurements(measurements, start, priors), np.eye(start.layout.size)
    for _ in range(settings.max_iterations):
        linear = _linearise(measurements, now, priors, settings, headings=headings, known=known)
        changes = consider_parameters(now, priors)
        right = np.column_stack([linear.range_vector + linear.vector, *units[[*changes, latency]]])
        for damping in (0.0, *_DAMPINGS):
            step, *columns, by_latency = solve(linear.information + damping * units, right).T
            step = held(step, columns, changes)
            if priors.drifting:
                by_latency = held(by_latency, columns, dict.fromkeys(changes, 0.0))
                variance = by_latency[latency]
                least = settings.min_latency_z * math.sqrt(variance)
                if variance < _DETERMINED * settings.latency_sigma**2 and now.latency + step[latency] < least:
                    step = held(step, [by_latency], {latency: -now.latency})
            moved = now.retracted(step)
            if _rise(measurements, now, moved, priors=priors, linear=linear) <= 0.0:
                break
        now, newton_decrement = moved, float(step @ linear.information @ step)
        if newton_decrement < settings.tolerance:
            break
    return Solution(
        reflectors=now.features.reflectors,
        model=now.model,
        latency=now.latency,
        servo=now.servo,
        poses=now.poses,
        layout=layout,
        information=linear.information,
        measurement_information=linear.measured,
        information_inflation=priors.information_inflation,
        extents=now.features.extents,
        owners=linear.association.owners,
        residuals=linear.association.residuals,
        excesses=linear.association.excesses,
        newton_decrement=newton_decrement,
    )


def _rise(measurements: Measurements, now: Values, moved: Values, *, priors: Priors, linear: "_Linearisation") -> float:
    """Return the change of the weighted squares of the residuals by a move, twice a robust negative log-likelihood.

    A rotation of a wall about the foot of a sensor's perpendicular changes the reading only to second order, which the
    Jacobian does not contain, so a full step may raise the cost. With the weights and owners of the readings fixed, a
    decrease of the squares is a decrease of the robust cost. All factors but the readings are nearly linear.
    """
    change = moved.values - now.values
    detected, tables = _at_present(measurements, moved, priors), moved.model.tabulated()
    residuals = residuals_of(detected, tables, moved.features, linear.association.owners)
    of_readings = linear.readings.weights @ (residuals**2 - linear.readings.residuals**2)
    return float(of_readings + change @ (linear.rest @ change - 2.0 * linear.vector))


def consider_parameters(now: Values, priors: Priors) -> dict[int, float]:
    """Return by position the changes that put the consider parameters of the sonar at their prior means (Schmidt 1966).

    The walk exponent always is one: estimating it does not improve maps. While poses drift, the range scale is another:
    only the arms of the array, a few centimetres long, would determine it, and an error of the beam model of tenths of
    a millimetre would change it by a percent. A servo latency looks like a robot that turns slightly too far one way
    and back again, sweep by sweep; ``optimise`` holds it at zero if it is determined, but negative or below two sigmas.
    The uncertainty of all three remains in the covariance.
    """
    exponent, scale = (now.layout.sonar + SONAR_UNKNOWNS.index(each) for each in ("walk_exponent", "range_scale"))
    changes = {exponent: 1.0 - now.model.walk_exponent}
    if priors.drifting:
        changes[scale] = priors.range_scale - now.model.range_scale
    return changes


def range_factors(measurements: Measurements, now: Values, priors: Priors, settings: OptimiserSettings) -> LinearFactor:
    """Return the range factors, one row per explained reading; ``measurements`` are placed by the poses as recorded."""
    _, readings = _linearise_readings(_at_present(measurements, now, priors), now, priors, settings)
    return _placed(readings, now.layout)


def heading_factors(measurements: Measurements, now: Values, priors: Priors) -> LinearFactor:
    """Return the heading factors, one row per wall and station, and per sensor if the servo is calibrated.

    There are none unless ``priors.bearings`` is set, and the servo is calibrated or poses are absolute and walls are
    along the axes of the map.
    """
    return heading_factor(_heading_measurements(measurements, now, priors), now)


def _heading_measurements(measurements: Measurements, now: Values, priors: Priors) -> HeadingMeasurements:
    """Measure the directions of walls as seen from stations, if they can determine yaw or servo."""
    poses, manhattan_prior = priors.poses, priors.manhattan_prior
    along_axes = poses is not None and not poses.relative and manhattan_prior is not None and manhattan_prior.along_axes
    if not priors.bearings or not (along_axes or priors.servo is not None):
        return NO_HEADINGS
    detected = _at_present(measurements, now, priors)
    headings = now.poses[:, 2] if len(now.poses) else np.zeros(len(measurements.centers))
    return heading_measurements_of(
        detected, now.model.tabulated(), now.features, headings, servo=None if priors.servo is None else now.servo
    )


class _RangeLinearisation(NamedTuple):
    """Linearised readings: landmark, stations and neighbouring wall of each, Jacobian, residuals [m] and weights.

    ``stations``, shape (m, 1), are those whose poses place a reading: (m, 2) if the robot drove meanwhile.
    """

    owners: IntArray
    stations: IntArray
    neighbours: IntArray
    jacobian: FloatArray
    residuals: FloatArray
    weights: FloatArray


class _Linearisation(NamedTuple):
    """All factors linearised at one state: associated readings, and their normal equations.

    ``information`` and ``measured`` are those of all factors and of all measurements; ``rest`` and ``vector`` are those
    of all factors but the readings, whose vector is ``range_vector``.
    """

    association: Association
    readings: _RangeLinearisation
    information: FloatArray
    measured: FloatArray
    range_vector: FloatArray
    rest: FloatArray
    vector: FloatArray


def _at_present(measurements: Measurements, now: Values, priors: Priors) -> Measurements:
    """Return the pings as placed by the present latency, servo and poses."""
    turned = apply_servo_latency(measurements, now.latency)
    if priors.servo is not None:
        turned = turned_by(turned, error=now.servo, before=priors.servo)
    return turned if priors.poses is None else at_poses(turned, priors.poses.measured_poses, now.poses)


def _linearise(
    measurements: Measurements,
    now: Values,
    priors: Priors,
    settings: OptimiserSettings,
    *,
    headings: HeadingMeasurements,
    known: InformationPrior | None,
) -> _Linearisation:
    """Associate the readings, and sum up the normal equations of all factors."""
    layout = now.layout
    association, readings = _linearise_readings(_at_present(measurements, now, priors), now, priors, settings)
    range_information, range_vector = normal_equations([_placed(readings, layout)], layout.size)
    rest, vector = normal_equations([heading_factor(headings, now)], layout.size)
    if known is not None:
        rest[np.ix_(known.columns, known.columns)] += known.information
        vector[known.columns] += known.vector - known.information @ now.values[known.columns]
    measured = range_information + rest
    prior_factors = list(_prior_factors(now, layout, priors, settings))
    prior_information, prior_vector = normal_equations(prior_factors, layout.size)
    rest, vector = rest + prior_information, vector + prior_vector
    return _Linearisation(
        association, readings, range_information + rest, measured, range_vector=range_vector, rest=rest, vector=vector
    )


def _linearise_readings(
    measurements: Measurements, now: Values, priors: Priors, settings: OptimiserSettings
) -> tuple[Association, _RangeLinearisation]:
    """Associate the readings, and linearise those that landmarks explain."""
    tables = now.model.tabulated()
    association = associate(measurements, tables, now.features, max(0.025, 6.0 * priors.noise))
    explained = np.flatnonzero(association.owners >= 0)
    model = now.model
    walk = (model.range_offset, model.walk_gain, model.reference_walk, model.walk_exponent)
    jacobian, neighbours = range_jacobian(measurements, tables, now.features, association, explained, walk)
    residuals, excesses = association.residuals[explained], association.excesses[explained]
    variances = now.model.variances(excesses, noise=priors.noise)
    if priors.poses is not None and measurements.ways.any() and len(explained):
        drift = bridge_variances(measurements, priors.poses)[explained]
        # The noise is estimated from all readings, so it contains the drift in the median.
        usual = min(float(np.median(drift)), _DRIFT * priors.noise**2)
        variances = np.maximum(variances - usual, (1.0 - _DRIFT) * priors.noise**2) + drift
    robust_variances = geman_mcclure_variances(residuals, variances, scale=settings.geman_mcclure_scale)
    counts = priors.effective_sample_ratio * measurements.weights[explained]
    owners, stations = association.owners[explained], measurements.stations[explained]
    readings = _RangeLinearisation(
        owners=owners,
        stations=stations[:, None],
        neighbours=neighbours,
        jacobian=jacobian if len(now.poses) else jacobian[:, :POSE_COLUMNS].copy(),
        residuals=residuals,
        weights=_with_shared_bias(counts / robust_variances, owners, stations, _shared_variances(now, priors)),
    )
    if len(now.poses):
        readings = _with_lever_arms(readings, measurements, explained, now=now, priors=priors)
    return association, readings


def geman_mcclure_variances(residuals: FloatArray, variances: FloatArray, *, scale: float) -> FloatArray:
    """Return variances inflated such that squares follow the kernel of Geman and McClure (1985), ``scale`` in sigmas.

    With u = r / (scale sigma), the kernel u^2 / (1 + u^2) gives the weight 1 / (1 + u^2)^2: a quarter at u = 1.
    """
    inflated: FloatArray = variances * (1.0 + residuals**2 / (scale**2 * variances)) ** 2
    return inflated


def _shared_variances(now: Values, priors: Priors) -> FloatArray:
    """Return the variance of the error that all readings of a landmark from one station share [m^2], shape (f, s).

    With absolute poses it is estimated from the residuals and includes all causes, also partial occlusion.
    """
    variances, by_hand = now.features.bias_variances, priors.poses is not None and not priors.poses.relative
    return priors.bias_sigma**2 + (np.zeros_like(variances) if by_hand else variances)


def _with_shared_bias(weights: FloatArray, owners: IntArray, stations: IntArray, common: FloatArray) -> FloatArray:
    """Return weights lowered by the variance of the error that readings of a landmark from one station share."""
    sums = np.zeros(common.shape)
    np.add.at(sums, (owners, stations), weights)
    capped: FloatArray = weights / (1.0 + (sums * common)[owners, stations])
    return capped


def _with_lever_arms(
    readings: _RangeLinearisation, measurements: Measurements, explained: IntArray, *, now: Values, priors: Priors
) -> _RangeLinearisation:
    """Turn derivatives by the pose of the sensor into those by the poses of the stations that place it."""
    jacobian, stations, drove = readings.jacobian, readings.stations, measurements.ways.any()
    if drove and priors.poses is not None:
        others, shares = neighbours_of(measurements, priors.poses.measured_poses)
        others, shares = others[explained], shares[explained, None]
        by_pose = jacobian[:, POSE_COLUMNS:]
        jacobian = np.hstack([jacobian[:, :POSE_COLUMNS], (1.0 - shares) * by_pose, shares * by_pose])
        stations = np.column_stack([stations, others])
    for number, column in enumerate(stations.T):
        first = POSE_COLUMNS + 3 * number
        _add_lever_arm(jacobian[:, first : first + 3], measurements, explained, now.poses[column])
    return readings._replace(jacobian=jacobian, stations=stations)


@compiled
def _add_lever_arm(jacobian: FloatArray, measurements: Measurements, explained: IntArray, poses: FloatArray) -> None:
    """Add the lever arms of the sensors to the derivatives by the yaw of the robot; ``poses`` are those by reading."""
    for row, ping in enumerate(explained):
        base = poses[row]
        ahead, aside = measurements.x[ping] - base[0], measurements.y[ping] - base[1]
        jacobian[row, -1] += jacobian[row, -2] * ahead - jacobian[row, -3] * aside


def _placed(readings: _RangeLinearisation, layout: Layout) -> LinearFactor:
    """Return the linearised readings as a factor, with positions in the state vector."""
    columns = _columns(readings, layout.columns, (layout.sonar, layout.pose))
    return LinearFactor(columns, readings.jacobian, readings.residuals, readings.weights)


@compiled
def _columns(readings: _RangeLinearisation, of_features: IntArray, starts: tuple[int, int]) -> IntArray:
    """Return the positions of landmark, neighbouring wall, calibration and pose in the state vector, by reading."""
    columns: IntArray = np.empty(readings.jacobian.shape, np.int64)
    owners, neighbours, stations = readings.owners, readings.neighbours, readings.stations
    sonar, pose = starts
    for row in range(len(columns)):
        for place in range(LANDMARK_COLUMNS, NEIGHBOUR_COLUMNS):
            columns[row, place] = of_features[owners[row], place]
        # Without a neighbour the index is -1: the last row, which holds no positions.
        for place in range(NEIGHBOUR_COLUMNS, SONAR_COLUMNS):
            columns[row, place] = of_features[neighbours[row], place - NEIGHBOUR_COLUMNS]
        for place in range(SONAR_COLUMNS, POSE_COLUMNS):
            columns[row, place] = sonar + place - SONAR_COLUMNS
        for place in range(POSE_COLUMNS, columns.shape[1]):
            number, axis = divmod(place - POSE_COLUMNS, 3)
            columns[row, place] = pose + 3 * stations[row, number] + axis
    return columns


def _prior_factors(now: Values, layout: Layout, priors: Priors, settings: OptimiserSettings) -> Iterator[LinearFactor]:
    """Yield all factors that do not depend on pings: priors, Manhattan, pose and corner factors."""
    yield sonar_prior(now, layout.sonar, priors, settings)
    if priors.manhattan_prior is not None:
        yield manhattan_factor(priors.manhattan_prior, now.features.reflectors[:, 1], layout.starts)
    if priors.poses is not None:
        yield pose_factors(priors.poses, now.poses, layout.pose)
    yield prior(np.arange(layout.sonar), sigma=1.0 / _HOLD, residual=0.0)
    columns = np.flatnonzero(layout.kinds == _CYLINDER)
    residuals = settings.radius - now.features.reflectors[columns, 3]
    yield prior(layout.starts[columns] + 2, sigma=settings.radius_sigma, residual=residuals)
    yield from corner_factors(now.features.reflectors, layout, settings.corner_factors)
