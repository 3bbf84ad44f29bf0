"""Consistency of an estimate with its poses, and the log evidence by which pose models are compared."""

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.joint.estimate import Estimate
from echoplan.joint.likelihood.hypothesis_scores import missed
from echoplan.joint.likelihood.ping_scores import UNCERTAIN
from echoplan.joint.optimisation.effective_sample_size import (
    gain_of_common_errors,
    intraclass_correlation,
)
from echoplan.joint.optimisation.odometry_noise import VERY_STRONG
from echoplan.joint.optimisation.pose_factors import PosePrior, pose_factors, waypoint_prior
from echoplan.joint.search.duplicates import without_duplicates

__all__ = [
    "agrees",
    "are_weakly_connected",
    "contradicts_odometry",
    "explained_arcs",
    "has_duplicated_walls",
    "inlier_ratio",
    "is_inconsistent",
    "jaccard_index",
    "log_evidence",
    "pose_pulls",
    "stations_disagree",
]

# Cost of an apparent duplicate in addition to its own, in landmarks: two distinct walls are rarely so near to each
# other.
_RARE = 3.0
# Ratio of squared pose errors to their expectation above which the noise may be greater than specified (a false alarm
# only costs time); minimum number of poses, so that steps remain beside the one that may be a slip.
_PULLED, _FEWEST = 1.5, 3


def inlier_ratio(estimate: Estimate) -> float:
    """Return the share of pings in arcs that landmarks (without duplicates) or multipath explain; 1 without arcs."""
    detected = np.concatenate([arc.pings for arc in estimate.arcs]) if estimate.arcs else np.zeros(0, dtype=np.int64)
    features = without_duplicates(estimate.features, estimate.settings.duplicates)
    return float(estimate.inlier_mask(features)[detected].mean()) if len(detected) else 1.0


def explained_arcs(estimate: Estimate) -> float:
    """Return how many arcs landmarks or multipath explain."""
    explained = estimate.inlier_mask(estimate.features)
    return float(sum(arc.share_of(explained) for arc in estimate.arcs))


def jaccard_index(estimate: Estimate) -> float:
    """Return the Jaccard index of arcs and landmarks: explained arcs over all arcs and missed detections."""
    missed_by = [each.llr_by_station < -VERY_STRONG for each in estimate.features]
    return explained_arcs(estimate) / (len(estimate.arcs) + int(np.count_nonzero(missed_by)))


def agrees(estimate: Estimate) -> bool:
    """Return whether most pings in arcs are explained and the estimated noise does not exceed its initial value."""
    return inlier_ratio(estimate) >= estimate.settings.min_inlier_ratio and estimate.noise <= estimate.first_noise


def has_duplicated_walls(estimate: Estimate) -> bool:
    """Return whether many walls are duplicated, which drifting poses cause."""
    walls = sum(each.is_wall for each in estimate.features)
    return _copies(estimate) > estimate.settings.max_duplicate_fraction * walls


def is_inconsistent(estimate: Estimate) -> bool:
    """Return whether poses may be wrong.

    Either too few pings are explained, or stations contradict each other, or too few walls are detected by several
    stations.
    """
    # Poses that were accepted for marginalised stations are questioned only if pings are unexplained.
    return not agrees(estimate) or (
        estimate.marginal_prior.is_empty and (stations_disagree(estimate) or are_weakly_connected(estimate))
    )


def stations_disagree(estimate: Estimate) -> bool:
    """Return whether stations contradict each other: duplicate walls, or errors that readings of a station share.

    Shared errors are measured by the intraclass correlation of the residuals. The result is True without a solution.
    """
    # A bent wall looks like a duplicate, too: then other poses are tried in vain, which only costs time.
    if estimate.solution is None or _copies(estimate):
        return True
    owners, left = estimate.solution.owners, estimate.solution.residuals
    icc = intraclass_correlation(estimate.measurements, owners, left, noise=estimate.noise)
    # Errors of the sonar model are shared as well, but are smaller than the least noise of a reading.
    usual = max(estimate.shared_rounding(estimate.noise, icc), estimate.settings.min_sigma)
    return icc > estimate.settings.max_icc and icc * estimate.noise**2 > usual**2


