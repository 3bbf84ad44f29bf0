"""Hits and misses: which pings heard what they could have heard, and how likely that was."""

import math

from echoplan.compiled import compiled
from echoplan.joint.likelihood.ping_scores import detection_probability

__all__ = ["RIM", "log_chance", "outcome_of"]

# No reading is expected within this of the reach [m].
RIM = 0.02
# No ping is surer than this: things stand in the way, others echo from just there.
_LEAST, _MOST = 0.03, 0.97
_LOG_LEAST, _LOG_MOST = math.log(_LEAST), math.log(_MOST)
# Where every echo is as sure as that, or as faint [dB].
_FADED = 5.0
# Readings this much before the depth, or after that of the faintest echo, may still be hits; later ones are misses [m].
_EARLY, _LATE, _BEHIND = -0.02, 0.02, 0.04


@compiled
def outcome_of(late: float, faintest: float) -> float:
    """Tell whether a ping heard what it faced.

    Parameters
    ----------
    late : float
        Its reading less the depth [m].
    faintest : float
        How much too far the faintest echo is read [m].

    Returns
    -------
    float
        1 for a hit, -1 for a miss, 0 where something nearer answered.
    """
    if _EARLY < late < faintest + _LATE:
        return 1.0
    return -1.0 if late > faintest + _BEHIND else 0.0


@compiled
def log_chance(excess: float) -> float:
    """Tell how likely an echo is heard; most are far from the threshold.

    Parameters
    ----------
    excess : float
        Its signal excess [dB]; with the opposite sign, how likely it is missed.

    Returns
    -------
    float
        Logarithm of the chance.
    """
    if abs(excess) > _FADED:
        return _LOG_MOST if excess > 0.0 else _LOG_LEAST
    return math.log(min(max(detection_probability(excess), _LEAST), _MOST))
