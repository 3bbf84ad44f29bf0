"""Adjustment: all features and the calibration of the recording in one robust least-squares problem.

Gauss-Newton on the readings that the features explain, with analytic derivatives, weights by Geman and McClure, ties
between corners and the walls that make them, and priors from the rig for what the readings do not determine.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from pydantic import BaseModel, Field

from echoplan.acoustics.expectation import EchoModel, Hearing, Kind, differentiate, excess_of, look, shape_of, walk_of
from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.compiled import compiled
from echoplan.geometry import intersections, wrap
from echoplan.mapping.crossings import crossing_slopes
from echoplan.mapping.rows import Rows, normal_equations, prior, solve
from echoplan.mapping.unknowns import SONAR_UNKNOWNS, Unknowns
from echoplan.preprocessing.soundings import Soundings, late_by

__all__ = ["Adjusted", "AdjustmentSettings", "Beliefs", "Features", "adjust"]

_WALL, _CYLINDER = int(Kind.WALL), int(Kind.CYLINDER)
# Below this excess readings count half: a detector scatters more there [dB].  Fainter than -2 dB nothing is expected.
_UNCERTAIN, _FAINT = 6.0, -2.0
# A wall may explain readings this far beyond what was heard of it; no walk is longer than this [m].
_BORDER, _WALK = 0.1, 0.1
# Features move no farther than this in a step [rad or m, m, m]; radii stay between these [m].
_LONGEST, _THIN, _THICK = 0.05, 0.01, 0.5
# Information about features that holds them in place where no reading does.
_HOLD = 0.1


class AdjustmentSettings(BaseModel, frozen=True, extra="forbid"):
    """What is believed before anything was heard, and how errors are weighed."""

    rounds: int = Field(default=6, ge=1, description="Gauss-Newton steps at most")
    robust: float = Field(default=2.5, gt=0.0, description="deviations at which a reading counts a quarter")
    gain_share: float = Field(default=0.24, gt=0.0, description="uncertainty of the range walk, as a share of it")
    scale_sigma: float = Field(default=0.03, gt=0.0, description="of the range scale: 50 degrees of temperature")
    latency_sigma: float = Field(default=0.02, gt=0.0, description="of the servo's latency [s]")
    radius: float = Field(default=0.12, gt=0.0, description="of a cylinder of which little was heard [m]")
    radius_sigma: float = Field(default=0.1, gt=0.0, description="of that guess [m]")
    tie: float = Field(default=0.001, gt=0.0, description="of a corner from the crossing of its walls [m]")
    tie_gate: float = Field(default=0.05, gt=0.0, description="greatest distance of such a pair [m]")
    right_angle: float = Field(default=math.radians(3), gt=0.0, description="of walls that echo at their vertex [rad]")


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
    """

    noise: float
    offset_sigma: float
    walk_gain: float
    has_servo: bool


class Features(NamedTuple):
    """Features as plain arrays.

    Attributes
    ----------
    reflectors : ndarray, shape (f, 4)
        Kind and parameters.
    extents : ndarray, shape (f, 2)
        Ends of walls along them [m].
    heard : ndarray of bool, shape (f, s)
        From which stations each was heard.
    """

    reflectors: FloatArray
    extents: FloatArray
    heard: BoolArray


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Adjusted:
    """Features, sonar and their uncertainty after an adjustment.

    Parameters
    ----------
    reflectors : ndarray, shape (f, 4)
        Kind and parameters.
    model : EchoModel
        The sonar.
    latency : float
        By how much the servo lags behind what was recorded [s].
    unknowns : Unknowns
        What stands where in the covariance.
    covariance : ndarray, shape (u, u)
        Of all unknowns.
    owners : ndarray of int, shape (n,)
        Which feature explains each ping; -1 for none.
    residuals : ndarray, shape (n,)
        Reading less expected reading [m]; 0 where nothing explains it.
    excesses : ndarray, shape (n,)
        Expected signal excess [dB].
    """

    reflectors: FloatArray
    model: EchoModel
    latency: float
    unknowns: Unknowns
    covariance: FloatArray
    owners: IntArray
    residuals: FloatArray
    excesses: FloatArray

    @property
    def scatter(self) -> float:
        """Robust standard deviation of the residuals [m]; ``nan`` if nothing is explained."""
        explained = np.abs(self.residuals[self.owners >= 0])
        return 1.4826 * float(np.median(explained)) if len(explained) else math.nan

    def sonar_sigmas(self) -> dict[str, float]:
        """Tell how well each number of the sonar is known.

        Returns
        -------
        dict of str to float
            Standard deviations by the names of ``SONAR_UNKNOWNS``.
        """
        variances = np.diag(self.covariance)[self.unknowns.sonar : self.unknowns.pose]
        return dict(zip(SONAR_UNKNOWNS, np.sqrt(variances).tolist(), strict=True))


