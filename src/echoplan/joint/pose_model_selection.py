"""Explaining: from the poses as they are, and from better ones if the pings disagree."""

from dataclasses import replace

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.geometry import aligned
from echoplan.joint.estimate import Account
from echoplan.joint.marginal_prior import Course
from echoplan.joint.optimisation.odometry_noise import VERY_STRONG, are_round, scatter
from echoplan.joint.optimisation.pose_factors import PosePrior, waypoint_prior
from echoplan.joint.pose_correction.annealing import converge, settle, stand_square
from echoplan.joint.pose_correction.consistency import (
    agreement,
    agrees,
    evidence,
    has_duplicated_walls,
    is_inconsistent,
    is_scattered,
    is_strained,
)
from echoplan.joint.pose_correction.pose_tracking import track
from echoplan.joint.pose_correction.random_effects import learn_common_error, without_common_error
from echoplan.joint.pose_correction.registration_order import learned_waypoints, place
from echoplan.joint.pose_correction.relocalisation import relocalised
from echoplan.joint.pose_correction.servo_calibration import find_servo
from echoplan.joint.pose_correction.wheel_slip import without_slip
from echoplan.joint.settings import PoseMode
from echoplan.preprocessing.servo import ServoError

__all__ = ["explained"]

# Why poses are corrected that a first look shows to be wrong.
_TORN = "from the poses as recorded most walls were there twice"
# And what explains them better where few echoes or none contradict each other.
_STEPS, _ELSEWHERE = "the steps of the robot", "way-points a little elsewhere"
# What the verdict says besides where a step led farther astray than was believed.
_SLIPPED = "; a slip was taken back"
# Where all steps did.
_FARTHER = ", and farther than the rig tells"
# And where nothing came of it.
_NOT_NEEDED = "no correction was needed: the echoes fit together as well from the poses as recorded"
# And where even that is not so.
_NO_MORE = ", and other poses explain no more"

# Where errors add up by so much no hand made them: it is not asked what way-points would explain, which takes as long
# again.  Steps that lead astray seem to add up, too, but by less [nats].
_BEYOND_DOUBT = 8.0 * VERY_STRONG

# From fewer stations there is nothing to hold a pose against.
_FEWEST = 3


def explained(account: Account) -> Account:
    """Explain everything at hand.

    Parameters
    ----------
    account : Account
        What was heard.

    Returns
    -------
    Account
        The same, or another one with better poses; its verdict says which and why.
    """
    servo = find_servo(account) if account.memory.is_empty else None
    best = _explained(account) if servo is None else _calibrated(account, servo)
    return best.reselect_classes().clear().refine_calibration()


def _calibrated(account: Account, servo: ServoError) -> Account:
    """Calibrate the servo, if that explains more than that it turns as recorded."""
    return _better(_explained(account), _explained(account.calibrate(servo)))


def _explained(account: Account) -> Account:
    if account.memory.course is Course.TRACKED:
        return _tracked(account, account.memory.verdict)
    return _by_wheels(account) if _follows_wheels(account) else _as_found(account)


def _as_found(account: Account) -> Account:
    """Keep the poses, or correct them if the echoes show that they are wrong; nobody says how they came about."""
    looked, torn = _initialised(account)
    if torn and (not _is_by_hand(torn) or _is_led_for_sure(looked, torn)):
        return torn
    explained = looked.explain()
    return explained if account.settings.poses is PoseMode.TRUST else _reconsidered(explained, torn)


def _follows_wheels(account: Account) -> bool:
    """Tell whether wheels led to these poses: the rig says so, or somebody asks for better ones that no hand set."""
    if account.settings.poses is PoseMode.TRUST:
        return False
    few = account.memory.is_empty and len(account.given) >= _FEWEST and _is_by_hand(account)
    may_be_by_hand = few or account.memory.course is Course.NUDGED
    return account.wheels is not None or (_is_asked(account) and not may_be_by_hand)


def _is_asked(account: Account) -> bool:
    return account.settings.poses is PoseMode.CORRECT


def _initialised(account: Account) -> tuple[Account, Account | None]:
    """Take a first look, and correct the poses if these tear most walls apart."""
    if not account.memory.is_empty:
        return account, None
    looked = account.initialise()
    if account.settings.poses is PoseMode.TRUST or not has_duplicated_walls(looked):
        return looked, None
    return looked, _tracked(looked, f"{_corrected(account)}: {_TORN}")


