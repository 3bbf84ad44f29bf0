"""Readings that stay the same: whether a world explains them, or a module that reads one value whatever is there."""

import math
from typing import NamedTuple

import numpy as np

from echoplan.arrays import BoolArray, FloatArray, IntArray

__all__ = ["Trace", "count_walls", "excess_of_value", "held_readings", "is_logged_repeatedly", "is_value", "runs_of"]

# Directions of the normals of walls are tried this far apart [rad]: half of it is 0.1 m over 10 m.  A wall explains a
# reading to this width [m], as far as waypoints set by hand are off.
_TURN, _WIDTH = math.radians(1.0), 0.1
# More readings than this, evenly chosen, do not change the count of walls; more walls do not change a decision.
_MOST_READINGS, _MOST_WALLS = 1000, 40
# So many steps beside a value are compared with it.
_BESIDE = 8
# A value without neighbours is taken to have this many walls beside it, as of a room with few walls where steps are at
# most so wide [m]; a wider step holds the walls of as many fine ones.
_FEW, _FINE_STEP = 0.5, 0.01
# Fewer runs than this do not show how long a run usually is.
_FEWEST_RUNS = 20
# A run over more than this many beams is of no single reflector.
_BEAMS = 1.25
# Where steps are so fine that nine of ten runs end within this share of the beam, noise ends runs: a run so many times
# as long as the longest to be expected, and over so large a share of the beam, is no plateau of one reflector.
_FINE, _TOO_LONG, _BEAM_SHARE = 0.14, 2.0, 0.5
# Of readings that are all logged several times, so few are logged once.
_ONCE = 0.1
# Half of them are logged as many times, to this factor.
_REGULAR = 2.0
# Fewer copies of each are left as they are.
_OFTEN = 3


class Trace(NamedTuple):
    """The pings of one sensor in the order of time.

    Attributes
    ----------
    x, y : ndarray, shape (n,)
        Acoustic centres [m].
    bearings : ndarray, shape (n,)
        Directions of the beam axis in the map [rad].
    readings : ndarray, shape (n,)
        Readings [m] (REP 117).
    half_aperture, step : float
        Half of the opening angle [rad], and step of the readings [m].
    """

    x: FloatArray
    y: FloatArray
    bearings: FloatArray
    readings: FloatArray
    half_aperture: float
    step: float

    def only(self, chosen: BoolArray | IntArray) -> "Trace":
        """Keep some of the pings."""
        return self._replace(**{name: getattr(self, name)[chosen] for name in ("x", "y", "bearings", "readings")})


def count_walls(trace: Trace) -> int:
    """Count the walls that it takes to explain all readings of a trace as echoes.

    A wall with unit normal n explains a reading r from p if the beam sees it face on, and p·n + r is its offset.  The
    fewest walls are found greedily: the one that explains most readings first.

    Returns
    -------
    int
        At most 40; 1 of a side sonar on a straight drive along a wall, 30 of a sensor on a servo that is stuck.
    """
    if len(trace.readings) > _MOST_READINGS:
        trace = trace.only(np.linspace(0, len(trace.readings) - 1, _MOST_READINGS).astype(np.int64))
    count = round(2 * math.pi / _TURN)
    reach = math.ceil(trace.half_aperture / _TURN)
    normals = (np.rint(trace.bearings / _TURN).astype(np.int64)[:, None] + np.arange(-reach, reach + 1)) % count
    angles = normals * _TURN
    offsets = trace.x[:, None] * np.cos(angles) + trace.y[:, None] * np.sin(angles) + trace.readings[:, None]
    lower = np.floor(2.0 * offsets / _WIDTH).astype(np.int64)
    cells = np.stack([lower, lower - 1]) * count + normals
    known, walls = np.unique(cells.transpose(1, 0, 2).reshape(len(lower), -1), return_inverse=True)
    walls = walls.reshape(len(lower), -1)
    needed = 0
    while len(walls) and needed < _MOST_WALLS:
        best = np.bincount(walls.ravel(), minlength=len(known)).argmax()
        walls = walls[~(walls == best).any(axis=1)]
        needed += 1
    return needed


def runs_of(readings: FloatArray) -> IntArray:
    """Return the number of the run of equal readings that each reading belongs to, from 0."""
    changes = np.ones(len(readings), dtype=bool)
    changes[1:] = readings[1:] != readings[:-1]
    return np.cumsum(changes) - 1