def adjust(
    soundings: Soundings, features: Features, model: EchoModel, beliefs: Beliefs, settings: AdjustmentSettings
) -> Adjusted:
    """Adjust features and sonar to all readings.

    Parameters
    ----------
    soundings : Soundings
        The pings.
    features : Features
        Where to start.
    model : EchoModel
        Likewise.
    beliefs : Beliefs
        What is believed of the sonar.
    settings : AdjustmentSettings
        Priors and weights.

    Returns
    -------
    Adjusted
        Features, sonar and covariance.
    """
    unknowns = Unknowns(kinds=features.reflectors[:, 0].astype(np.int64))
    state = _State(reflectors=features.reflectors, model=model, latency=0.0)
    for _ in range(settings.rounds):
        now = features._replace(reflectors=state.reflectors)
        matched, readings = _linearised(late_by(soundings, state.latency), now, state.model, beliefs, settings)
        priors = [*_priors(state, unknowns, beliefs, settings), *_ties(state.reflectors, unknowns, settings)]
        information, right = normal_equations([_placed(readings, unknowns), *priors], unknowns.size)
        step = solve(information, right)
        state = _moved(state, step, unknowns)
        if np.abs(step).max() < 1e-6:
            break
    return Adjusted(
        reflectors=state.reflectors,
        model=state.model,
        latency=state.latency,
        unknowns=unknowns,
        covariance=solve(information, np.eye(unknowns.size)),
        owners=matched.owners,
        residuals=matched.residuals,
        excesses=matched.excesses,
    )


class _Matched(NamedTuple):
    """Which feature explains each ping, by how much it misses it, and how loud it should be."""

    owners: IntArray
    residuals: FloatArray
    excesses: FloatArray


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class _State:
    reflectors: FloatArray
    model: EchoModel
    latency: float


def _linearised(
    soundings: Soundings, features: Features, model: EchoModel, beliefs: Beliefs, settings: AdjustmentSettings
) -> tuple[_Matched, Rows]:
    hearing = model.tabulated()
    matched = _match(soundings, hearing, features, max(0.025, 6.0 * beliefs.noise))
    explained = np.flatnonzero(matched.owners >= 0)
    slopes = _slopes(soundings, hearing, features.reflectors, matched, explained, (model.range_offset, model.walk_gain))
    residuals, excesses = matched.residuals[explained], matched.excesses[explained]
    doubts = (1.0 + (residuals / (settings.robust * beliefs.noise)) ** 2) ** 2
    doubts *= np.where(excesses < _UNCERTAIN, 2.0, 1.0) * beliefs.noise**2
    weights = soundings.weights[explained] / doubts
    return matched, Rows(matched.owners[explained], slopes, residuals, weights)


def _placed(readings: Rows, unknowns: Unknowns) -> Rows:
    """Give the derivatives of readings their places among the unknowns."""
    owners = readings.columns
    own = unknowns.starts[owners][:, None] + np.arange(3)
    own = np.where(np.arange(3) < unknowns.counts[owners][:, None], own, -1)
    sonar = np.broadcast_to(np.arange(unknowns.sonar, unknowns.pose), (len(owners), len(SONAR_UNKNOWNS)))
    return readings._replace(columns=np.concatenate([own, sonar], axis=1))


def _moved(state: _State, step: FloatArray, unknowns: Unknowns) -> _State:
    reflectors = state.reflectors.copy()
    reflectors[:, 1:] += np.clip(unknowns.steps(step), -_LONGEST, _LONGEST)
    reflectors[:, 3] = np.where(unknowns.kinds == _CYLINDER, np.clip(reflectors[:, 3], _THIN, _THICK), 0.0)
    offset, gain, scale, latency = step[unknowns.sonar : unknowns.pose].tolist()
    model = replace(
        state.model,
        range_offset=state.model.range_offset + offset,
        walk_gain=state.model.walk_gain + gain,
        range_scale=state.model.range_scale + scale,
    )
    return _State(reflectors=reflectors, model=model, latency=state.latency + latency)


def _priors(state: _State, unknowns: Unknowns, beliefs: Beliefs, settings: AdjustmentSettings) -> Iterator[Rows]:
    model, first = state.model, unknowns.sonar
    yield prior(first, sigma=beliefs.offset_sigma, residual=-model.range_offset)
    yield prior(first + 1, sigma=settings.gain_share * beliefs.walk_gain, residual=beliefs.walk_gain - model.walk_gain)
    yield prior(first + 2, sigma=settings.scale_sigma, residual=-model.range_scale)
    # Without a servo nothing lags: the unknown stays where it is.
    latency_sigma = settings.latency_sigma if beliefs.has_servo else 1e-9
    yield prior(first + 3, sigma=latency_sigma, residual=-state.latency)
    for column in range(first):
        yield prior(column, sigma=1.0 / _HOLD, residual=0.0)
    for number in np.flatnonzero(unknowns.kinds == _CYLINDER):
        residual = settings.radius - float(state.reflectors[number, 3])
        yield prior(int(unknowns.starts[number]) + 2, sigma=settings.radius_sigma, residual=residual)


