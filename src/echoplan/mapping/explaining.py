"""Explaining: from the poses as they are, and from better ones if the pings disagree."""

import copy

import numpy as np

from echoplan.geometry import wrap
from echoplan.mapping.account import Account
from echoplan.mapping.memory import Course
from echoplan.mapping.poses import waypoint_beliefs
from echoplan.mapping.settings import PoseMode
from echoplan.mapping.tracking import track

__all__ = ["explained"]

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
    if account.memory.is_empty:
        account.glance()
    else:
        account.explain()
    if mode is PoseMode.CORRECT:
        return _tracked(account, "corrected, as asked for")
    if mode is PoseMode.AUTO and account.is_torn():
        return _tracked(account, "corrected: from the poses as recorded most walls were there twice")
    if account.memory.is_empty:
        account.explain()
    return account if mode is PoseMode.TRUST else _nudged(account)


def _tracked(account: Account, verdict: str) -> Account:
    track(account, account.odometry())
    account.course, account.verdict = Course.TRACKED, verdict
    return account


def _nudged(account: Account) -> Account:
    """Move poses a little if the pings do not agree and want the headings otherwise: way-points are set by eye.

    Headings that were measured stay where they are, and then what disagrees is no matter of poses.
    """
    share = f"{100 * account.agreement():.0f} % of the echoes agree from the poses as recorded"
    account.verdict = f"trusted: {share}"
    if account.agrees() or len(account.given) < _FEWEST:
        return account
    moved = copy.copy(account)
    moved.correct(waypoint_beliefs(account.given, account.settings.pose_errors))
    turned = float(np.abs(wrap(moved.poses[:, 2] - account.given[:, 2])).mean())
    moved.verdict, moved.course = f"corrected by a few centimetres: only {share}", Course.NUDGED
    account.verdict = f"trusted: {share}, but their headings hardly move"
    return moved if turned > account.settings.turned else account
