"""Explaining: from the poses as they are, and from better ones if the pings disagree."""

import copy
from collections.abc import Sequence

from echoplan.arrays import FloatArray
from echoplan.geometry import aligned
from echoplan.mapping.account import Account
from echoplan.mapping.agreement import agreement, agrees, evidence, is_doubtful, is_scattered, is_torn
from echoplan.mapping.drift import VERY_STRONG, adds_up
from echoplan.mapping.memory import Course
from echoplan.mapping.misplacement import elsewhere
from echoplan.mapping.poses import PoseBeliefs, waypoint_beliefs
from echoplan.mapping.settings import PoseMode
from echoplan.mapping.slips import without_slip
from echoplan.mapping.tracking import track

__all__ = ["explained"]

# What the verdict says besides where a step led farther astray than was believed.
_SLIPPED = "; a slip was taken back"

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
    best = _explained(account)
    best.clear()
    best.polish()
    return best


def _explained(account: Account) -> Account:
    mode = account.settings.poses
    if account.memory.course is Course.TRACKED:
        return _tracked(account, account.memory.verdict)
    if mode is PoseMode.CORRECT:
        return _asked(account)
    torn = _glanced(account)
    if torn is not None and (not _is_by_hand(torn) or (agrees(torn) and adds_up(torn.given, torn.poses))):
        return torn
    account.explain()
    return account if mode is PoseMode.TRUST else _reconsidered(account, torn)


def _glanced(account: Account) -> Account | None:
    """Take a first look, and correct the poses if these tear most walls apart."""
    if not account.memory.is_empty:
        return None
    account.glance()
    if account.settings.poses is not PoseMode.AUTO or not is_torn(account):
        return None
    return _tracked(copy.copy(account), "corrected: from the poses as recorded most walls were there twice")


def _asked(account: Account) -> Account:
    """Correct poses, unless all is explained as well from the poses as recorded: then these were right."""
    tracked = _tracked(copy.copy(account), "corrected, as asked for")
    if account.memory.is_empty:
        account.glance()
        if is_torn(account):
            return tracked
    account.explain()
    if evidence(tracked) > evidence(account) + VERY_STRONG or not agrees(account):
        return tracked
    account.verdict = "corrected, as asked for, by nothing: the echoes agree as well from the poses as recorded"
    return account


def _tracked(account: Account, verdict: str) -> Account:
    beliefs = account.odometry()
    track(account, beliefs)
    rested = _rested(account, beliefs)
    steady = _without_slips(rested, beliefs)
    best = _without_misplaced(steady, beliefs)
    best.course, best.verdict = Course.TRACKED, verdict
    if steady is not rested and not verdict.endswith(_SLIPPED):
        best.verdict += _SLIPPED
    return best


def _rested(account: Account, beliefs: PoseBeliefs) -> Account:
    """Settle again as long as that explains more; what is remembered came to rest before."""
    while account.memory.is_empty:
        moved = _settled(account, account.poses, beliefs)
        if moved is account:
            break
        account = moved
    return account


def _without_slips(account: Account, beliefs: PoseBeliefs) -> Account:
    """Take slips back as long as that explains more."""
    while (poses := without_slip(account, beliefs)) is not None:
        moved = _settled(account, poses, beliefs)
        if moved is account:
            break
        account = moved
    return account


def _without_misplaced(account: Account, beliefs: PoseBeliefs) -> Account:
    """Put single stations elsewhere where that explains more."""
    for station in range(max(1, len(account.memory.poses)), len(account.poses)):
        pose = elsewhere(account, beliefs, station)
        if pose is not None:
            poses = account.poses.copy()
            poses[station] = pose
            account = _settled(account, poses, beliefs)
    return account


def _settled(account: Account, poses: FloatArray, beliefs: PoseBeliefs) -> Account:
    """Explain everything from other poses, if that explains more."""
    moved = copy.copy(account)
    moved.poses = poses
    moved.settle(beliefs)
    return moved if evidence(moved) > evidence(account) + VERY_STRONG else account


def _reconsidered(account: Account, tracked: Account | None) -> Account:
    """Keep the poses as they are, or correct them as those of odometry, or as those of way-points set by eye.

    Steps that were followed at first sight, because walls were torn apart, lead to the same place again.
    """
    share = f"{100 * agreement(account):.0f} % of the echoes agree from the poses as recorded"
    account.verdict = f"trusted: {share}"
    if len(account.given) < _FEWEST or not is_doubtful(account):
        return account
    if not _is_by_hand(account) and not agrees(account):
        # Nobody sets so many way-points by hand: the robot added up its steps.
        return _tracked(copy.copy(account), f"corrected: only {share}")
    best = max([account, *_rivals(account, share, tracked)], key=evidence)
    return best if evidence(best) > evidence(account) + VERY_STRONG else account


def _rivals(account: Account, share: str, tracked: Account | None) -> list[Account]:
    """Correct poses as those of odometry; and as those of way-points, unless either way walls hold all together."""
    if account.memory.course is Course.NUDGED:
        return _unless_settled(account, share, [], [account.poses])
    if tracked is None:
        tracked = _tracked(copy.copy(account), f"corrected: {share}, and more of them by the steps of the robot")
    if _is_by_hand(account) and agrees(tracked) and not adds_up(account.given, tracked.poses):
        return [_reset(tracked, share)]
    return _unless_settled(account, share, [tracked] if agrees(tracked) else [], [account.poses, tracked.poses])


def _unless_settled(
    account: Account, share: str, rivals: Sequence[Account], starts: Sequence[FloatArray]
) -> list[Account]:
    """Nudge way-points as well, from starts whence they may come to rest at different places, if nothing holds yet."""
    settled = any(agrees(each) and not is_scattered(each) for each in (account, *rivals))
    if settled or not _is_by_hand(account):
        return list(rivals)
    return [*rivals, *(_nudged(account, share, start) for start in starts)]


def _reset(tracked: Account, share: str) -> Account:
    """Move poses to which steps led to where all way-points say they are, and let each settle about its own.

    Errors that scatter are no errors of steps: somebody set the way-points one by one, and the first one no better.
    """
    moved = copy.copy(tracked)
    moved.poses, moved.features = aligned(tracked.poses, tracked.given), tracked.known
    moved.settle(waypoint_beliefs(tracked.given, tracked.settings.pose_errors))
    moved.verdict, moved.course = f"corrected by a few centimetres: only {share}", Course.NUDGED
    return moved


def _nudged(account: Account, share: str, start: FloatArray) -> Account:
    """Move poses a little."""
    moved = copy.copy(account)
    moved.correct(waypoint_beliefs(account.given, account.settings.pose_errors), start)
    moved.verdict, moved.course = f"corrected by a few centimetres: only {share}", Course.NUDGED
    return moved


def _is_by_hand(account: Account) -> bool:
    """Tell whether somebody may have set the way-points by hand."""
    return len(account.given) <= account.settings.by_hand