def excess_of_value(trace: Trace, value: float) -> float:
    """Return how much more often a value was read, at different places, than the values a few steps beside it.

    Noise and a changing distance spread echoes over steps: the next ones have nearly as many where all stations are as
    far from their walls, the others where they are not.  A value that a module puts in the place of echoes has none.
    Each run of it counts once, and so do runs that one wall explains.

    Returns
    -------
    float
        Log-likelihood ratio [nats] of as many walls at exactly this distance as were counted, against as many as beside
        it (Poisson).
    """
    found = _walls_at(trace, value)
    asides = trace.step * np.arange(1, _BESIDE + 1)
    beside = [[_walls_at(trace, value - aside), _walls_at(trace, value + aside)] for aside in asides]
    few = _FEW * max(1.0, trace.step / _FINE_STEP)
    usual = max(few, *beside[0], float(np.mean(beside)))
    return found * math.log(found / usual) - (found - usual) if found > usual else 0.0


def _walls_at(trace: Trace, value: float) -> int:
    there = is_value(trace, value)
    starts = there & ~np.append(False, there[:-1])
    return count_walls(trace.only(starts)) if starts.any() else 0


def is_value(trace: Trace, value: float) -> BoolArray:
    """Mark the readings that are a value, to half a step."""
    there: BoolArray = np.rint((trace.readings - value) / trace.step) == 0.0
    return there


def held_readings(trace: Trace) -> BoolArray:
    """Mark readings that a module gives again because it has no new echo.

    One reflector is seen over no more than the beam.  Where steps are fine, noise ends a run sooner: lengths of runs
    fall off exponentially, as their upper quartile and decile show.

    Returns
    -------
    ndarray of bool, shape (n,)
        The readings of runs too long for one reflector, but the first of each; none where there is only one such run,
        or where runs are too few to show what is usual.
    """
    runs = runs_of(trace.readings)
    lengths = np.bincount(runs) if len(runs) else np.zeros(0, dtype=np.int64)
    held = np.zeros(len(runs), dtype=bool)
    if len(lengths) < _FEWEST_RUNS:
        return held
    beam, bearings = 2.0 * trace.half_aperture, np.unwrap(trace.bearings)
    step = float(np.median(np.abs(np.diff(bearings))))
    quartile, decile = np.quantile(lengths, [0.75, 0.9])
    scale = max(1.0, (decile - quartile) / math.log(2.5))
    longest = decile + scale * math.log(max(1.0, 0.1 * len(lengths)))
    found = 0
    for run in np.flatnonzero(lengths > decile):
        own = np.flatnonzero(runs == run)
        # Not what was left out in between.
        span = min(float(np.ptp(bearings[own])), 2.0 * step * len(own))
        is_too_long = decile * step < _FINE * beam and len(own) > _TOO_LONG * longest and span > _BEAM_SHARE * beam
        if np.isfinite(trace.readings[own[0]]) and (is_too_long or span > _BEAMS * beam):
            held[own[1:]] = True
            found += 1
    return held & (found > 1)


def is_logged_repeatedly(trace: Trace) -> bool:
    """Return True if every reading was logged about as many times, as by a logger faster than its sensor.

    Runs of equal readings are long elsewhere, too, where steps are coarse; but some are short and some very long.
    Readings that are there twice do little harm, and a steady distance in coarse steps looks the same.  Sensors that
    fire several times from one place in one direction read one distance: where that is all they read there, it counts
    once.
    """
    finite = _once_a_view(trace.only(np.isfinite(trace.readings)))
    lengths = np.bincount(runs_of(finite)) if len(finite) else np.zeros(0, dtype=np.int64)
    if len(lengths) < _FEWEST_RUNS or float(np.mean(lengths == 1)) > _ONCE:
        return False
    low, high = np.quantile(lengths, [0.25, 0.75])
    return bool(low >= _OFTEN and high <= _REGULAR * low)


def _once_a_view(trace: Trace) -> FloatArray:
    """Return the readings, but of those in one direction from one place only the first if they are all the same."""
    turns = np.ones(len(trace.readings), dtype=bool)
    turns[1:] = (np.diff(trace.x) != 0.0) | (np.diff(trace.y) != 0.0) | (np.diff(trace.bearings) != 0.0)
    views = np.cumsum(turns) - 1
    changes = np.diff(trace.readings, prepend=np.nan) != 0.0
    differ = np.bincount(views, weights=changes & ~turns) > 0.0
    kept: FloatArray = trace.readings[turns | differ[views]]
    return kept
