"""Beams of ranging sensors that are no sonar: how wide a cone a reading is the nearest point of."""

import math

import numpy as np

from echoplan.arrays import FloatArray, IntArray
from echoplan.preprocessing.measurements import Measurements

__all__ = ["cone_of_rays"]

# A wall is sought about each reading that is the least over this angle to either side [rad].
_ASIDE = math.radians(15.0)
# Steps wider than this show no shape [rad].
_COARSEST = math.radians(3.0)
# Half angles of the cones, and by how much a wall may face another way than the least reading [rad].
_CONES, _TURNS = np.radians(np.arange(0.0, 21.0, 1.0)), np.radians(np.arange(-8.0, 8.5, 1.0))
# What fits a wall worse than this is another thing [m]; readings scatter by this at least [m].
_MISFIT, _SCATTER = 0.03, 0.002
# Fewer walls do not show a cone.
_WALLS = 5


def cone_of_rays(measurements: Measurements) -> float:
    """Estimate the half angle of the cone of which readings are the nearest points.

    About its normal, a wall at distance d reads d over the width of the cone and d / cos(a) beyond it, at an angle a
    from the edge of the cone.  A laser has no such width.  The half angle that fits all walls best is chosen.

    Parameters
    ----------
    measurements : Measurements
        The pings, of a sensor that turns and whose readings glide along walls: ``share_of_ramps``.

    Returns
    -------
    float
        Half angle [rad]; nan where too few walls show it.
    """
    scans = measurements.stations * (int(measurements.sensors.max(initial=0)) + 1) + measurements.sensors
    order = np.argsort(scans, kind="stable")
    parts = np.split(order, np.flatnonzero(np.diff(scans[order])) + 1)
    scores = [score for scan in parts if len(scan) > 1 for score in _scores(measurements, scan)]
    return float(_CONES[np.argmin(np.sum(scores, axis=0))]) if len(scores) >= _WALLS else math.nan


def _scores(measurements: Measurements, scan: IntArray) -> list[FloatArray]:
    """Score the cones at each wall of a scan: negative log-likelihoods, shape (cones,)."""
    bearings, readings = np.unwrap(measurements.bearings[scan]), measurements.readings[scan]
    step = float(np.median(np.abs(np.diff(bearings))))
    half = round(_ASIDE / step) if 0.0 < step <= _COARSEST else len(scan)
    scores = []
    for centre in range(half, len(scan) - half):
        near = slice(centre - half, centre + half + 1)
        angles, ranges = bearings[near] - bearings[centre], readings[near]
        turns_on = abs(angles[-1] - angles[0]) > 1.8 * _ASIDE
        if turns_on and np.isfinite(ranges).all() and ranges.argmin() == half:
            misfits = _misfits(angles, ranges)
            if misfits.min() < _MISFIT**2:
                scores.append(0.5 * len(ranges) * np.log(misfits + _SCATTER**2))
    return scores


def _misfits(angles: FloatArray, readings: FloatArray) -> FloatArray:
    """Return the mean square deviation from the best wall for each cone [m2]."""
    beyond = np.maximum(np.abs(angles - _TURNS[:, None]) - _CONES[:, None, None], 0.0)
    shapes = 1.0 / np.cos(beyond)
    distances = (shapes * readings).sum(axis=-1) / (shapes**2).sum(axis=-1)
    deviations: FloatArray = ((readings - distances[..., None] * shapes) ** 2).mean(axis=-1).min(axis=-1)
    return deviations
