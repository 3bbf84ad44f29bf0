"""Misplacement: single stations that came to rest where what all others know is missing."""

import math

from echoplan.arrays import FloatArray
from echoplan.geometry import compose, invert
from echoplan.joint.estimate import Estimate
from echoplan.joint.optimisation.pose_factors import PosePrior, dead_reckoned
from echoplan.joint.search.scan_matching import LandmarkMap, LocalScan, local_scans, locate

__all__ = ["relocalised"]

# A feature that so many other stations hear is there; a station from which this speaks against it misses it [nats].
_MANY, _MISSED = 3, -5.0
# Nearer places are within reach of an adjustment, which has settled between them [m, rad].
_FAR, _TURNED = 0.02, 0.03


def relocalised(estimate: Estimate, priors: PosePrior, station: int) -> FloatArray | None:
    """Look for a station that should hear something and does not in what the others know.

    Parameters
    ----------
    estimate : Estimate
        What was heard, and what is made of it.
    priors : PosePrior
        Odometry.
    station : int
        Its number; not the first of all, which is the frame.

    Returns
    -------
    ndarray, shape (3,), or None
        Where else it may be [m, m, rad]; nothing if it misses nothing, or fits best where it is.
    """
    least = estimate.settings.search.second_station
    detected = [each.supporting(least) - int(each.llr_by_station[station] > least) for each in estimate.features]
    counted = list(zip(estimate.features, detected, strict=True))
    if not any(each.llr_by_station[station] < _MISSED and others >= _MANY for each, others in counted):
        return None
    known, settings = LandmarkMap.of([each for each, others in counted if others]), estimate.settings.localisation
    guess, sigmas = (
        dead_reckoned(priors.measured_poses, estimate.poses, station),
        settings.astray * priors.reaches[station],
    )
    pose, _ = locate(_sight(estimate, station), known, guess, sigmas, settings)
    off = compose(invert(estimate.poses[station]), pose)
    return pose if math.hypot(off[0], off[1]) > _FAR or abs(off[2]) > _TURNED else None


def _sight(estimate: Estimate, station: int) -> LocalScan:
    arcs = [each for each in estimate.arcs if each.station == station]
    return local_scans(arcs, estimate.recorded, estimate.model.tabulated(), estimate.measured_poses[station])