def _by_wheels(account: Account) -> Account:
    """Correct poses, unless all is explained as well from the poses as recorded: then these were right."""
    tracked, looked = _followed(account, _corrected(account)), account
    if account.memory.is_empty:
        looked = account.initialise()
        if has_duplicated_walls(looked):
            return tracked
    explained = looked.explain()
    return _better(replace(explained, verdict=_in_vain(explained)), tracked)


def _followed(account: Account, why: str) -> Account:
    """Follow the wheels, and farther astray than the rig tells where that holds them back."""
    tracked = _tracked(account, why)
    if account.wheels is None or (agrees(tracked) and not is_strained(tracked)):
        return tracked
    loose = _tracked(replace(account, trusts_specified_odometry=False), f"{why}{_FARTHER}")
    # Who believes in greater errors finds none of them unlikely, and each of them less likely.
    wider = float(np.log(loose.odometry().sigmas[1:] / tracked.odometry().sigmas[1:]).sum())
    return loose if _worth(loose) > _worth(tracked) + wider + VERY_STRONG else tracked


def _corrected(account: Account) -> str:
    """Say that poses were corrected, and who wanted it."""
    if _is_asked(account):
        return "corrected, as asked for"
    return "corrected" if account.wheels is None else "corrected, as the rig tells that steps lead astray"


def _worth(account: Account) -> float:
    """Tell what an explanation is worth where readings count in full."""
    return evidence(account) if account.penalised_llr is None else account.penalised_llr


def _better(account: Account, alternative: Account) -> Account:
    """Prefer a rival for which there is very strong evidence."""
    return alternative if _worth(alternative) > _worth(account) + VERY_STRONG else account


def _led(tracked: Account, by_hand: Account) -> Account:
    """Prefer way-points to steps if the evidence of the echoes for them is more than that of the errors for steps."""
    is_marked = are_round(tracked.given)
    errors = 0.0 if is_marked else -scatter(tracked.given, tracked.poses)
    return by_hand if _worth(by_hand) > _worth(tracked) + max(errors, VERY_STRONG) else tracked


def _tracked(account: Account, verdict: str) -> Account:
    priors = account.odometry()
    rested = _rested(track(account, priors), priors)
    steady = _without_slips(rested, priors)
    best = _without_misplaced(steady, priors)
    slipped = steady is not rested and not verdict.endswith(_SLIPPED)
    return replace(best, course=Course.TRACKED, verdict=verdict + _SLIPPED if slipped else verdict)


def _rested(account: Account, priors: PosePrior) -> Account:
    """Settle again as long as that explains more; what is remembered came to rest before."""
    while account.memory.is_empty:
        moved = _settled(account, account.poses, priors)
        if moved is account:
            break
        account = moved
    return account


def _without_slips(account: Account, priors: PosePrior) -> Account:
    """Take slips back as long as that explains more."""
    while (poses := without_slip(account, priors)) is not None:
        moved = _settled(account, poses, priors)
        if moved is account:
            break
        account = moved
    return account


def _without_misplaced(account: Account, priors: PosePrior) -> Account:
    """Put single stations elsewhere where that explains more."""
    for station in range(max(1, len(account.memory.poses)), len(account.poses)):
        pose = relocalised(account, priors, station)
        if pose is not None:
            poses = account.poses.copy()
            poses[station] = pose
            account = _settled(account, poses, priors)
    return account


def _settled(account: Account, poses: FloatArray, priors: PosePrior) -> Account:
    """Explain everything from other poses, if that explains more."""
    return _better(account, settle(replace(account, poses=poses), priors))


def _reconsidered(account: Account, tracked: Account | None) -> Account:
    """Keep the poses as they are, or correct them as those of odometry, or as those of way-points set by eye.

    Steps that were followed at first sight, because walls were torn apart, lead to the same place again.
    """
    share = _share(account)
    fits = f"{100 * agreement(account):.0f} % of the echoes fit together"
    account = replace(account, verdict=f"used as recorded: {fits if account.arcs else 'too few echoes to check them'}")
    if not _is_in_question(account):
        return account
    alternatives = _alternatives(account, share, tracked)
    if alternatives and _is_by_hand(account) and are_round(account.given) and is_inconsistent(account):
        # Nobody sets a robot down exactly on a mark, so the poses as recorded are not among the rivals.
        return max(alternatives, key=_worth)
    best = _better(account, max(alternatives, key=_worth, default=account))
    if best is account and _is_asked(account) and account.arcs:
        return replace(account, verdict=_in_vain(account))
    return best


def _share(account: Account) -> str:
    return f"{100 * agreement(account):.0f} % of the echoes fit together from the poses as recorded"


def _is_in_question(account: Account) -> bool:
    """Tell whether other poses are to be tried: because somebody asks, or these are doubtful."""
    return len(account.given) >= _FEWEST and (_is_asked(account) or is_inconsistent(account))


