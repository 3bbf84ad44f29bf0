"""Walls in the sweeps of one sensor: the arcs of servo angles over which they answer, and the model fitted to them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from echoplan.acoustics import Air, crossing_delay, half_angle, plane_echo, signal_excess, two_way_loss
from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.model import Sensor, Sweep, Transducer

__all__ = ["Arc", "ArcFit", "Estimate", "find_arcs", "fit_arcs", "reading_of", "wall_excess"]

# Ranges of one wall differ by less than this from step to step of the servo [m].
_JUMP = 0.05
# Errors of the model on the axis of the beam [m], and as a share of what weak echoes read long.
_MODEL_ERROR, _WALK_ERROR = 0.002, 0.2
# An edge lies anywhere within a step of the servo, and weak echoes flicker [rad].
_FLICKER = math.radians(0.3)
# How the range walk of a sensor compares with that of the model.
_WALK_SPREAD = 0.5
# Weaker echoes than this are modelled as just so strong [dB]: a delay that grows without bound has no derivative.
_WEAKEST = 0.3
# Distance at which makers set the readings of their modules right [m].
_REFERENCE = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """A value and its standard deviation, both in the same unit."""

    value: float
    sigma: float


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Arc:
    """The pings of one sensor that one wall answers.

    Parameters
    ----------
    angles, ranges : ndarray, shape (n,)
        Servo angles as recorded [rad] and depths that were read [m].
    lower, upper : float
        Recorded angles beyond which the wall does not answer any more [rad]; ``nan`` where the servo does not turn so
        far, or something nearer stands there.
    step : float
        Step of the servo [rad].
    """

    angles: FloatArray
    ranges: FloatArray
    lower: float
    upper: float
    step: float


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class ArcFit:
    """The model of the walls that one sensor detects, fitted to arcs.

    Parameters
    ----------
    ka : Estimate
        Circumference of the piston in wavelengths: the narrower the beam, the greater.
    walk : float
        Range walk, compared with that of the model.
    centers, depths : tuple of Estimate
        Of each arc: recorded servo angle at which the beam points at the wall [rad], and distance of the wall from the
        axis of the servo as it is read [m].
    separation : Estimate
        Recorded angle between the centers of the last arc and the first [rad].
    rms : float
        Root mean square of the residuals of the ranges [m].
    """

    ka: Estimate
    walk: float
    centers: tuple[Estimate, ...]
    depths: tuple[Estimate, ...]
    separation: Estimate
    rms: float


def find_arcs(sweeps: Sequence[Sweep], *, sensor_id: int, depth: float, gate: float, scale: float) -> list[Arc]:
    """Find walls that a sensor detects at about a depth, the widest arc first.

    Parameters
    ----------
    sweeps : sequence of Sweep
        Sweeps from one place.
    sensor_id : int
        The sensor.
    depth, gate : float
        Expected range, and by how much it may differ [m].
    scale : float
        Depth for each metre that is read.
    """
    recorded = np.concatenate([sweep.servo_angles[sweep.sensor_ids == sensor_id] for sweep in sweeps])
    ranges = scale * np.concatenate([sweep.ranges[sweep.sensor_ids == sensor_id] for sweep in sweeps])
    angles, steps = np.unique(recorded.round(6), return_inverse=True)
    is_near = np.abs(ranges - depth) <= gate
    nearest, detected = _at_each_step(ranges, steps, is_near=is_near)
    places = np.flatnonzero(detected)
    if not len(places):
        return []
    # One step may be lost within an arc.
    ends = np.flatnonzero((np.diff(places) > 2) | (np.abs(np.diff(nearest[places])) > _JUMP)) + 1
    arcs = []
    for run in np.split(places, ends):
        inside = is_near & (steps >= run[0]) & (steps <= run[-1])
        arcs.append(
            Arc(
                angles=recorded[inside],
                ranges=ranges[inside],
                lower=_edge(angles, nearest, end=run[0], beyond=run[0] - 1),
                upper=_edge(angles, nearest, end=run[-1], beyond=run[-1] + 1),
                step=float(np.median(np.diff(angles))) if len(angles) > 1 else 0.0,
            )
        )
    return sorted(arcs, key=lambda arc: -float(np.ptp(arc.angles)))


def _at_each_step(ranges: FloatArray, steps: IntArray, *, is_near: BoolArray) -> tuple[FloatArray, BoolArray]:
    """Return the range at each step of the servo, and whether it is that of a wall.

    That of a wall is the median of at least half of the readings; else it is the nearest reading, which may hide one.
    """
    detected = np.bincount(steps, is_near) >= 0.5 * np.bincount(steps)
    found = np.full(len(detected), np.inf)
    np.fmin.at(found, steps, ranges)
    for step in np.flatnonzero(detected):
        found[step] = np.median(ranges[(steps == step) & is_near])
    return found, detected


def _edge(angles: FloatArray, nearest: FloatArray, *, end: int, beyond: int) -> float:
    """Return the angle at which an arc ends [rad]; nan if the wall may go on unseen."""
    if not 0 <= beyond < len(angles) or nearest[beyond] < nearest[end] - _JUMP:
        return math.nan
    return float(angles[end] + angles[beyond]) / 2


def reading_of(
    angles: FloatArray,
    *,
    depth: float,
    ka: float,
    walk: float,
    sensor: Sensor,
    transducer: Transducer,
    air: Air,
) -> FloatArray:
    """Return the depth that a sensor reads of a wall, shape (n,) [m].

    Parameters
    ----------
    angles : ndarray, shape (n,)
        Of the beam from the normal of the wall [rad].
    depth : float
        Distance of the wall from the axis of the servo [m], with the offset of the readings.
    ka, walk : float
        As in ``ArcFit``.
    sensor, transducer, air
        The sensor, what it is made of, and the air.
    """
    excess = wall_excess(depth, transducer=transducer, air=air)
    reference = wall_excess(_REFERENCE, transducer=transducer, air=air)
    left = np.maximum(excess - two_way_loss(angles, ka), _WEAKEST)
    late = crossing_delay(left, transducer) - crossing_delay(np.maximum(reference, _WEAKEST), transducer)
    arm, turned = math.hypot(sensor.x, sensor.y), math.atan2(sensor.y, sensor.x) - sensor.yaw
    ranges: FloatArray = depth - arm * np.cos(angles + turned) + walk * 0.5 * air.speed_of_sound * late
    return ranges


def fit_arcs(
    arcs: Sequence[Arc], *, gain: float, ka: Estimate, sensor: Sensor, transducer: Transducer, air: Air
) -> ArcFit:
    """Fit the model of a flat wall to arcs of one sensor, by least squares.

    The edges of an arc lie where the two-way loss of the beam uses up the signal excess of the wall; its ranges grow
    towards them by the arm and by the range walk.

    Parameters
    ----------
    arcs : sequence of Arc
        One for each wall.
    gain : float
        How far the servo turns for each recorded radian, negative if clockwise.
    ka : Estimate
        What is known of the beam before.
    sensor, transducer, air
        The sensor, what it is made of, and the air.
    """
    from scipy.optimize import least_squares  # noqa: PLC0415 - SciPy is slow to import

    start = [math.log(ka.value), 1.0]
    sigmas = []
    for arc in arcs:
        width = float(half_angle(wall_excess(np.median(arc.ranges), transducer=transducer, air=air), ka.value) / gain)
        start += [_center(arc, width=abs(width)), float(arc.ranges.min() + math.hypot(sensor.x, sensor.y))]
        noise = math.hypot(_MODEL_ERROR, sensor.resolution / math.sqrt(12))
        sigmas.append(np.hypot(noise, _WALK_ERROR * (arc.ranges - np.percentile(arc.ranges, 10.0)).clip(min=0.0)))
    edges = np.array([[arc.lower, arc.upper] for arc in arcs])
    edge_sigmas = np.hypot([[arc.step / math.sqrt(12)] for arc in arcs], _FLICKER)

    def errors(values: FloatArray) -> list[FloatArray]:
        """Return the errors of the ranges of each arc [m]."""
        return [
            reading_of(
                gain * (arc.angles - center),
                depth=depth,
                ka=math.exp(values[0]),
                walk=values[1],
                sensor=sensor,
                transducer=transducer,
                air=air,
            )
            - arc.ranges
            for arc, center, depth in zip(arcs, values[2::2], values[3::2], strict=True)
        ]

    def residuals(values: FloatArray) -> FloatArray:
        """Return the normalised residuals of the ranges, of the edges of the arcs and of the priors."""
        widths = half_angle(wall_excess(values[3::2], transducer=transducer, air=air), math.exp(values[0])) / abs(gain)
        ends = values[2::2, None] + widths[:, None] * [-1.0, 1.0] - edges
        priors = [(values[0] - start[0]) * ka.value / ka.sigma, (values[1] - 1.0) / _WALK_SPREAD]
        weighted = [error / sigma for error, sigma in zip(errors(values), sigmas, strict=True)]
        return np.concatenate([*weighted, np.nan_to_num(ends / edge_sigmas).ravel(), priors])

    found = least_squares(residuals, start, x_scale=[0.1, 0.5] + len(arcs) * [0.02, 0.005], diff_step=1e-5)
    freedom = max(len(found.fun) - int(np.isnan(edges).sum()) - len(start), 1)
    # A model that fits worse than its noise makes everything less certain.
    covariance = np.linalg.inv(found.jac.T @ found.jac) * max(1.0, 2.0 * found.cost / freedom)
    deviations = np.sqrt(np.diag(covariance))
    across = np.zeros(len(start))
    across[-2] += 1.0
    across[2] -= 1.0
    value = math.exp(found.x[0])
    return ArcFit(
        ka=Estimate(value=value, sigma=value * float(deviations[0])),
        walk=float(found.x[1]),
        centers=_estimates(found.x[2::2], deviations[2::2]),
        depths=_estimates(found.x[3::2], deviations[3::2]),
        separation=Estimate(value=float(across @ found.x), sigma=math.sqrt(across @ covariance @ across)),
        rms=float(np.sqrt(np.mean(np.concatenate(errors(found.x)) ** 2))),
    )


def wall_excess(depth: float | FloatArray, *, transducer: Transducer, air: Air) -> FloatArray:
    """Return the signal excess of a wall at a depth [dB]."""
    distance = np.maximum(depth, 0.01)
    return signal_excess(plane_echo(distance), 2.0 * distance, transducer=transducer, air=air)


def _center(arc: Arc, *, width: float) -> float:
    """Guess the center of an arc that is so wide to either side [rad]."""
    if math.isnan(arc.lower) and math.isnan(arc.upper):
        return float(arc.angles[np.argmin(arc.ranges)])
    if math.isnan(arc.lower):
        return arc.upper - width
    return arc.lower + width if math.isnan(arc.upper) else (arc.lower + arc.upper) / 2


def _estimates(values: FloatArray, sigmas: FloatArray) -> tuple[Estimate, ...]:
    return tuple(Estimate(value=float(v), sigma=float(s)) for v, s in zip(values, sigmas, strict=True))
