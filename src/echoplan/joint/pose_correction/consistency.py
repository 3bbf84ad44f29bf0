"""Agreement: whether all that was heard fits together, as it does from exact poses."""

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.geometry import along, signed_distances, wrap
from echoplan.joint.estimate import Account
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
    "agreement",
    "agrees",
    "are_at_odds",
    "evidence",
    "has_duplicated_walls",
    "is_inconsistent",
    "is_scattered",
    "is_strained",
]

# Two walls so near to each other are as rare as so many other features.
_RARE = 3.0
# Errors may be greater than was believed where their squares are so many times what these should be: to ask in vain
# costs time only.  From fewer poses no step is left but the one that may be a slip.
_PULLED, _FEWEST = 1.5, 3


def agreement(account: Account) -> float:
    """Tell how many of the pings of arcs features or their ghosts explain; a wall that is there twice is none.

    Parameters
    ----------
    account : Account
        What was heard, and what is made of it.

    Returns
    -------
    float
        Their share; 1 without arcs.
    """
    detected = np.concatenate([arc.pings for arc in account.arcs]) if account.arcs else np.zeros(0, dtype=np.int64)
    features = without_duplicates(account.features, account.settings.copies)
    return float(account.explained(features)[detected].mean()) if len(detected) else 1.0


def agrees(account: Account) -> bool:
    """Tell whether the pings fit together.

    Parameters
    ----------
    account : Account
        What was heard, and what is made of it.

    Returns
    -------
    bool
        Whether most are explained, by readings that scatter as usual.
    """
    return agreement(account) >= account.settings.agreement and account.noise <= account.first_noise


def has_duplicated_walls(account: Account) -> bool:
    """Tell whether many walls are there twice: poses that drift do that.

    Parameters
    ----------
    account : Account
        What was heard, and what is made of it.

    Returns
    -------
    bool
        Whether they are.
    """
    walls = sum(each.is_wall for each in account.features)
    return _copies(account) > account.settings.torn * walls


def is_inconsistent(account: Account) -> bool:
    """Tell whether poses may be wrong: pings do not fit together, or stations are at odds or have little in common.

    Parameters
    ----------
    account : Account
        What was heard, and what is made of it.

    Returns
    -------
    bool
        Whether they may be.
    """
    # What was trusted so far is doubted again only if pings do not agree.
    return not agrees(account) or (account.memory.is_empty and (are_at_odds(account) or is_scattered(account)))


def are_at_odds(account: Account) -> bool:
    """Tell whether stations contradict each other: a wall is there twice, or readings of a station err together.

    Parameters
    ----------
    account : Account
        What was heard, and what is made of it.

    Returns
    -------
    bool
        Whether they do; also if nothing was heard that could tell.
    """
    if account.adjusted is None or (_copies(account) and not _are_two(account)):
        return True
    owners, left = account.adjusted.owners, account.adjusted.residuals
    common = intraclass_correlation(account.measurements, owners, left, noise=account.noise)
    # What the model of the sonar lacks makes readings err together, too, by less than the best of them scatter.
    usual = max(account.common_rounding(account.noise, common), account.settings.least_noise)
    return common > account.settings.shared_error and common * account.noise**2 > usual**2


def is_scattered(account: Account) -> bool:
    """Tell whether most walls were heard from one station each: then nothing holds the poses of stations together.

    Parameters
    ----------
    account : Account
        What was heard, and what is made of it.

    Returns
    -------
    bool
        Whether they were.
    """
    walls = [each for each in account.features if each.is_wall]
    lone = sum(each.supporting(account.settings.search.second_station) < 2 for each in walls)
    return 2 * lone > len(walls)


