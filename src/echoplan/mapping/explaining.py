"""Explaining: from the poses as they are, and from better ones if the pings disagree."""

import copy

import numpy as np

from echoplan.geometry import wrap
from echoplan.mapping.account import Account
from echoplan.mapping.agreement import agreement, agrees, evidence, is_doubtful, is_torn
from echoplan.mapping.memory import Course
from echoplan.mapping.poses import waypoint_beliefs
from echoplan.mapping.settings import PoseMode
from echoplan.mapping.tracking import track

__all__ = ["explained"]

# From this logarithm of a ratio of likelihoods on evidence is very strong [nats] (Kass and Raftery 1995).
_VERY_STRONG = 5.0

# From fewer stations there is nothing to hold a pose against.
_FEWEST = 3


def explained(account: Account) -> Account:
    """Explain everything at hand.

    Parameters
    ----------
    account : Account
        What was heard; changed in place.

    Returns
    -------
    Account
        The same, or another one with better poses; its verdict says which and why.
    """
    mode = account.settings.poses
    if account.memory.course is Course.TRACKED:
        return _tracked(account, account.memory.verdict)
    if mode is PoseMode.CORRECT:
        return _asked(account)
    if account.memory.is_empty:
        account.glance()
        if mode is PoseMode.AUTO and is_torn(account):
            return _tracked(account, "corrected: from the poses as recorded most walls were there twice")
    account.explain()
    return account if mode is PoseMode.TRUST else _reconsidered(account)


def _asked(account: Account) -> Account:
    """Correct poses, unless the same features explain as much from the poses as recorded: then these were right."""
    tracked = _tracked(copy.copy(account), "corrected, as asked for")
    still = copy.copy(tracked)
    still.stay(account.poses)
    if evidence(tracked) > evidence(still) + _VERY_STRONG or not agrees(still):
        return tracked
    if account.memory.is_empty:
        account.glance()
    account.explain()
    account.verdict = "corrected, as asked for, by nothing: the echoes agree as well from the poses as recorded"
    return account


def _tracked(account: Account, verdict: str) -> Account:
    track(account, account.odometry())
    account.course, account.verdict = Course.TRACKED, verdict
    return account


def _reconsidered(account: Account) -> Account:
    """Keep the poses as they are, or correct them as those of odometry, or as those of way-points set by eye."""
    share = f"{100 * agreement(account):.0f} % of the echoes agree from the poses as recorded"
    account.verdict = f"trusted: {share}"
    if len(account.given) < _FEWEST or not is_doubtful(account):
        return account
    if len(account.given) > account.settings.by_hand and not agrees(account):
        # Nobody sets so many way-points by hand: the robot added up its steps.
        return _tracked(copy.copy(account), f"corrected: only {share}")
    stepping = None if account.memory.course is Course.NUDGED else _stepping(account, share)
    return stepping or (account if agrees(account) else _nudged(account, share))


def _stepping(account: Account, share: str) -> Account | None:
    """Correct poses as those of odometry, if that explains so much more that it pays."""
    tracked = _tracked(copy.copy(account), f"corrected: {share}, and more of them by the steps of the robot")
    pays = evidence(tracked) > evidence(account) + _VERY_STRONG
    return tracked if pays and agrees(tracked) else None


def _nudged(account: Account, share: str) -> Account:
    """Move poses a little if the pings want the headings otherwise.

    Headings that were measured stay where they are, and then what disagrees is no matter of poses.
    """
    moved = copy.copy(account)
    moved.correct(waypoint_beliefs(account.given, account.settings.pose_errors))
    turned = float(np.abs(wrap(moved.poses[:, 2] - account.given[:, 2])).mean())
    moved.verdict, moved.course = f"corrected by a few centimetres: only {share}", Course.NUDGED
    account.verdict = f"trusted: {share}, but their headings hardly move"
    return moved if turned > account.settings.turned else account
