"""Agreement: whether all that was heard fits together, as it does from exact poses."""

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.geometry import along, signed_distances, wrap
from echoplan.joint.estimate import Estimate
from echoplan.joint.likelihood.hypothesis_scores import missed
from echoplan.joint.likelihood.ping_scores import UNCERTAIN
from echoplan.joint.optimisation.effective_sample_size import (
    gain_of_common_errors,
    intraclass_correlation,
)
from echoplan.joint.optimisation.odometry_noise import VERY_STRONG
from echoplan.joint.optimisation.pose_factors import PosePrior, pose_factors, waypoint_prior
from echoplan.joint.search.duplicates import cross, duplicate_pairs, without_duplicates

__all__ = [
    "agrees",
    "are_weakly_connected",
    "contradicts_odometry",
    "has_duplicated_walls",
    "has_shared_bias",
    "inlier_ratio",
    "is_inconsistent",
    "log_evidence",
]

# Two walls so near to each other are as rare as so many other features.
_RARE = 3.0
# Errors may be greater than was believed where their squares are so many times what these should be: to ask in vain
# costs time only.  From fewer poses no step is left but the one that may be a slip.
_PULLED, _FEWEST = 1.5, 3


def inlier_ratio(estimate: Estimate) -> float:
    """Tell how many of the pings of arcs features or their ghosts explain; a wall that is there twice is none.

    Parameters
    ----------
    estimate : Estimate
        What was heard, and what is made of it.

    Returns
    -------
    float
        Their share; 1 without arcs.
    """
    detected = np.concatenate([arc.pings for arc in estimate.arcs]) if estimate.arcs else np.zeros(0, dtype=np.int64)
    features = without_duplicates(estimate.features, estimate.settings.copies)
    return float(estimate.inlier_mask(features)[detected].mean()) if len(detected) else 1.0


def agrees(estimate: Estimate) -> bool:
    """Tell whether the pings fit together.

    Parameters
    ----------
    estimate : Estimate
        What was heard, and what is made of it.

    Returns
    -------
    bool
        Whether most are explained, by readings that scatter as usual.
    """
    return inlier_ratio(estimate) >= estimate.settings.min_inlier_ratio and estimate.noise <= estimate.first_noise


def has_duplicated_walls(estimate: Estimate) -> bool:
    """Tell whether many walls are there twice: poses that drift do that.

    Parameters
    ----------
    estimate : Estimate
        What was heard, and what is made of it.

    Returns
    -------
    bool
        Whether they are.
    """
    walls = sum(each.is_wall for each in estimate.features)
    return _copies(estimate) > estimate.settings.torn * walls


def is_inconsistent(estimate: Estimate) -> bool:
    """Tell whether poses may be wrong: pings do not fit together, or stations are at odds or have little in common.

    Parameters
    ----------
    estimate : Estimate
        What was heard, and what is made of it.

    Returns
    -------
    bool
        Whether they may be.
    """
    # What was trusted so far is doubted again only if pings do not agree.
    return not agrees(estimate) or (
        estimate.marginal_prior.is_empty and (are_weakly_connected(estimate) or has_shared_bias(estimate))
    )


def are_weakly_connected(estimate: Estimate) -> bool:
    """Tell whether stations contradict each other: a wall is there twice, or readings of a station err together.

    Parameters
    ----------
    estimate : Estimate
        What was heard, and what is made of it.

    Returns
    -------
    bool
        Whether they do; also if nothing was heard that could tell.
    """
    if estimate.solution is None or (_copies(estimate) and not _are_two(estimate)):
        return True
    owners, left = estimate.solution.owners, estimate.solution.residuals
    common = intraclass_correlation(estimate.measurements, owners, left, noise=estimate.noise)
    # What the model of the sonar lacks makes readings err together, too, by less than the best of them scatter.
    usual = max(estimate.shared_rounding(estimate.noise, common), estimate.settings.least_noise)
    return common > estimate.settings.shared_error and common * estimate.noise**2 > usual**2


def has_shared_bias(estimate: Estimate) -> bool:
    """Tell whether most walls were heard from one station each: then nothing holds the poses of stations together.

    Parameters
    ----------
    estimate : Estimate
        What was heard, and what is made of it.

    Returns
    -------
    bool
        Whether they were.
    """
    walls = [each for each in estimate.features if each.is_wall]
    lone = sum(each.supporting(estimate.settings.search.second_station) < 2 for each in walls)
    return 2 * lone > len(walls)


