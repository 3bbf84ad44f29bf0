"""Figure of merit and beam width of a sonar, estimated from detections and non-detections."""

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from echoplan.acoustics.beam import two_way_loss
from echoplan.acoustics.predicted_echo import EchoModel, Kind, Shape, echo_geometry, shape_of
from echoplan.arrays import FloatArray
from echoplan.compiled import compiled, inlined
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.preprocessing.measurements import Measurements

__all__ = ["fit_figure_of_merit"]

# LLR [nats] of a clear detection, numbers of stations that must have one, in order of preference, and minimum number of
# such landmarks.
_CLEARLY, _STATIONS, _FEATURES = 8.0, (3, 2), 3
# Bounds of the detection probability of a ping: surfaces differ, and landmarks may be occluded.
_LEAST, _MOST = 0.06, 0.94
# Scale of the logistic detection curve [dB]: wider than that of one surface, since it covers all surfaces.
_FADING = 1.56
# Standard deviation of the prior of the figure of merit [dB], and the weight of that prior in pings.
_SIGMA, _PRIOR_PINGS = 6.0, 5.0
# Readings between _EARLY and _LATE past the depth are detections; from _BEHIND on they are non-detections, unless the
# depth is within _RIM of ``max_range`` [m].
_EARLY, _LATE, _BEHIND, _RIM = -0.02, 0.06, 0.08, 0.1
# Just before the first null at ka sin(angle) = 3.83 the two-way loss is 51 dB. No echo is expected from there on: the
# gain is set to -_SILENT [dB].
_NULL, _SILENT = 3.6, 40.0
# Pings that are used at most, for time.
_ROWS = 6000
# Starting values of figure of merit [dB] and ka: the range of common modules.
_MERITS, _WIDTHS = (12.0, 18.0, 24.0, 30.0), (3.0, 4.0, 5.5, 7.5)
_WALL = int(Kind.WALL)
# Pings farther off the axis than this do not determine the beam (cosine).
_STEEP = math.cos(1.2)


def fit_figure_of_merit(
    measurements: Measurements, model: EchoModel, features: Sequence[Hypothesis], *, prior_mean: float
) -> EchoModel:
    """Return the model with the figure of merit and ``ka`` that detections and non-detections make most likely.

    Each ping that faces a landmark is a Bernoulli trial; together they determine figure of merit and beam width.
    ``prior_mean`` is the figure of merit expected of the rig [dB]. The model is returned unchanged if fewer than three
    landmarks are clear enough.
    """
    from scipy.optimize import minimize  # noqa: PLC0415 - SciPy is slow to import

    clear = _clear(features)
    if not clear:
        return model
    scale = 1.0 + model.range_scale
    rows = np.concatenate([_faced(measurements, each.reflector, each.extent, scale) for each in clear])
    rows = rows[:: -(-len(rows) // _ROWS)]
    losses = 20 * np.log10(2 * rows[:, 0]) + 2 * model.absorption * rows[:, 0] - rows[:, 2]
    detected = rows[:, 3] > 0
    # The two-way beam gain [dB] over ka sin(angle), cut off just before the first null.
    arguments = np.linspace(0.0, _NULL, 721)
    beam_gains = np.append(-two_way_loss(np.arcsin(arguments / _NULL), _NULL), -_SILENT)
    arguments = np.append(arguments, _NULL + 1e-9)

    def cost(point: Sequence[float]) -> float:
        """Return the negative log posterior of a figure of merit [dB] and a beam parameter ka."""
        merit, ka = point
        gains = np.interp(abs(ka) * rows[:, 1], arguments, beam_gains)
        chances = np.clip(1 / (1 + np.exp(np.clip((losses - merit - gains) / _FADING, -30, 30))), _LEAST, _MOST)
        surprise = -np.sum(np.log(np.where(detected, chances, 1 - chances)))
        return float(surprise + 0.5 * _PRIOR_PINGS * ((merit - prior_mean) / _SIGMA) ** 2)

    # A strong sonar with a narrow beam resembles a weak one with a wide beam: the likelihood has several maxima.
    starts = [(model.figure_of_merit, model.ka), *product(_MERITS, _WIDTHS)]
    start = min(starts, key=cost)
    found = minimize(cost, start, method="Nelder-Mead", options={"maxiter": 80, "xatol": 0.05, "fatol": 0.5})
    return replace(model, figure_of_merit=float(found.x[0]), ka=abs(float(found.x[1])))


def _clear(features: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Return the walls and cylinders with a clear LLR from three stations, else from two; none if there are too few."""
    plain = [each for each in features if each.type.is_surface]
    for stations in _STATIONS:
        clear = [each for each in plain if (each.llr_by_station > _CLEARLY).sum() >= stations]
        if len(clear) >= _FEATURES:
            return clear
    return []


@compiled
def _faced(measurements: Measurements, reflector: FloatArray, extent: tuple[float, float], scale: float) -> FloatArray:
    """Return the pings that face a reflector as rows: depth [m], sine off axis, strength [dB], 1 if detected or 0."""
    shape, count = shape_of(reflector), 0
    rows = np.empty((len(measurements.readings), 4))
    for ping in range(len(measurements.readings)):
        x, y = measurements.x[ping], measurements.y[ping]
        depth, cosine, sine, _, strength = echo_geometry(shape, (x, y, measurements.ux[ping], measurements.uy[ping]))
        if not (_within(shape, extent, x, y) and depth > 0.02 and cosine > _STEEP):
            continue
        late = measurements.readings[ping] * scale - depth
        detected = _EARLY < late < _LATE
        if detected or (late > _BEHIND and depth < measurements.max_range - _RIM):
            # One by one: Numba takes a second to compile the assignment of a tuple to a row.
            rows[count, 0], rows[count, 1], rows[count, 2] = depth, abs(sine), strength
            rows[count, 3] = 1.0 if detected else 0.0
            count += 1
    return rows[:count].copy()


@inlined
def _within(shape: Shape, extent: tuple[float, float], x: float, y: float) -> bool:
    """Return whether a position lies in front of the extent of a wall; True for other kinds."""
    return shape[0] != _WALL or extent[0] + _EARLY <= shape[1] * y - shape[2] * x <= extent[1] - _EARLY