def _in_vain(account: Account) -> str:
    """Say why poses stay as they are, though better ones were looked for."""
    if agrees(account):
        return _NOT_NEEDED
    return f"left as recorded: only {_share(account)}{_NO_MORE}"


def _alternatives(account: Account, share: str, tracked: Account | None) -> list[Account]:
    """Correct poses as those of odometry, and as those of way-points that somebody set by hand, unless too many."""
    if account.memory.course is Course.NUDGED:
        return [_restarted(account, _why(account, share, _ELSEWHERE), account.poses)] if _is_by_hand(account) else []
    tracked = tracked or _tracked(account, f"{_corrected(account)}: {_why(account, share, _STEPS)}")
    if _is_by_hand(account) and not _is_led_for_sure(account, tracked):
        return _steps_or_hand(account, share, tracked)
    return [tracked]


def _steps_or_hand(account: Account, share: str, tracked: Account) -> list[Account]:
    """Move the poses to those of way-points, where steps did not lead to what explains more."""
    by_hand = _set_by_hand(account, _why(account, share, _ELSEWHERE), tracked)
    return [_led(tracked, each) for each in by_hand] if _may_be_steps(tracked) else by_hand


def _may_be_steps(tracked: Account) -> bool:
    """Tell whether steps may be what was wrong: errors that scatter are none of steps."""
    most = -VERY_STRONG if are_round(tracked.given) else VERY_STRONG
    return scatter(tracked.given, tracked.poses) <= most


def _is_led_for_sure(account: Account, tracked: Account) -> bool:
    """Tell whether pings agree from where steps lead only, and errors add up so clearly that no hand made them."""
    adds_up = scatter(tracked.given, tracked.poses) < -_BEYOND_DOUBT and not are_round(tracked.given)
    return adds_up and agrees(tracked) and not agrees(account)


def _why(account: Account, share: str, instead: str) -> str:
    """Say why other poses are better than those as recorded."""
    return f"{share}, but {instead} explain them better" if agrees(account) else f"only {share}"


def _set_by_hand(account: Account, why: str, tracked: Account) -> list[Account]:
    """Correct poses as those of way-points, from where steps led if pings agree there, or else from more starts."""
    led = [_reset(tracked, why)] if agrees(tracked) else []
    if agrees(account) and any(_are_held_together(each) and _worth(each) > _worth(tracked) for each in led):
        return led
    # From different starts they may come to rest at different places.
    restarted = [_restarted(account, why, start) for start in (account.poses, tracked.poses)]
    # Stations that remember others are known by their numbers: these cannot come in another order.
    placed = [_placed(account, why)] if account.memory.is_empty else []
    return [*led, *placed, *restarted]


def _are_held_together(account: Account) -> bool:
    """Tell whether pings agree and stations heard walls of each other."""
    return agrees(account) and not is_scattered(account)


def _placed(account: Account, why: str) -> Account:
    """Place the stations one after the other, each against what those near to it know."""
    return _reset(place(account), why)


def _reset(tracked: Account, why: str) -> Account:
    """Move poses to which steps led to where all way-points say they are, and let each settle about its own.

    If somebody set the way-points one by one, errors do not add up, and the first one is no better than the others.
    """
    moved = replace(tracked, poses=aligned(tracked.poses, tracked.given), features=tracked.known)
    return _at_rest(settle(moved, waypoint_prior(tracked.given, tracked.settings.pose_errors)), why)


def _restarted(account: Account, why: str, start: FloatArray) -> Account:
    """Move poses a little."""
    priors = waypoint_prior(account.given, account.settings.pose_errors)
    return _at_rest(converge(account, priors, start), why)


def _at_rest(account: Account, why: str) -> Account:
    """Let way-points come to rest with the errors that stations have in common, and with right angles.

    What that is worth is told before, while readings count in full.
    """
    wanted = ", as asked for" if _is_asked(account) else ""
    account = replace(account, verdict=f"corrected by a few centimetres{wanted}: {why}", course=Course.NUDGED)
    account = without_common_error(account, waypoint_prior(account.given, account.settings.pose_errors))
    account = replace(account, penalised_llr=evidence(account))
    account = learn_common_error(account, learned_waypoints(account))
    account = stand_square(account, learned_waypoints(account))
    if account.is_along_axes:
        account = account.alternate(account.noise, learned_waypoints(account), 2)
    return account


def _is_by_hand(account: Account) -> bool:
    """Tell whether somebody may have set the way-points by hand."""
    return len(account.given) <= account.settings.by_hand