def are_weakly_connected(estimate: Estimate) -> bool:
    """Return whether most walls are supported by one station each, so that nothing connects the poses."""
    walls = [each for each in estimate.features if each.is_wall]
    lone = sum(each.supporting(estimate.settings.search.min_second_station_llr) < 2 for each in walls)
    return 2 * lone > len(walls)


def log_evidence(estimate: Estimate) -> float:
    """Return the log evidence of an estimate against clutter, minus the cost of landmarks and free poses [nats].

    A free pose parameter costs half the logarithm of the number of readings that determine it (Schwarz 1978), a
    landmark the LLR that its acceptance requires, and an apparent duplicate three times that in addition; gain and
    offset of a calibrated servo cost as much as pose parameters. Errors of poses, and of gain and offset, cost their
    negative log prior. Readings of one landmark from one station may share an error: otherwise landmarks detected by
    one station each would explain more than one that all stations detect.
    """
    llr_by_ping = estimate.likelihood.log_densities(estimate.features) - estimate.likelihood.floor
    cost = estimate.settings.search.min_log_likelihood_ratio * (len(estimate.features) + _RARE * _copies(estimate))
    if estimate.pose_prior is not None:
        detected = np.bincount(
            estimate.measurements.stations[llr_by_ping > 0.0], minlength=len(estimate.measured_poses)
        )
        cost += 1.5 * float(np.log(np.maximum(detected[1:], 1)).sum())
        cost += 0.5 * float(pose_pulls(estimate, estimate.pose_prior).sum())
    if estimate.servo is not None:
        strain = estimate.settings.optimiser.servo_strain(*estimate.servo)
        cost += float(np.log(np.count_nonzero(llr_by_ping > 0.0) + 1.0)) + float(strain)
    misses = sum(missed(estimate.measurements, each.ping_scores, each.extent) for each in estimate.features)
    return float(estimate.measurements.weights @ llr_by_ping) + misses + _gain_of_common_errors(estimate) - cost


def contradicts_odometry(estimate: Estimate) -> bool:
    """Return whether pose errors exceed their prior: mean square of all but the greatest above 1.5 times expectation.

    The greatest is left out, since a single large error is a wheel slip and does not show that the other steps are
    worse than specified.
    """
    if estimate.pose_prior is None or len(estimate.poses) < _FEWEST:
        return False
    pulls = np.sort(pose_pulls(estimate, estimate.pose_prior)[1:].sum(axis=1))[:-1]
    return float(pulls.mean()) > 3.0 * _PULLED


def pose_pulls(estimate: Estimate, pose_prior: PosePrior) -> FloatArray:
    """Return the squared errors of poses in units of their prior variances, shape (s, 3)."""
    by_hand = waypoint_prior(estimate.measured_poses, estimate.settings.pose_errors)
    held = pose_factors(estimate.odometry() if pose_prior.relative else by_hand, estimate.poses, 0)
    pulls: FloatArray = (held.weights * held.residuals**2).reshape(-1, 3)
    return pulls


def _copies(estimate: Estimate) -> int:
    """Return the number of walls that appear to be duplicates."""
    return len(estimate.features) - len(without_duplicates(estimate.features, estimate.settings.duplicates))


def _gain_of_common_errors(estimate: Estimate) -> float:
    """Return the log-likelihood ratio of residuals that share an error by landmark and station [nats]."""
    if estimate.solution is None:
        return 0.0
    # Weak echoes have a greater noise of their own in the model, so they are left out.
    owners = np.where(estimate.solution.excesses < UNCERTAIN, -1, estimate.solution.owners)
    common = estimate.settings.pose_errors.bias_sigma
    return gain_of_common_errors(
        estimate.measurements, owners, estimate.solution.residuals, noise=estimate.noise, common=common
    )
