"""Passes of a servo: where it turns back, flies back, or has turned all round."""

import numpy as np

from echoplan.arrays import FloatArray, IntArray
from echoplan.geometry import wrap

__all__ = ["LEAST_TURN", "pass_starts"]

# A servo that turns less in all [rad] stands still.
LEAST_TURN = 0.02
# Share of the span of angles by which a servo must have turned back for a new pass: jitter, or a hand that turns the
# sensor, wavers by less.
_TURNED_BACK = 0.2
# Steps of a servo are smaller; a flyback is larger [rad].
_ACROSS = 0.5
# A flyback is longer than so many usual steps.
_FLYBACK = 1.5
# A turn within the precision of angles [rad].
_FULL_TURN = 2.0 * np.pi - 1e-9


def pass_starts(angles: FloatArray) -> IntArray:
    """Return where the passes of a servo start: after each extreme, flyback and full turn.

    ``angles`` [rad], shape (n,), are in the order of time. Jumps of a whole turn between them have no meaning.
    """
    unwrapped = _unwrapped(angles)
    # A servo may dwell: only readings after which the angle changes count, each with the first and last of its like.
    changes = np.flatnonzero(np.diff(unwrapped)) + 1
    firsts, lasts = np.concatenate([[0], changes]), np.concatenate([changes, [len(angles)]]) - 1
    back, flyback = _thresholds(unwrapped[firsts])
    starts, extreme, direction = [0], 0, 0.0
    for place, angle in enumerate(unwrapped[firsts]):
        moved = angle - unwrapped[firsts[extreme]]
        size = abs(angle - unwrapped[firsts[place] - 1])
        middle = int(firsts[extreme] + lasts[extreme]) // 2 + 1
        if abs(moved) > back and moved * direction < 0.0:
            starts.append(int(firsts[place]) if size > flyback else middle)
            # After a wide step, the servo may turn either way.
            extreme, direction = place, -direction * (size <= back)
        elif abs(moved) > back or moved * direction > 0.0:
            if abs(unwrapped[firsts[extreme]] - unwrapped[starts[-1]]) >= _FULL_TURN:
                starts.append(int(firsts[extreme] + lasts[extreme] + 1) // 2)
            extreme, direction = place, float(np.sign(moved))
    return np.array(starts, dtype=np.int64)


def _thresholds(angles: FloatArray) -> tuple[float, float]:
    """Return how far a servo turns back at the least for a new pass, and how long a step is a flyback [rad]."""
    sizes = np.abs(np.diff(angles))
    back = _TURNED_BACK * min(float(np.ptp(angles)), 2.0 * np.pi)
    usual = float(np.median(sizes)) if len(sizes) else 0.0
    return back, max(back, _FLYBACK * usual)


def _unwrapped(angles: FloatArray) -> FloatArray:
    """Remove steps over a whole turn between angles [rad]; a flyback over a part of a turn stays."""
    steps = np.diff(angles)
    turns = np.where((np.abs(steps) > np.pi) & (np.abs(wrap(steps)) < _ACROSS), np.round(steps / (2.0 * np.pi)), 0.0)
    unwrapped: FloatArray = angles - 2.0 * np.pi * np.concatenate([[0.0], np.cumsum(turns)])
    return unwrapped