def evidence(account: Account) -> float:
    """Tell how much better features explain the pings than nothing does, less what they and free poses cost.

    Each free parameter of a pose costs half of the logarithm of the number of readings that tell it (Schwarz 1978),
    each feature what a candidate must gain to be accepted, and a wall that seems to be there twice three times that
    more; gain and offset of a servo that is calibrated cost as much as others.  Poses that are far off cost what makes
    them unlikely, and so do gain and offset.  Readings of one feature from one station may err
    together: else features that were heard from one station each would seem to explain more than one that was heard
    from all of them.

    Parameters
    ----------
    account : Account
        What was heard, and what is made of it.

    Returns
    -------
    float
        Logarithm of a ratio of likelihoods [nats].
    """
    llr_by_station = account.explanation.log_densities(account.features) - account.explanation.floor
    cost = account.settings.search.accept * (len(account.features) + _RARE * _copies(account))
    if account.pose_prior is not None:
        detected = np.bincount(account.measurements.stations[llr_by_station > 0.0], minlength=len(account.given))
        cost += 1.5 * float(np.log(np.maximum(detected[1:], 1)).sum()) + _strain(account, account.pose_prior)
    if account.servo is not None:
        strain = account.settings.adjustment.servo_strain(*account.servo)
        cost += float(np.log(np.count_nonzero(llr_by_station > 0.0) + 1.0)) + float(strain)
    misses = sum(missed(account.measurements, each.evidence, each.extent) for each in account.features)
    return float(account.measurements.weights @ llr_by_station) + misses + _gain_of_common_errors(account) - cost


def is_strained(account: Account) -> bool:
    """Tell whether pings pull poses farther from where they were believed to be than chance would.

    A single step that led astray is a slip, and tells nothing of the others.

    Parameters
    ----------
    account : Account
        Of corrected poses.

    Returns
    -------
    bool
        Whether the squares of all errors but the greatest, in deviations, are half as great again as these should be.
    """
    if account.pose_prior is None or len(account.poses) < _FEWEST:
        return False
    pulls = np.sort(_pulls(account, account.pose_prior)[1:].sum(axis=1))[:-1]
    return float(pulls.mean()) > 3.0 * _PULLED


def _copies(account: Account) -> int:
    """Count walls that seem to be there twice."""
    return len(account.features) - len(without_duplicates(account.features, account.settings.copies))


def _are_two(account: Account) -> bool:
    """Tell whether walls that seem to be one twice are two, even if poses are off by what is usual for odometry.

    Where stations that heard either of them have enough else in common, both are known well from free poses, too.
    Only where pings fit together is all that they have in common what it is taken for, and no two walls cross.
    """
    pairs = duplicate_pairs(account.features, account.settings.copies)
    if not agrees(account) or any(cross(account.features[one], account.features[other]) for one, other in pairs):
        return False
    free = account.adjust(account.noise, account.odometry())
    return all(_contradiction(free, pair) > VERY_STRONG for pair in pairs)


def _contradiction(account: Account, pair: tuple[int, int]) -> float:
    """Tell how far two walls are from being one, by how well these are known: half of Mahalanobis' distance squared."""
    adjusted, copied, numbers = account.adjusted, account.features[pair[1]], list(pair)
    assert adjusted is not None
    lines, middle = adjusted.reflectors[numbers, 1:3], copied.ends_xy.mean(axis=0)
    offsets, beside = signed_distances(lines, middle), along(lines, middle)
    apart = np.array([wrap(lines[0, 0] - lines[1, 0]), offsets[0] - offsets[1]])
    jacobian = np.array([[1.0, 0.0, -1.0, 0.0], [beside[0], -1.0, -beside[1], 1.0]])
    places = (adjusted.layout.starts[numbers][:, None] + np.arange(2)).ravel()
    covariance = jacobian @ adjusted.covariance[np.ix_(places, places)] @ jacobian.T
    return 0.5 * float(apart @ np.linalg.solve(covariance, apart))


def _gain_of_common_errors(account: Account) -> float:
    if account.adjusted is None:
        return 0.0
    # Faint echoes are believed to scatter more than others, each by itself.
    owners = np.where(account.adjusted.excesses < UNCERTAIN, -1, account.adjusted.owners)
    common = account.settings.pose_errors.pair_sigma
    return gain_of_common_errors(
        account.measurements, owners, account.adjusted.residuals, noise=account.noise, common=common
    )


def _strain(account: Account, pose_prior: PosePrior) -> float:
    """Tell how unlikely it is that poses are so far off: as was believed before the pings were asked [nats]."""
    return 0.5 * float(_pulls(account, pose_prior).sum())


def _pulls(account: Account, pose_prior: PosePrior) -> FloatArray:
    """Squares of the errors of poses, in deviations that were believed before the pings were asked, shape (s, 3)."""
    by_hand = waypoint_prior(account.given, account.settings.pose_errors)
    held = pose_factors(account.odometry() if pose_prior.relative else by_hand, account.poses, 0)
    pulls: FloatArray = (held.weights * held.residuals**2).reshape(-1, 3)
    return pulls
