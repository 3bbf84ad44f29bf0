"""Settling: poses, features and sonar brought to rest together, with right angles where walls stand at such."""

from collections.abc import Sequence

from echoplan.arrays import FloatArray
from echoplan.joint.estimate import Account
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.optimisation.manhattan import learn_squareness, rest_on_few, roughly_square
from echoplan.joint.optimisation.odometry_noise import learn_drift
from echoplan.joint.optimisation.pose_factors import PoseBeliefs, displaced
from echoplan.joint.search.duplicates import CopySettings, without_copies
from echoplan.joint.trace import Decision, Reason, record_event

__all__ = ["converge", "settle", "square_up", "stand_square"]


def settle(account: Account, beliefs: PoseBeliefs) -> None:
    """Explain everything from poses that are nearly right, learn the sonar, and refine all together.

    Parameters
    ----------
    account : Account
        What was heard, with poses that are nearly right; changed in place.
    beliefs : PoseBeliefs
        What is believed of these.
    """
    first, settings = account.first_noise, account.settings
    account.noise, account.soundings = first, displaced(account.recorded, account.given, account.poses)
    account.squareness = None
    account.search()
    account.features = _merged(account.features, settings.pose_errors.copies)
    if not beliefs.relative and _rests_on_few(account):
        account.squareness = roughly_square(account.features, settings.squareness, may_lie_along_axes=True)
    account.adjust_often(first, beliefs, 3)
    account.learn_loudness()
    account.adjust_often(0.75 * first, beliefs, 2)
    account.learn_noise()
    account.asks_bearings = True
    learned = _learned(account, beliefs)
    account.search()
    account.adjust_often(account.noise, learned, 3)
    account.settle_features()
    account.independence = account.found_independence()
    account.adjust_often(account.noise, learned, 2)
    stand_square(account, learned)


def _learned(account: Account, beliefs: PoseBeliefs) -> PoseBeliefs:
    """Learn how far odometry is off, unless the rig tells, from poses corrected with what is believed of it."""
    if account.adjusted is None or not beliefs.relative or beliefs.told:
        return beliefs
    account.adjust_often(account.noise, beliefs, 2)
    poses = slice(account.adjusted.unknowns.pose, None)
    understated = account.found_independence() / account.independence
    covariance = account.adjusted.covariance[poses, poses]
    return learn_drift(beliefs, account.poses, covariance, account.settings.drift, understated=understated)


def converge(account: Account, beliefs: PoseBeliefs, start: FloatArray) -> None:
    """Start over, move the poses to where the pings agree, and do so again with the sonar that this has taught.

    Parameters
    ----------
    account : Account
        What was heard; changed in place.
    beliefs : PoseBeliefs
        What is believed of the poses.
    start : ndarray, shape (s, 3)
        Where they are moved from [m, m, rad].
    """
    account.restart_servo()
    account.poses, account.soundings = start, displaced(account.recorded, account.given, start)
    coarse_to_fine = [max(each, account.rounding) for each in account.settings.pose_errors.noises]
    for noises in (coarse_to_fine, coarse_to_fine[1:]):
        account.features = account.known
        for noise in noises:
            _agree_on(account, noise, beliefs)
            account.learn_loudness()
        # Who hears a wall tells which way it lies only once it is known how wide the sonar hears.
        account.asks_bearings = True
    account.learn_noise()
    _agree_on(account, account.noise, beliefs)
    account.settle_features()
    account.adjust(account.noise, beliefs)
    account.judge(account.noise)


def _agree_on(account: Account, noise: float, beliefs: PoseBeliefs) -> None:
    account.noise = noise
    account.search()
    square_up(account)
    account.adjust_often(noise, beliefs, 6)


def square_up(account: Account) -> None:
    """Join walls that poses pulled apart; drop weak ones that stand askew where almost all are at right angles.

    Parameters
    ----------
    account : Account
        What was heard, and what is made of it; changed in place.
    """
    settings = account.settings.squareness
    account.features = _merged(account.features, account.settings.copies)
    believed = roughly_square(account.features, settings, may_lie_along_axes=_rests_on_few(account))
    account.squareness = believed
    if believed is not None:
        account.features = [
            each for each in account.features if not each.is_wall or each.is_square or each.total > settings.cost
        ]


def _rests_on_few(account: Account) -> bool:
    return rest_on_few(account.features, account.settings.search.second_station)


def stand_square(account: Account, beliefs: PoseBeliefs | None) -> None:
    """Adjust with walls drawn to right angles, where they stand so by themselves.

    Parameters
    ----------
    account : Account
        What was heard, and what is made of it, at rest; changed in place.
    beliefs : PoseBeliefs or None
        What is believed of the poses; nothing where these are trusted.
    """
    now, believed, settings = account.adjusted, account.squareness, account.settings.squareness
    by_hand = beliefs is not None and not beliefs.relative
    assert now is not None
    found = learn_squareness(now.reflectors, now.unknowns, now.covariance, settings, believed, by_hand=by_hand)
    account.squareness = found
    if found is not None or believed is not None:
        account.adjust_often(account.noise, beliefs, 2)


def _merged(features: Sequence[Hypothesis], settings: CopySettings) -> list[Hypothesis]:
    """Keep one of several copies of each wall, and record those that go."""
    kept = without_copies(features, settings)
    for each in features:
        if not any(each is other for other in kept):
            record_event(Decision.REMOVED, each, reason=Reason.DUPLICATE)
    return kept
