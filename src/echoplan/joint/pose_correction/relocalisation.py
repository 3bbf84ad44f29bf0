"""Relocalisation: another pose for a single station that misses landmarks which other stations detect."""

import math

from echoplan.arrays import FloatArray
from echoplan.geometry import compose, invert
from echoplan.joint.estimate import Estimate
from echoplan.joint.optimisation.pose_factors import PosePrior, dead_reckoned
from echoplan.joint.search.scan_matching import LandmarkMap, LocalScan, local_scans, locate

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
    known, settings = LandmarkMap.of([each for each, others in counted if others]), estimate.settings.localisation
    guess, sigmas = (
        dead_reckoned(priors.measured_poses, estimate.poses, station),
        settings.slip_inflation * priors.reaches[station],
    )
    pose, _ = locate(_sight(estimate, station), known, guess, sigmas, settings)
    off = compose(invert(estimate.poses[station]), pose)
    return pose if math.hypot(off[0], off[1]) > _FAR or abs(off[2]) > _TURNED else None


def _sight(estimate: Estimate, station: int) -> LocalScan:
    """Return the arcs of one station in the frame of the robot."""
    arcs = [each for each in estimate.arcs if each.station == station]
    return local_scans(arcs, estimate.recorded, estimate.model.tabulated(), estimate.measured_poses[station])
