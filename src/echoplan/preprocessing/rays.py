"""Rays: whether readings were ever sound, or the nearest points in cones of rays that a robot simulator cast."""

import math
from functools import cache

import numpy as np

from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.geometry.angles import wrap
from echoplan.preprocessing.measurements import Measurements

__all__ = ["are_rays", "share_of_ramps"]

# A ramp is sought over this angle [rad].  Fewer readings fit any parabola: with 5 in a window, up to a third of the
# readings of sonars turned by hand seem to lie in ramps.
_WIDTH, _FEWEST = math.radians(12.0), 8
# Wider steps show no ramp: eight readings are of one reflector and the next [rad].
_COARSEST = math.radians(3.0)
# Within a ramp all steps are this even: a factor about the median.
_UNEVEN = 2.0
# A ramp rises by more than the walk of any module would [m], and by more than this share of the range.  It is a
# parabola, but for this share of its rise, which steps from one wall to the next are not; and its echo points lie on a
# line that closely, which readings of a sonar in a moving hand do not.
_RISE, _SHARE, _LEFT = 0.1, 0.05, 0.05

# Of the readings of sound hardly one in a hundred is in a ramp; of rays, with a centimetre of noise, one in ten.
_RAYS = 0.05


def are_rays(measurements: Measurements) -> bool:
    """Return True if readings are the nearest points in cones of rays, and no echoes."""
    return share_of_ramps(measurements) > _RAYS


def share_of_ramps(measurements: Measurements) -> float:
    """Return the share of the readings that glide along surfaces met at a slant.

    Sound that meets a wall at a slant is reflected away: as a sonar turns away, its reading stays the same, but for the
    walk, and then jumps to something else.  The nearest point in a cone of rays glides along the wall, farther and
    farther.

    Parameters
    ----------
    measurements : Measurements
        The pings.

    Returns
    -------
    float
        Share of the readings that lie in ramps; 0 of sonars that do not turn, or in steps too wide to show a ramp.
    """
    detected = np.isfinite(measurements.readings)
    scans = measurements.stations * (int(measurements.sensors.max(initial=0)) + 1) + measurements.sensors
    order = np.argsort(scans, kind="stable")
    parts = np.split(order, np.flatnonzero(np.diff(scans[order])) + 1)
    on_ramps = sum(int(_ramps(measurements, scan).sum()) for scan in parts if len(scan) >= _FEWEST)
    return on_ramps / max(int(detected.sum()), 1)


def _ramps(measurements: Measurements, scan: IntArray) -> BoolArray:
    """Mark the pings of one sensor at one station that lie in a ramp."""
    readings, marked = measurements.readings[scan], np.zeros(len(scan), dtype=bool)
    turns = wrap(np.diff(measurements.bearings[scan]))
    step = float(np.median(np.abs(turns)))
    count = max(_FEWEST, math.ceil(_WIDTH / step) + 1) if 0.0 < step <= _COARSEST else len(scan) + 1
    if count > len(scan):
        return marked
    # A simulated servo turns evenly, a hand does not.
    steps = np.abs(_windows(turns, count - 1)) / step
    even = ((steps < _UNEVEN) & (steps > 1.0 / _UNEVEN)).all(axis=1)
    whole = even & np.isfinite(_windows(readings, count)).all(axis=1)
    places = np.stack([measurements.x[scan], measurements.y[scan]])
    moved = np.hypot(*(places[:, count - 1 :] - places[:, : len(scan) - count + 1]))
    ways = np.where(np.isfinite(readings), readings, 0.0)
    echoes = places + ways * np.stack([measurements.ux[scan], measurements.uy[scan]])
    points = np.stack([_windows(each, count)[whole] for each in echoes], axis=-1)
    for first in np.flatnonzero(whole)[_are_ramps(_windows(readings, count)[whole], points, moved[whole])]:
        marked[first : first + count] = True
    return marked


def _windows(values: FloatArray, count: int) -> FloatArray:
    return np.lib.stride_tricks.sliding_window_view(values, count)


def _are_ramps(windows: FloatArray, points: FloatArray, moved: FloatArray) -> BoolArray:
    """Return which rows rise or fall by more than the sonar moved, as a parabola, with echo points on a line."""
    count = windows.shape[1]
    basis = _parabolas(count)
    fitted = windows @ basis @ basis.T
    left = np.sqrt(((windows - fitted) ** 2).sum(axis=1) / (count - 3))
    rise = np.abs(fitted[:, -1] - fitted[:, 0])
    rises: BoolArray = (rise - moved > np.maximum(_RISE, _SHARE * windows.mean(axis=1))) & (left < _LEFT * rise)
    centred = points - points.mean(axis=1, keepdims=True)
    aside = np.linalg.svd(centred, compute_uv=False)[:, 1] / math.sqrt(count - 2)
    return rises & (aside < _LEFT * rise)


@cache
def _parabolas(count: int) -> FloatArray:
    """Orthonormal columns that span the parabolas through so many even places."""
    return np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, count), 3))[0]
