"""Adjustment: all features and the calibration of the recording in one robust least-squares problem.

Gauss-Newton on the readings that the features explain, with analytic derivatives, weights by Geman and McClure, ties
between corners and the walls that make them, and priors from the rig for what the readings do not determine.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from pydantic import BaseModel, Field

from echoplan.acoustics.expectation import Kind
from echoplan.arrays import FloatArray, IntArray
from echoplan.compiled import compiled
from echoplan.mapping.joint.adjustment.adjusted import Adjusted
from echoplan.mapping.joint.adjustment.bearings import NO_BEARINGS, Bearings, bearing_rows, bearings_of
from echoplan.mapping.joint.adjustment.crossings import TieSettings, corner_ties
from echoplan.mapping.joint.adjustment.poses import PoseBeliefs, displaced, pose_rows
from echoplan.mapping.joint.adjustment.readings import Features, Matched, differentiate_readings, match_readings
from echoplan.mapping.joint.adjustment.rows import Rows, Summary, held, normal_equations, prior, solve
from echoplan.mapping.joint.adjustment.squareness import Squareness, square_rows
from echoplan.mapping.joint.adjustment.state import State
from echoplan.mapping.joint.adjustment.unknowns import SONAR_UNKNOWNS, Unknowns
from echoplan.preprocessing.soundings import Soundings, late_by

__all__ = [
    "AdjustmentSettings",
    "Beliefs",
    "Features",
    "adjust",
    "facing_rows",
    "reading_rows",
]

_CYLINDER = int(Kind.CYLINDER)
# Information about features that holds them in place where no reading does.
_HOLD = 0.1
# What the prior alone holds needs no other hold: readings tell of a number what leaves so much of its variance.
_TOLD = 0.5


class AdjustmentSettings(BaseModel, frozen=True, extra="forbid"):
    """What is believed before anything was heard, and how errors are weighed."""

    rounds: int = Field(default=6, ge=1, description="Gauss-Newton steps at most")
    rest: float = Field(default=1e-4, gt=0.0, description="square of a step, in deviations, after which none is taken")
    robust: float = Field(default=2.5, gt=0.0, description="deviations at which a reading counts a quarter")
    gain_share: float = Field(default=0.24, gt=0.0, description="uncertainty of the range walk, as a share of it")
    scale_sigma: float = Field(default=0.03, gt=0.0, description="of the range scale: 50 degrees of temperature")
    told_scale_sigma: float = Field(default=0.002, gt=0.0, description="likewise, by a thermometer or on a drive")
    told_offset_sigma: float = Field(default=0.002, gt=0.0, description="of the range offset, by corners [m]: measured")
    latency_sigma: float = Field(default=0.02, gt=0.0, description="of the servo's latency [s]")
    merit_sigma: float = Field(default=0.6, gt=0.0, description="of the figure of merit as told by who heard what [dB]")
    ka_sigma: float = Field(default=0.015, gt=0.0, description="likewise of the logarithm of the beam's ka")
    exponent_sigma: float = Field(
        default=0.2,
        gt=0.0,
        description="uncertainty of the exponent of the range walk: 0.17 is the root mean square over bursts of 4 to "
        "16 cycles and resonators of a quality of 5 to 30",
    )
    model_error: float = Field(
        default=0.0004,
        ge=0.0,
        description="of each end of a wall, and of a point, however many readings tell it [m]: in rooms of 100 "
        "stations 95 % of the angles of walls lie in their interval with it, 87 % without",
    )
    determined: float = Field(
        default=2.0, gt=0.0, description="deviations of a latency that drifting poses leave clear"
    )
    radius: float = Field(default=0.12, gt=0.0, description="of a cylinder of which little was heard [m]")
    radius_sigma: float = Field(default=0.1, gt=0.0, description="of that guess [m]")
    ties: TieSettings = Field(default_factory=TieSettings)


class Beliefs(NamedTuple):
    """What the rig tells before anything was heard.

    Attributes
    ----------
    noise : float
        Standard deviation of readings [m].
    offset_sigma : float
        Of the reading of an aimed plane at 1 m [m]: modules are set right there, within a step of the readings.
    walk_gain : float
        Range walk at the threshold [m].
    has_servo : bool
        Whether there is a servo that may lag.
    scale_sigma : float
        How well it is known how fast sound is.
    range_scale : float
        As is to be expected of the air.
    drifting : bool
        Whether errors of the poses add up.
    poses : PoseBeliefs or None
        What is believed of the poses, if they are to be corrected.
    pair_sigma : float
        What all pings of one station say of one feature is wrong together by this [m]; 0 if they are independent.
    independence : float
        How many times more readings count than their weights say.
    understated : float
        How many times more readings tell than they are let count for.
    loudness : tuple of float or None
        Figure of merit [dB] and logarithm of the beam's ka as told by who heard what; None if nothing told them yet,
        or while poses drift or have not settled: then they stay as they are.
    squareness : Squareness or None
        How square the walls stand, where right angles are believed in.
    bearings : bool
        Whether way-points ask who heard walls along the axes which way they face.
    """

    noise: float
    offset_sigma: float
    walk_gain: float
    has_servo: bool
    scale_sigma: float
    range_scale: float = 0.0
    drifting: bool = False
    poses: PoseBeliefs | None = None
    pair_sigma: float = 0.0
    independence: float = 1.0
    understated: float = 1.0
    loudness: tuple[float, float] | None = None
    squareness: Squareness | None = None
    bearings: bool = False


def adjust(
    soundings: Soundings,
    start: State,
    beliefs: Beliefs,
    settings: AdjustmentSettings,
    *,
    known: Summary | None = None,
) -> Adjusted:
    """Adjust features, sonar and, if they may be off, poses to all readings.

    Parameters
    ----------
    soundings : Soundings
        The pings, as heard from the poses that were given.
    start : State
        Where to start.
    beliefs : Beliefs
        What is believed of the sonar.
    settings : AdjustmentSettings
        Priors and weights.
    known : Summary, optional
        What readings that are no longer at hand said.

    Returns
    -------
    Adjusted
        Features, sonar and covariance.
    """
    unknowns = start.unknowns
    now, bearings = start, _bearings(soundings, start, beliefs)
    for _ in range(settings.rounds):
        matched, readings = _linearised(_as_heard(soundings, now, beliefs), now, beliefs, settings)
        told = [_placed(readings, unknowns), bearing_rows(bearings, now)]
        heard, right = normal_equations(told, unknowns.size)
        if known is not None:
            heard[np.ix_(known.columns, known.columns)] += known.information
            right[known.columns] += known.vector - known.information @ now.values[known.columns]
        information, pull = normal_equations(list(_held_by(now, unknowns, beliefs, settings)), unknowns.size)
        information, right = information + heard, right + pull
        step = _step(information, right, now, beliefs, settings)
        now, left = now.moved(step), float(step @ information @ step)
        if left < settings.rest:
            break
    return Adjusted(
        reflectors=now.features.reflectors,
        model=now.model,
        latency=now.latency,
        poses=now.poses,
        unknowns=unknowns,
        information=information,
        heard=heard,
        understated=beliefs.understated,
        offset_sigma=min(beliefs.offset_sigma, settings.told_offset_sigma),
        model_error=settings.model_error,
        extents=now.features.extents,
        owners=matched.owners,
        residuals=matched.residuals,
        excesses=matched.excesses,
        left=left,
    )


def _step(
    information: FloatArray, right: FloatArray, now: State, beliefs: Beliefs, settings: AdjustmentSettings
) -> FloatArray:
    """Solve, but keep consider parameters of the sonar at their prior means (Schmidt 1966).

    The exponent of the range walk is one: maps are no better with one that is estimated.  So is the range offset where
    it is known better than corners tell it.  Where the poses drift, two more are: all that is left to tell the range
    scale are the arms of the array, a few centimetres long, and an error of the beam's shape by tenths of a millimetre
    would pass for a percent; and a servo that lags looks like a robot that turns a little too far one way and back
    again, sweep by sweep (it never leads).  Their uncertainty stays in the covariance.
    """
    considered = ("walk_exponent", "range_offset", "range_scale", "servo_latency")
    exponent, offset, scale, latency = (now.unknowns.sonar + SONAR_UNKNOWNS.index(each) for each in considered)
    changes = {exponent: 1.0 - now.model.walk_exponent}
    if beliefs.offset_sigma <= settings.told_offset_sigma:
        changes[offset] = -now.model.range_offset
    if beliefs.drifting:
        changes[scale] = beliefs.range_scale - now.model.range_scale
    units = np.eye(len(right))[[*changes, latency]]
    step, *columns, by_latency = solve(information, np.column_stack([right, *units])).T
    step = held(step, columns, changes)
    if not beliefs.drifting:
        return step
    by_latency = held(by_latency, columns, dict.fromkeys(changes, 0.0))
    change, variance = step[latency], by_latency[latency]
    told = variance < _TOLD * settings.latency_sigma**2
    if told and now.latency + change < settings.determined * math.sqrt(variance):
        return held(step, [by_latency], {latency: -now.latency})
    return step


def reading_rows(soundings: Soundings, now: State, beliefs: Beliefs, settings: AdjustmentSettings) -> Rows:
    """Linearise the readings that features explain.

    Parameters
    ----------
    soundings : Soundings
        The pings, as heard from the poses that were given.
    now : State
        Features, sonar and poses.
    beliefs : Beliefs
        What is believed of the sonar.
    settings : AdjustmentSettings
        Weights.

    Returns
    -------
    Rows
        One a reading.
    """
    _, readings = _linearised(_as_heard(soundings, now, beliefs), now, beliefs, settings)
    return _placed(readings, now.unknowns)


def facing_rows(soundings: Soundings, now: State, beliefs: Beliefs) -> Rows:
    """Linearise the bearings of walls, where these tell which way stations face.

    Parameters
    ----------
    soundings, now, beliefs
        As those of ``reading_rows``.

    Returns
    -------
    Rows
        One a wall and station; none unless headings are free and walls stand along the axes.
    """
    return bearing_rows(_bearings(soundings, now, beliefs), now)


def _bearings(soundings: Soundings, now: State, beliefs: Beliefs) -> Bearings:
    """Find the bearings of walls; those of walls that may lie anyhow tell nothing of headings."""
    poses, square = beliefs.poses, beliefs.squareness
    if not beliefs.bearings or poses is None or poses.relative or square is None or not square.along_axes:
        return NO_BEARINGS
    heard = _as_heard(soundings, now, beliefs)
    return bearings_of(heard, now.model.tabulated(), now.features, now.poses[:, 2])


class _Readings(NamedTuple):
    """Linearised readings: whose they are, from which station, which wall ends theirs, derivatives and so on."""

    owners: IntArray
    stations: IntArray
    neighbours: IntArray
    slopes: FloatArray
    residuals: FloatArray
    weights: FloatArray


def _as_heard(soundings: Soundings, now: State, beliefs: Beliefs) -> Soundings:
    """Place the pings where the servo and the robot were."""
    turned = late_by(soundings, now.latency)
    return turned if beliefs.poses is None else displaced(turned, beliefs.poses.given, now.poses)


def _linearised(
    soundings: Soundings, now: State, beliefs: Beliefs, settings: AdjustmentSettings
) -> tuple[Matched, _Readings]:
    hearing = now.model.tabulated()
    matched = match_readings(soundings, hearing, now.features, max(0.025, 6.0 * beliefs.noise))
    explained = np.flatnonzero(matched.owners >= 0)
    model = now.model
    walk = (model.range_offset, model.walk_gain, model.reference_walk, model.walk_exponent)
    slopes, neighbours = differentiate_readings(soundings, hearing, now.features, matched, explained, walk)
    residuals, excesses = matched.residuals[explained], matched.excesses[explained]
    variances = now.model.variances(excesses, noise=beliefs.noise)
    doubts = variances * (1.0 + residuals**2 / (settings.robust**2 * variances)) ** 2
    counts = beliefs.independence * soundings.weights[explained]
    owners, stations = matched.owners[explained], soundings.stations[explained]
    readings = _Readings(
        owners=owners,
        stations=stations,
        neighbours=neighbours,
        slopes=slopes if len(now.poses) else slopes[:, : 5 + len(SONAR_UNKNOWNS)],
        residuals=residuals,
        weights=_capped(counts / doubts, owners, stations, _common(now.features.doubts, beliefs)),
    )
    if len(now.poses):
        _add_leverage(slopes, soundings, explained, now.poses)
    return matched, readings


def _common(doubts: FloatArray, beliefs: Beliefs) -> FloatArray:
    """Variance of what is wrong together in all that a station says of a feature [m^2], by feature and station.

    Of way-points that is learned from what is left of the readings, whatever the reason.
    """
    by_hand = beliefs.poses is not None and not beliefs.poses.relative
    return beliefs.pair_sigma**2 + (np.zeros_like(doubts) if by_hand else doubts)


def _capped(weights: FloatArray, owners: IntArray, stations: IntArray, common: FloatArray) -> FloatArray:
    """Let all that a station says of a feature count no more than its common error allows."""
    sums = np.zeros(common.shape)
    np.add.at(sums, (owners, stations), weights)
    capped: FloatArray = weights / (1.0 + (sums * common)[owners, stations])
    return capped


@compiled
def _add_leverage(slopes: FloatArray, soundings: Soundings, explained: IntArray, poses: FloatArray) -> None:
    """Let a turn of the robot move its sensors, and so the readings."""
    for row, ping in enumerate(explained):
        base = poses[soundings.stations[ping]]
        ahead, aside = soundings.x[ping] - base[0], soundings.y[ping] - base[1]
        slopes[row, -1] += slopes[row, -2] * ahead - slopes[row, -3] * aside


def _placed(readings: _Readings, unknowns: Unknowns) -> Rows:
    """Give the derivatives of readings their places among the unknowns."""
    columns = _columns(readings, unknowns.columns, (unknowns.sonar, unknowns.pose))
    return Rows(columns, readings.slopes, readings.residuals, readings.weights)


@compiled
def _columns(readings: _Readings, of_features: IntArray, starts: tuple[int, int]) -> IntArray:
    """Where parameters of its feature, of the neighbour, of the sonar and of its pose stand, for each reading."""
    columns: IntArray = np.empty(readings.slopes.shape, np.int64)
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


def _held_by(now: State, unknowns: Unknowns, beliefs: Beliefs, settings: AdjustmentSettings) -> Iterator[Rows]:
    """Collect what holds the unknowns besides the pings: priors, and ties of corners to their walls."""
    yield _sonar_prior(now, unknowns.sonar, beliefs, settings)
    if beliefs.squareness is not None:
        yield square_rows(beliefs.squareness, now.features.reflectors[:, 1], unknowns.starts)
    if beliefs.poses is not None:
        yield pose_rows(beliefs.poses, now.poses, unknowns.pose)
    yield prior(np.arange(unknowns.sonar), sigma=1.0 / _HOLD, residual=0.0)
    columns = np.flatnonzero(unknowns.kinds == _CYLINDER)
    residuals = settings.radius - now.features.reflectors[columns, 3]
    yield prior(unknowns.starts[columns] + 2, sigma=settings.radius_sigma, residual=residuals)
    yield from corner_ties(now.features.reflectors, unknowns, settings.ties)


def _sonar_prior(now: State, first: int, beliefs: Beliefs, settings: AdjustmentSettings) -> Rows:
    model, gain_sigma = now.model, settings.gain_share * beliefs.walk_gain
    # Without a servo nothing lags: the unknown stays where it is.
    latency_sigma = settings.latency_sigma if beliefs.has_servo else 1e-9
    # There is no range walk in a cone of rays.
    exponent_sigma = 1e-9 if model.cone else settings.exponent_sigma
    merit, log_ka, *loudness = (model.figure_of_merit, math.log(model.ka), 1e-9, 1e-9)
    if beliefs.loudness is not None:
        merit, log_ka, *loudness = *beliefs.loudness, settings.merit_sigma, settings.ka_sigma
    return prior(
        first + np.arange(len(SONAR_UNKNOWNS)),
        sigma=(beliefs.offset_sigma, gain_sigma, beliefs.scale_sigma, latency_sigma, *loudness, exponent_sigma),
        residual=(
            -model.range_offset,
            beliefs.walk_gain - model.walk_gain,
            beliefs.range_scale - model.range_scale,
            -now.latency,
            merit - model.figure_of_merit,
            log_ka - math.log(model.ka),
            1.0 - model.walk_exponent,
        ),
    )
