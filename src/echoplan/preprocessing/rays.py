"""Rays: whether readings were ever sound, or the nearest points in cones of rays that a robot simulator cast."""

import math
from functools import cache

import numpy as np

from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.geometry.angles import wrap
from echoplan.preprocessing.soundings import Soundings

__all__ = ["share_of_ramps"]

# A ramp is looked for over this angle [rad], and in no fewer readings than tell one from chance.
_WIDTH, _FEWEST = math.radians(12.0), 5
# It rises by more than the walk of any module would [m], and by more than this share of the way; that closely it is
# a parabola (of its rise), which steps from one wall to the next are not.
_RISE, _SHARE, _LEFT = 0.1, 0.05, 0.05


def share_of_ramps(soundings: Soundings) -> float:
    """Tell how many of the readings are of surfaces that were met aslant.

    Sound that meets a wall aslant glances off: as a sonar turns away, its reading stays the same, but for the walk, and
    then jumps to something else.  The nearest point in a cone of rays glides along the wall, farther and farther.

    Parameters
    ----------
    soundings : Soundings
        The pings.

    Returns
    -------
    float
        Share of the readings that lie in ramps; 0 of sonars that do not turn.
    """
    heard = np.isfinite(soundings.readings)
    scans = soundings.stations * (int(soundings.sensors.max(initial=0)) + 1) + soundings.sensors
    order = np.argsort(scans, kind="stable")
    parts = np.split(order, np.flatnonzero(np.diff(scans[order])) + 1)
    on_ramps = sum(int(_ramps(soundings, scan).sum()) for scan in parts if len(scan) >= _FEWEST)
    return on_ramps / max(int(heard.sum()), 1)


def _ramps(soundings: Soundings, scan: IntArray) -> BoolArray:
    """Tell which pings of one sensor at one station lie in a ramp."""
    readings, marked = soundings.readings[scan], np.zeros(len(scan), dtype=bool)
    turns = wrap(np.diff(soundings.bearings[scan]))
    step = float(np.median(np.abs(turns)))
    count = max(_FEWEST, math.ceil(_WIDTH / step) + 1) if step else len(scan) + 1
    if count > len(scan):
        return marked
    spans = np.lib.stride_tricks.sliding_window_view(turns, count - 1).sum(axis=1)
    windows = np.lib.stride_tricks.sliding_window_view(readings, count)
    usual = np.abs(np.abs(spans) / ((count - 1) * step) - 1.0) < 0.5
    whole = usual & np.isfinite(windows).all(axis=1)
    places = np.stack([soundings.x[scan], soundings.y[scan]])
    moved = np.hypot(*(places[:, count - 1 :] - places[:, : len(scan) - count + 1]))
    for first in np.flatnonzero(whole)[_are_ramps(windows[whole], moved[whole])]:
        marked[first : first + count] = True
    return marked


def _are_ramps(windows: FloatArray, moved: FloatArray) -> BoolArray:
    """Tell which rows rise or fall steadily, as a parabola, and by more than the sonar moved."""
    count = windows.shape[1]
    basis = _parabolas(count)
    fitted = windows @ basis @ basis.T
    left = np.sqrt(((windows - fitted) ** 2).sum(axis=1) / (count - 3))
    rise = np.abs(fitted[:, -1] - fitted[:, 0])
    ramps: BoolArray = (rise - moved > np.maximum(_RISE, _SHARE * windows.mean(axis=1))) & (left < _LEFT * rise)
    return ramps


@cache
def _parabolas(count: int) -> FloatArray:
    """Orthonormal columns that span the parabolas through so many even places."""
    return np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, count), 3))[0]
