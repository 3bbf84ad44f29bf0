"""Detections and non-detections of a landmark: classification of pings, and their log-likelihood."""

import math

from echoplan.compiled import inlined
from echoplan.joint.likelihood.ping_scores import detection_probability

__all__ = ["RIM", "log_chance", "outcome_of"]

# No detection is expected within this distance of ``max_range`` [m].
RIM = 0.02
# Bounds of the detection probability of a ping: landmarks may be occluded, and others may echo at the same range.
_LEAST, _MOST = 0.03, 0.97
_LOG_LEAST, _LOG_MOST = math.log(_LEAST), math.log(_MOST)
# Beyond this signal excess, positive or negative, the bounds apply [dB].
_FADED = 5.0
# A reading is a detection from _EARLY past the depth to _LATE past the range of the weakest echo, and a non-detection
# from _BEHIND past that range on [m].
_EARLY, _LATE, _BEHIND = -0.02, 0.02, 0.04


@inlined
def outcome_of(late: float, faintest: float) -> float:
    """Return 1 for a detection, -1 for a non-detection, 0 if a nearer echo masks the landmark or if it is unclear.

    ``late`` is the reading minus the depth, ``faintest`` the range walk of the weakest echo [m].
    """
    if _EARLY < late < faintest + _LATE:
        return 1.0
    return -1.0 if late > faintest + _BEHIND else 0.0


@inlined
def log_chance(excess: float) -> float:
    """Return the log probability of detection at this signal excess [dB]; at its negative, of non-detection."""
    if abs(excess) > _FADED:
        return _LOG_MOST if excess > 0.0 else _LOG_LEAST
    return math.log(min(max(detection_probability(excess), _LEAST), _MOST))
