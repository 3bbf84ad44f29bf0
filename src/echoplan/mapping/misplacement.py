"""Misplacement: single stations that came to rest where what all others know is missing."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.classification.hypotheses import Hypothesis
from echoplan.geometry import compose, invert
from echoplan.mapping.account import Account
from echoplan.mapping.localisation import Catalogue, locate
from echoplan.mapping.poses import PoseBeliefs, continued
from echoplan.mapping.tracking import sights_of

__all__ = ["elsewhere"]

# A feature that so many other stations hear is there; a station from which this speaks against it missed it [nats].
_MANY, _MISSED = 3, -5.0
# A station is looked for so many times as far off as odometry errs.
_ASTRAY = 2.0
# It is somewhere else if it is farther off than an adjustment would have moved it [m, rad].
_FAR, _TURNED = 0.02, 0.03


def elsewhere(account: Account, beliefs: PoseBeliefs) -> Iterator[tuple[int, FloatArray]]:
    """Look for each station that should hear something and does not in what the others know.

    Parameters
    ----------
    account : Account
        What was heard, and what is made of it.
    beliefs : PoseBeliefs
        Odometry.

    Yields
    ------
    station : int
        Its number.
    pose : ndarray, shape (3,)
        Where else it may be [m, m, rad].
    """
    first = max(1, len(account.memory.poses))
    missing = [each for each in range(first, len(account.poses)) if _misses(account.features, each)]
    if not missing:
        return
    sights, settings = sights_of(account), account.settings.localisation
    for station in missing:
        known = Catalogue.of([each for each in account.features if _others(each, station) > 0])
        reckoned = continued(beliefs.given[: station + 1], account.poses[:station])[-1]
        pose, _ = locate(sights[station], known, reckoned, _ASTRAY * beliefs.sigmas[station], settings)
        off = compose(invert(account.poses[station]), pose)
        if math.hypot(off[0], off[1]) > _FAR or abs(off[2]) > _TURNED:
            yield station, pose


def _misses(features: Sequence[Hypothesis], station: int) -> bool:
    return any(each.gains[station] < _MISSED and _others(each, station) >= _MANY for each in features)


def _others(feature: Hypothesis, station: int) -> int:
    """Count the other stations that hear a feature."""
    return feature.past.speaking + int((np.delete(feature.gains, station) > 0.0).sum())
