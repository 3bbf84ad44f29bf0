"""Loudness and beam of a sonar, from which pings heard what they could have heard."""

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from echoplan.acoustics.beam import two_way_loss
from echoplan.acoustics.predicted_echo import EchoModel, Kind, Shape, look, shape_of
from echoplan.arrays import BoolArray, FloatArray
from echoplan.compiled import compiled
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.preprocessing.measurements import Measurements

__all__ = ["fit_figure_of_merit"]

# Features that three stations heard clearly [nats] tell most about the sonar; where there are few, those that two did.
_CLEARLY, _STATIONS, _FEATURES = 8.0, (3, 2), 3
# No ping is surer than this: surfaces differ, things stand in the way.
_LEAST, _MOST = 0.06, 0.94
# Echoes fade over more decibels than one surface would: all surfaces together.
_FADING = 1.56
# What is believed of the figure of merit beside the one to start from [dB], and how many pings that is worth.
_SIGMA, _WORTH = 6.0, 5.0
# Readings from just before to a walk behind the depth are hits; those well behind, misses [m].
_EARLY, _LATE, _BEHIND, _RIM = -0.02, 0.06, 0.08, 0.1
# Short of the first null, at 3.83, the beam is 51 dB down both ways: from there on no echo is expected [ka sin(angle)].
_NULL, _SILENT = 3.6, 40.0
_ROWS = 6000
# Figures of merit [dB] and beams to start from: all that modules are made with.
_MERITS, _WIDTHS = (12.0, 18.0, 24.0, 30.0), (3.0, 4.0, 5.5, 7.5)
_WALL = int(Kind.WALL)
# Pings that look farther away than this from a feature say nothing of the beam (cosine).
_STEEP = math.cos(1.2)


def fit_figure_of_merit(
    measurements: Measurements, model: EchoModel, features: Sequence[Hypothesis], *, prior_mean: float
) -> EchoModel:
    """Fit figure of merit and beam width to who heard what.

    Each ping that faces a feature either heard it or not; both together say how loud the sonar is and how wide
    (maximum of the Bernoulli likelihood).

    Parameters
    ----------
    measurements : Measurements
        The pings.
    model : EchoModel
        The sonar so far.
    features : sequence of Hypothesis
        What is there.
    prior_mean : float
        Figure of merit that the rig leads one to expect [dB].

    Returns
    -------
    EchoModel
        With another figure of merit and ``ka``; the given one where fewer than three features are clear enough.
    """
    from scipy.optimize import minimize  # noqa: PLC0415 - SciPy is slow to import

    clear = _clear(features)
    if not clear:
        return model
    scale = 1.0 + model.range_scale
    rows = np.concatenate([_faced(measurements, each.reflector, each.extent, scale) for each in clear])
    rows = rows[:: -(-len(rows) // _ROWS)]
    losses = 20 * np.log10(2 * rows[:, 0]) + 2 * model.absorption * rows[:, 0] - rows[:, 2]
    beam = _beam_table()

    def cost(point: Sequence[float]) -> float:
        merit, ka = point
        llr_by_station = np.interp(abs(ka) * rows[:, 1], beam[0], beam[1])
        chances = 1 / (1 + np.exp(np.clip((losses - merit - llr_by_station) / _FADING, -30, 30)))
        surprise = -np.sum(_log_likelihood(np.clip(chances, _LEAST, _MOST), rows[:, 3] > 0))
        return float(surprise + 0.5 * _WORTH * ((merit - prior_mean) / _SIGMA) ** 2)

    # Louder and narrower looks much like fainter and wider: the likelihood has more than one summit.
    starts = [(model.figure_of_merit, model.ka), *product(_MERITS, _WIDTHS)]
    start = min(starts, key=cost)
    found = minimize(cost, start, method="Nelder-Mead", options={"maxiter": 80, "xatol": 0.05, "fatol": 0.5})
    return replace(model, figure_of_merit=float(found.x[0]), ka=abs(float(found.x[1])))


def _clear(features: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Choose the features that tell about the sonar; none if there are too few."""
    plain = [each for each in features if each.kind in (Kind.WALL, Kind.CYLINDER)]
    for stations in _STATIONS:
        clear = [each for each in plain if (each.llr_by_station > _CLEARLY).sum() >= stations]
        if len(clear) >= _FEATURES:
            return clear
    return []


def _log_likelihood(chances: FloatArray, detected: BoolArray) -> FloatArray:
    return np.log(np.where(detected, chances, 1 - chances))


def _beam_table() -> tuple[FloatArray, FloatArray]:
    """Two-way gain against ``ka sin(angle)``, dark from just before the first null on."""
    arguments = np.linspace(0.0, _NULL, 721)
    llr_by_station = -two_way_loss(np.arcsin(arguments / _NULL), _NULL)
    return np.append(arguments, _NULL + 1e-9), np.append(llr_by_station, -_SILENT)


@compiled
def _faced(measurements: Measurements, reflector: FloatArray, extent: tuple[float, float], scale: float) -> FloatArray:
    """Pings that face a reflector, as rows: depth, sine off axis, strength, and 1 for those that heard it."""
    shape, count = shape_of(reflector), 0
    rows = np.empty((len(measurements.readings), 4))
    for ping in range(len(measurements.readings)):
        x, y = measurements.x[ping], measurements.y[ping]
        depth, cosine, sine, _, strength = look(shape, (x, y, measurements.ux[ping], measurements.uy[ping]))
        if not (_within(shape, extent, x, y) and depth > 0.02 and cosine > _STEEP):
            continue
        late = measurements.readings[ping] * scale - depth
        detected = _EARLY < late < _LATE
        if detected or (late > _BEHIND and depth < measurements.max_range - _RIM):
            rows[count] = depth, abs(sine), strength, 1.0 if detected else 0.0
            count += 1
    return rows[:count].copy()


@compiled
def _within(shape: Shape, extent: tuple[float, float], x: float, y: float) -> bool:
    """Whether a place lies before what was heard of a wall."""
    return shape[0] != _WALL or extent[0] + _EARLY <= shape[1] * y - shape[2] * x <= extent[1] - _EARLY
