"""Settling: poses, features and sonar brought to rest together, with right angles where walls stand at such."""

from collections.abc import Sequence

from echoplan.arrays import FloatArray
from echoplan.joint.estimate import Account
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.optimisation.manhattan import estimate_right_angles, rest_on_few, roughly_square
from echoplan.joint.optimisation.odometry_noise import estimate_odometry_noise
from echoplan.joint.optimisation.pose_factors import PosePrior, at_poses
from echoplan.joint.search.duplicates import DuplicateSettings, without_duplicates
from echoplan.joint.trace import Decision, Reason, record_event

__all__ = ["converge", "settle", "square_up", "stand_square"]


def settle(account: Account, priors: PosePrior) -> None:
    """Explain everything from poses that are nearly right, learn the sonar, and refine all together.

    Parameters
    ----------
    account : Account
        What was heard, with poses that are nearly right; changed in place.
    priors : PosePrior
        What is believed of these.
    """
    first, settings = account.first_noise, account.settings
    account.noise, account.measurements = first, at_poses(account.recorded, account.given, account.poses)
    account.squareness = None
    account.search()
    account.features = _merged(account.features, settings.pose_errors.copies)
    if not priors.relative and _rests_on_few(account):
        account.squareness = roughly_square(account.features, settings.squareness, may_lie_along_axes=True)
    account.alternate(first, priors, 3)
    account.estimate_figure_of_merit()
    account.alternate(0.75 * first, priors, 2)
    account.estimate_noise()
    account.asks_bearings = True
    learned = _learned(account, priors)
    account.search()
    account.alternate(account.noise, learned, 3)
    account.prune_and_reclassify()
    account.independence = account.found_independence()
    account.alternate(account.noise, learned, 2)
    stand_square(account, learned)


def _learned(account: Account, priors: PosePrior) -> PosePrior:
    """Learn how far odometry is off, unless the rig tells, from poses corrected with what is believed of it."""
    if account.adjusted is None or not priors.relative or priors.specified:
        return priors
    account.alternate(account.noise, priors, 2)
    poses = slice(account.adjusted.layout.pose, None)
    information_inflation = account.found_independence() / account.independence
    covariance = account.adjusted.covariance[poses, poses]
    return estimate_odometry_noise(
        priors, account.poses, covariance, account.settings.drift, information_inflation=information_inflation
    )


def converge(account: Account, priors: PosePrior, start: FloatArray) -> None:
    """Start over, move the poses to where the pings agree, and do so again with the sonar that this has taught.

    Parameters
    ----------
    account : Account
        What was heard; changed in place.
    priors : PosePrior
        What is believed of the poses.
    start : ndarray, shape (s, 3)
        Where they are moved from [m, m, rad].
    """
    account.restart_servo()
    account.poses, account.measurements = start, at_poses(account.recorded, account.given, start)
    coarse_to_fine = [max(each, account.rounding) for each in account.settings.pose_errors.noises]
    for noises in (coarse_to_fine, coarse_to_fine[1:]):
        account.features = account.known
        for noise in noises:
            _agree_on(account, noise, priors)
            account.estimate_figure_of_merit()
        # Who hears a wall tells which way it lies only once it is known how wide the sonar hears.
        account.asks_bearings = True
    account.estimate_noise()
    _agree_on(account, account.noise, priors)
    account.prune_and_reclassify()
    account.adjust(account.noise, priors)
    account.rescore(account.noise)


def _agree_on(account: Account, noise: float, priors: PosePrior) -> None:
    account.noise = noise
    account.search()
    square_up(account)
    account.alternate(noise, priors, 6)


def square_up(account: Account) -> None:
    """Join walls that poses pulled apart; drop weak ones that stand askew where almost all are at right angles.

    Parameters
    ----------
    account : Account
        What was heard, and what is made of it; changed in place.
    """
    settings = account.settings.squareness
    account.features = _merged(account.features, account.settings.copies)
    pose_prior = roughly_square(account.features, settings, may_lie_along_axes=_rests_on_few(account))
    account.squareness = pose_prior
    if pose_prior is not None:
        account.features = [
            each for each in account.features if not each.is_wall or each.is_square or each.total > settings.cost
        ]


def _rests_on_few(account: Account) -> bool:
    return rest_on_few(account.features, account.settings.search.second_station)


def stand_square(account: Account, priors: PosePrior | None) -> None:
    """Adjust with walls drawn to right angles, where they stand so by themselves.

    Parameters
    ----------
    account : Account
        What was heard, and what is made of it, at rest; changed in place.
    priors : PosePrior or None
        What is believed of the poses; nothing where these are trusted.
    """
    now, pose_prior, settings = account.adjusted, account.squareness, account.settings.squareness
    by_hand = priors is not None and not priors.relative
    assert now is not None
    found = estimate_right_angles(now.reflectors, now.layout, now.covariance, settings, pose_prior, by_hand=by_hand)
    account.squareness = found
    if found is not None or pose_prior is not None:
        account.alternate(account.noise, priors, 2)


def _merged(features: Sequence[Hypothesis], settings: DuplicateSettings) -> list[Hypothesis]:
    """Keep one of several copies of each wall, and record those that go."""
    kept = without_duplicates(features, settings)
    for each in features:
        if not any(each is other for other in kept):
            record_event(Decision.REMOVED, each, reason=Reason.DUPLICATE)
    return kept
