"""Relocalisation: another pose for a single station that misses landmarks which other stations detect."""

import math

from echoplan.arrays import FloatArray
from echoplan.geometry import compose, invert
from echoplan.joint.estimate import Estimate
from echoplan.joint.optimisation.pose_factors import PosePrior, dead_reckoned
from echoplan.joint.pose_correction.pose_tracking import local_scan_of
from echoplan.joint.search.scan_matching import LandmarkMap, locate

__all__ = ["relocalised"]

# Number of other stations that must detect a landmark, and LLR below which a station misses it [nats].
_MANY, _MISSED = 3, -5.0
# Smaller displacements are left to the optimiser, which has converged [m, rad].
_FAR, _TURNED = 0.02, 0.03


def relocalised(estimate: Estimate, priors: PosePrior, station: int) -> FloatArray | None:
    """Return where else a station may be if it misses landmarks that others detect, shape (3,) [m, m, rad], or None.

    It is registered to the landmarks of the other stations within the range of a wheel slip. The result is None if it
    misses no landmark or fits best where it is. The first station of all is not relocalised, since it defines the
    frame.
    """
    least = estimate.settings.search.min_second_station_llr
    detected = [each.supporting(least) - int(each.llr_by_station[station] > least) for each in estimate.features]
    counted = list(zip(estimate.features, detected, strict=True))
    if not any(each.llr_by_station[station] < _MISSED and others >= _MANY for each, others in counted):
        return None
    features = [each for each, others in counted if others]
    known, settings = LandmarkMap.of(features, estimate.measurements.centers), estimate.settings.localisation
    guess = dead_reckoned(priors.measured_poses, estimate.poses, station)
    sigmas = settings.slip_inflation * priors.reaches[station]
    pose, _ = locate(local_scan_of(estimate, station), known, guess, sigmas, settings)
    off = compose(invert(estimate.poses[station]), pose)
    return pose if math.hypot(off[0], off[1]) > _FAR or abs(off[2]) > _TURNED else None