def _ties(reflectors: FloatArray, unknowns: Unknowns, settings: AdjustmentSettings) -> Iterator[Rows]:
    """Tie each corner that was heard to the crossing of the two walls that make it.

    Sound that is reflected by both of two walls at a right angle comes back as from their vertex.
    """
    for number in np.flatnonzero(unknowns.kinds == Kind.CORNER):
        pair = _walls_of(reflectors, int(number), settings)
        if pair is None:
            continue
        lines = reflectors[list(pair), 1:3]
        crossing = intersections(lines[0], lines[1])
        columns = np.concatenate([unknowns.starts[k] + np.arange(2) for k in (*pair, number)])
        slopes = np.concatenate([crossing_slopes(lines, crossing), -np.eye(2)], axis=1)
        yield Rows(
            np.stack([columns, columns]),
            slopes,
            -(crossing - reflectors[number, 1:3]),
            np.full(2, settings.tie**-2),
        )


def _walls_of(reflectors: FloatArray, corner: int, settings: AdjustmentSettings) -> tuple[int, int] | None:
    """Find the two walls at a right angle that cross nearest to a corner."""
    walls = np.flatnonzero(reflectors[:, 0] == _WALL)
    first, second = (walls[each] for each in np.triu_indices(len(walls), 1))
    turned = np.abs(np.abs(wrap(reflectors[first, 1] - reflectors[second, 1])) - math.pi / 2)
    square = turned < settings.right_angle
    first, second = first[square], second[square]
    if not len(first):
        return None
    crossings = np.array(
        [intersections(reflectors[a, 1:3], reflectors[b, 1:3]) for a, b in zip(first, second, strict=True)]
    )
    distances = np.hypot(*(crossings - reflectors[corner, 1:3]).T)
    best = int(np.argmin(distances))
    return (int(first[best]), int(second[best])) if distances[best] < settings.tie_gate else None


@compiled
def _match(soundings: Soundings, hearing: Hearing, features: Features, band: float) -> _Matched:
    """Give each reading to the feature that comes nearest to it, of those that its station heard."""
    count = len(soundings.readings)
    owners, residuals, excesses = np.full(count, -1), np.zeros(count), np.zeros(count)
    for feature in range(len(features.reflectors)):
        shape, extent = shape_of(features.reflectors[feature]), features.extents[feature]
        for ping in range(count):
            late = soundings.readings[ping] * hearing.scale
            if not math.isfinite(late) or not features.heard[feature, soundings.stations[ping]]:
                continue
            x, y = soundings.x[ping], soundings.y[ping]
            sight = look(shape, (x, y, soundings.ux[ping], soundings.uy[ping]))
            if sight[0] <= 0.0 or abs(late - sight[0]) > band + _WALK:
                continue
            foot = shape[1] * y - shape[2] * x
            if shape[0] == _WALL and not extent[0] - _BORDER < foot < extent[1] + _BORDER:
                continue
            excess = excess_of(hearing, sight)
            late -= sight[0] + walk_of(hearing, excess)
            if excess > _FAINT and abs(late) < band and (owners[ping] < 0 or abs(late) < abs(residuals[ping])):
                owners[ping], residuals[ping], excesses[ping] = feature, late, excess
    return _Matched(owners, residuals, excesses)


@compiled
def _slopes(
    soundings: Soundings,
    hearing: Hearing,
    reflectors: FloatArray,
    matched: _Matched,
    explained: IntArray,
    walk: tuple[float, float],
) -> FloatArray:
    """Differentiate readings by the parameters of their feature and by the unknowns of the sonar."""
    slopes, own = np.zeros((len(explained), 7)), np.zeros(6)
    for row, ping in enumerate(explained):
        place = (soundings.x[ping], soundings.y[ping], soundings.ux[ping], soundings.uy[ping])
        differentiate(hearing, shape_of(reflectors[matched.owners[ping]]), place, own)
        slopes[row, :3] = own[:3]
        slopes[row, 3] = 1.0
        slopes[row, 4] = (walk_of(hearing, matched.excesses[ping]) - walk[0]) / walk[1]
        slopes[row, 5] = -soundings.readings[ping]
        turning = own[4] * soundings.arms_x[ping] - own[3] * soundings.arms_y[ping] + own[5]
        slopes[row, 6] = -soundings.rates[ping] * turning
    return slopes
