"""Settling: poses, features and sonar brought to rest together, with right angles where walls stand at such."""

from collections.abc import Sequence
from dataclasses import replace

from echoplan.arrays import FloatArray
from echoplan.joint.estimate import Account
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.optimisation.manhattan import estimate_right_angles, rest_on_few, roughly_square
from echoplan.joint.optimisation.odometry_noise import estimate_odometry_noise
from echoplan.joint.optimisation.pose_factors import PosePrior, at_poses
from echoplan.joint.search.duplicates import DuplicateSettings, without_duplicates
from echoplan.joint.trace import Decision, Reason, record_event

__all__ = ["converge", "settle", "square_up", "stand_square"]


def settle(account: Account, priors: PosePrior) -> Account:
    """Explain everything from poses that are nearly right, learn the sonar, and refine all together.

    Parameters
    ----------
    account : Account
        What was heard, with poses that are nearly right.
    priors : PosePrior
        What is believed of these.
    """
    first, settings = account.first_noise, account.settings
    account = replace(account, noise=first, measurements=at_poses(account.recorded, account.given, account.poses))
    account = account.with_squareness(None).search()
    account = replace(account, features=_merged(account.features, settings.pose_errors.copies))
    if not priors.relative and _rests_on_few(account):
        square = roughly_square(account.features, settings.squareness, may_lie_along_axes=True)
        account = account.with_squareness(square)
    account = account.alternate(first, priors, 3).estimate_figure_of_merit()
    account = account.alternate(0.75 * first, priors, 2).estimate_noise()
    account, learned = _learned(replace(account, asks_bearings=True), priors)
    account = account.search()
    account = account.alternate(account.noise, learned, 3).prune_and_reclassify()
    account = replace(account, independence=account.found_independence())
    return stand_square(account.alternate(account.noise, learned, 2), learned)


def _learned(account: Account, priors: PosePrior) -> tuple[Account, PosePrior]:
    """Learn how far odometry is off, unless the rig tells, from poses corrected with what is believed of it."""
    if account.adjusted is None or not priors.relative or priors.specified:
        return account, priors
    account = account.alternate(account.noise, priors, 2)
    assert account.adjusted is not None
    poses = slice(account.adjusted.layout.pose, None)
    information_inflation = account.found_independence() / account.independence
    covariance = account.adjusted.covariance[poses, poses]
    return account, estimate_odometry_noise(
        priors, account.poses, covariance, account.settings.drift, information_inflation=information_inflation
    )


def converge(account: Account, priors: PosePrior, start: FloatArray) -> Account:
    """Start over, move the poses to where the pings agree, and do so again with the sonar that this has taught.

    Parameters
    ----------
    account : Account
        What was heard.
    priors : PosePrior
        What is believed of the poses.
    start : ndarray, shape (s, 3)
        Where they are moved from [m, m, rad].
    """
    account = account.restart_servo()
    account = replace(account, poses=start, measurements=at_poses(account.recorded, account.given, start))
    coarse_to_fine = [max(each, account.rounding) for each in account.settings.pose_errors.noises]
    for noises in (coarse_to_fine, coarse_to_fine[1:]):
        account = replace(account, features=account.known)
        for noise in noises:
            account = _agree_on(account, noise, priors).estimate_figure_of_merit()
        # Who hears a wall tells which way it lies only once it is known how wide the sonar hears.
        account = replace(account, asks_bearings=True)
    account = account.estimate_noise()
    account = _agree_on(account, account.noise, priors).prune_and_reclassify()
    return account.adjust(account.noise, priors).rescore(account.noise)


def _agree_on(account: Account, noise: float, priors: PosePrior) -> Account:
    account = square_up(replace(account, noise=noise).search())
    return account.alternate(noise, priors, 6)


def square_up(account: Account) -> Account:
    """Join walls that poses pulled apart; drop weak ones that stand askew where almost all are at right angles.

    Parameters
    ----------
    account : Account
        What was heard, and what is made of it.
    """
    settings = account.settings.squareness
    account = replace(account, features=_merged(account.features, account.settings.copies))
    pose_prior = roughly_square(account.features, settings, may_lie_along_axes=_rests_on_few(account))
    account = account.with_squareness(pose_prior)
    if pose_prior is None:
        return account
    kept = [each for each in account.features if not each.is_wall or each.is_square or each.total > settings.cost]
    return replace(account, features=kept)


def _rests_on_few(account: Account) -> bool:
    return rest_on_few(account.features, account.settings.search.second_station)


def stand_square(account: Account, priors: PosePrior | None) -> Account:
    """Adjust with walls drawn to right angles, where they stand so by themselves.

    Parameters
    ----------
    account : Account
        What was heard, and what is made of it, at rest.
    priors : PosePrior or None
        What is believed of the poses; nothing where these are trusted.
    """
    now, pose_prior, settings = account.adjusted, account.squareness, account.settings.squareness
    by_hand = priors is not None and not priors.relative
    assert now is not None
    found = estimate_right_angles(now.reflectors, now.layout, now.covariance, settings, pose_prior, by_hand=by_hand)
    account = account.with_squareness(found)
    if found is None and pose_prior is None:
        return account
    return account.alternate(account.noise, priors, 2)


def _merged(features: Sequence[Hypothesis], settings: DuplicateSettings) -> list[Hypothesis]:
    """Keep one of several copies of each wall, and record those that go."""
    kept = without_duplicates(features, settings)
    for each in features:
        if not any(each is other for other in kept):
            record_event(Decision.REMOVED, each, reason=Reason.DUPLICATE)
    return kept