def log_evidence(estimate: Estimate) -> float:
    """Tell how much better features explain the pings than nothing does, less what they and free poses cost.

    Each free parameter of a pose costs half of the logarithm of the number of readings that tell it (Schwarz 1978),
    each feature what a candidate must gain to be accepted, and a wall that seems to be there twice three times that
    more; gain and offset of a servo that is calibrated cost as much as others.  Poses that are far off cost what makes
    them unlikely, and so do gain and offset.  Readings of one feature from one station may err
    together: else features that were heard from one station each would seem to explain more than one that was heard
    from all of them.

    Parameters
    ----------
    estimate : Estimate
        What was heard, and what is made of it.

    Returns
    -------
    float
        Logarithm of a ratio of likelihoods [nats].
    """
    llr_by_station = estimate.likelihood.log_densities(estimate.features) - estimate.likelihood.floor
    cost = estimate.settings.search.accept * (len(estimate.features) + _RARE * _copies(estimate))
    if estimate.pose_prior is not None:
        detected = np.bincount(
            estimate.measurements.stations[llr_by_station > 0.0], minlength=len(estimate.measured_poses)
        )
        cost += 1.5 * float(np.log(np.maximum(detected[1:], 1)).sum()) + _strain(estimate, estimate.pose_prior)
    if estimate.servo is not None:
        strain = estimate.settings.optimiser.servo_strain(*estimate.servo)
        cost += float(np.log(np.count_nonzero(llr_by_station > 0.0) + 1.0)) + float(strain)
    misses = sum(missed(estimate.measurements, each.ping_scores, each.extent) for each in estimate.features)
    return float(estimate.measurements.weights @ llr_by_station) + misses + _gain_of_common_errors(estimate) - cost


def contradicts_odometry(estimate: Estimate) -> bool:
    """Tell whether pings pull poses farther from where they were believed to be than chance would.

    A single step that led astray is a slip, and tells nothing of the others.

    Parameters
    ----------
    estimate : Estimate
        Of corrected poses.

    Returns
    -------
    bool
        Whether the squares of all errors but the greatest, in deviations, are half as great again as these should be.
    """
    if estimate.pose_prior is None or len(estimate.poses) < _FEWEST:
        return False
    pulls = np.sort(_pulls(estimate, estimate.pose_prior)[1:].sum(axis=1))[:-1]
    return float(pulls.mean()) > 3.0 * _PULLED


def _copies(estimate: Estimate) -> int:
    """Count walls that seem to be there twice."""
    return len(estimate.features) - len(without_duplicates(estimate.features, estimate.settings.copies))


def _are_two(estimate: Estimate) -> bool:
    """Tell whether walls that seem to be one twice are two, even if poses are off by what is usual for odometry.

    Where stations that heard either of them have enough else in common, both are known well from free poses, too.
    Only where pings fit together is all that they have in common what it is taken for, and no two walls cross.
    """
    pairs = duplicate_pairs(estimate.features, estimate.settings.copies)
    if not agrees(estimate) or any(cross(estimate.features[one], estimate.features[other]) for one, other in pairs):
        return False
    free = estimate.optimise(estimate.noise, estimate.odometry())
    return all(_contradiction(free, pair) > VERY_STRONG for pair in pairs)


def _contradiction(estimate: Estimate, pair: tuple[int, int]) -> float:
    """Tell how far two walls are from being one, by how well these are known: half of Mahalanobis' distance squared."""
    solution, copied, numbers = estimate.solution, estimate.features[pair[1]], list(pair)
    assert solution is not None
    lines, middle = solution.reflectors[numbers, 1:3], copied.ends_xy.mean(axis=0)
    offsets, beside = signed_distances(lines, middle), along(lines, middle)
    apart = np.array([wrap(lines[0, 0] - lines[1, 0]), offsets[0] - offsets[1]])
    jacobian = np.array([[1.0, 0.0, -1.0, 0.0], [beside[0], -1.0, -beside[1], 1.0]])
    places = (solution.layout.starts[numbers][:, None] + np.arange(2)).ravel()
    covariance = jacobian @ solution.covariance[np.ix_(places, places)] @ jacobian.T
    return 0.5 * float(apart @ np.linalg.solve(covariance, apart))


def _gain_of_common_errors(estimate: Estimate) -> float:
    if estimate.solution is None:
        return 0.0
    # Faint echoes are believed to scatter more than others, each by itself.
    owners = np.where(estimate.solution.excesses < UNCERTAIN, -1, estimate.solution.owners)
    common = estimate.settings.pose_errors.bias_sigma
    return gain_of_common_errors(
        estimate.measurements, owners, estimate.solution.residuals, noise=estimate.noise, common=common
    )


def _strain(estimate: Estimate, pose_prior: PosePrior) -> float:
    """Tell how unlikely it is that poses are so far off: as was believed before the pings were asked [nats]."""
    return 0.5 * float(_pulls(estimate, pose_prior).sum())


def _pulls(estimate: Estimate, pose_prior: PosePrior) -> FloatArray:
    """Squares of the errors of poses, in deviations that were believed before the pings were asked, shape (s, 3)."""
    by_hand = waypoint_prior(estimate.measured_poses, estimate.settings.pose_errors)
    held = pose_factors(estimate.odometry() if pose_prior.relative else by_hand, estimate.poses, 0)
    pulls: FloatArray = (held.weights * held.residuals**2).reshape(-1, 3)
    return pulls
