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
    steps = np.diff(angles)
    turns = np.where((np.abs(steps) > np.pi) & (np.abs(wrap(steps)) < _ACROSS), np.round(steps / (2.0 * np.pi)), 0.0)
    unwrapped = angles - 2.0 * np.pi * np.concatenate([[0.0], np.cumsum(turns)])
    sizes = np.abs(np.diff(unwrapped))
    back = _TURNED_BACK * min(float(np.ptp(unwrapped)), 2.0 * np.pi)
    flyback = max(back, _FLYBACK * float(np.median(sizes[sizes > 0.0]))) if sizes.any() else back
    # The extreme of the pass so far is held from reading ``first`` to ``last``: a servo may dwell there.
    starts, first, last, direction = [0], 0, 0, 0.0
    for place, size in enumerate(sizes, start=1):
        moved = unwrapped[place] - unwrapped[last]
        is_far = abs(moved) > back
        if is_far and moved * direction < 0.0:
            starts.append(place if size > flyback else (first + last) // 2 + 1)
            # After a wide step, the servo may turn either way.
            direction = 0.0 if size > back else -direction
            first = last = place
        elif moved == 0.0:
            last = place
        elif is_far or moved * direction > 0.0:
            if abs(unwrapped[last] - unwrapped[starts[-1]]) >= _FULL_TURN:
                starts.append((first + last + 1) // 2)
            direction, first, last = float(np.sign(moved)), place, place
    return np.array(starts, dtype=np.int64)
