"""Explaining: from the poses as they are, and from better ones if the pings disagree."""

from dataclasses import replace

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.geometry import aligned
from echoplan.joint.estimate import Estimate
from echoplan.joint.optimisation.odometry_noise import VERY_STRONG, are_quantised, scatter
from echoplan.joint.optimisation.pose_factors import PosePrior, waypoint_prior
from echoplan.joint.pose_correction.annealing import anneal, refine, refine_right_angles
from echoplan.joint.pose_correction.consistency import (
    agrees,
    contradicts_odometry,
    has_duplicated_walls,
    has_shared_bias,
    inlier_ratio,
    is_inconsistent,
    log_evidence,
)
from echoplan.joint.pose_correction.pose_tracking import track_poses
from echoplan.joint.pose_correction.random_effects import estimate_shared_bias, without_shared_bias
from echoplan.joint.pose_correction.registration_order import place, with_estimated_waypoint_noise
from echoplan.joint.pose_correction.relocalisation import relocalised
from echoplan.joint.pose_correction.servo_calibration import find_servo
from echoplan.joint.pose_correction.wheel_slip import without_wheel_slip
from echoplan.joint.pose_status import PoseModel, PoseReason, PoseStatus
from echoplan.joint.settings import PoseMode
from echoplan.preprocessing.servo import ServoError

__all__ = ["estimate_map"]

# Where errors add up by so much no hand made them: it is not asked what way-points would explain, which takes as long
# again.  Steps that lead astray seem to add up, too, but by less [nats].
_BEYOND_DOUBT = 8.0 * VERY_STRONG

# From fewer stations there is nothing to hold a pose against.
_FEWEST = 3


def estimate_map(estimate: Estimate) -> Estimate:
    """Explain everything at hand.

    Parameters
    ----------
    estimate : Estimate
        What was heard.

    Returns
    -------
    Estimate
        The same, or another one with better poses; its status says which and why.
    """
    servo = find_servo(estimate) if estimate.marginal_prior.is_empty else None
    best = _explained(estimate) if servo is None else _calibrated(estimate, servo)
    return best.reselect_classes().clear().refine_calibration()


def _calibrated(estimate: Estimate, servo: ServoError) -> Estimate:
    """Calibrate the servo, if that explains more than that it turns as recorded."""
    return _better(_explained(estimate), _explained(estimate.calibrate(servo)))


def _explained(estimate: Estimate) -> Estimate:
    if estimate.marginal_prior.pose_model is PoseModel.ODOMETRY:
        return _tracked(estimate, estimate.marginal_prior.pose_status)
    return _by_wheels(estimate) if _follows_wheels(estimate) else _as_found(estimate)


def _as_found(estimate: Estimate) -> Estimate:
    """Keep the poses, or correct them if the echoes show that they are wrong; nobody says how they came about."""
    looked, torn = _initialised(estimate)
    if torn and (not _is_by_hand(torn) or _is_led_for_sure(looked, torn)):
        return torn
    explained = looked.explain()
    return explained if estimate.settings.poses is PoseMode.TRUST else _reconsidered(explained, torn)


def _follows_wheels(estimate: Estimate) -> bool:
    """Tell whether wheels led to these poses: the rig says so, or somebody asks for better ones that no hand set."""
    if estimate.settings.poses is PoseMode.TRUST:
        return False
    few = estimate.marginal_prior.is_empty and len(estimate.measured_poses) >= _FEWEST and _is_by_hand(estimate)
    may_be_by_hand = few or estimate.marginal_prior.pose_model is PoseModel.ABSOLUTE
    return estimate.odometry_noise is not None or (_is_asked(estimate) and not may_be_by_hand)


def _is_asked(estimate: Estimate) -> bool:
    return estimate.settings.poses is PoseMode.CORRECT


def _initialised(estimate: Estimate) -> tuple[Estimate, Estimate | None]:
    """Take a first look, and correct the poses if these tear most walls apart."""
    if not estimate.marginal_prior.is_empty:
        return estimate, None
    looked = estimate.initialise()
    if estimate.settings.poses is PoseMode.TRUST or not has_duplicated_walls(looked):
        return looked, None
    return looked, _tracked(looked, _corrected(estimate, PoseReason.DUPLICATED_WALLS))


def _by_wheels(estimate: Estimate) -> Estimate:
    """Correct poses, unless all is explained as well from the poses as recorded: then these were right."""
    tracked, looked = _followed(estimate, _corrected(estimate, PoseReason.ODOMETRY)), estimate
    if estimate.marginal_prior.is_empty:
        looked = estimate.initialise()
        if has_duplicated_walls(looked):
            return tracked
    explained = looked.explain()
    return _better(replace(explained, pose_status=_in_vain(explained)), tracked)


def _followed(estimate: Estimate, status: PoseStatus) -> Estimate:
    """Follow the wheels, and farther astray than the rig tells where that holds them back."""
    tracked = _tracked(estimate, status)
    if estimate.odometry_noise is None or (agrees(tracked) and not contradicts_odometry(tracked)):
        return tracked
    loose = _tracked(replace(estimate, trusts_specified_odometry=False), replace(status, exceeds_specification=True))
    # Who believes in greater errors finds none of them unlikely, and each of them less likely.
    wider = float(np.log(loose.odometry().sigmas[1:] / tracked.odometry().sigmas[1:]).sum())
    return loose if _log_evidence(loose) > _log_evidence(tracked) + wider + VERY_STRONG else tracked


def _corrected(estimate: Estimate, reason: PoseReason, *, ratio: float | None = None) -> PoseStatus:
    """Return the status of poses that are corrected, with what was specified of them."""
    return PoseStatus(
        reason=reason,
        inlier_ratio=ratio,
        is_requested=_is_asked(estimate),
        is_odometry_specified=estimate.odometry_noise is not None,
    )


def _log_evidence(estimate: Estimate) -> float:
    """Tell what an explanation is worth where readings count in full."""
    return log_evidence(estimate) if estimate.log_evidence_without_bias is None else estimate.log_evidence_without_bias


def _better(estimate: Estimate, alternative: Estimate) -> Estimate:
    """Prefer a rival for which there is very strong evidence."""
    return alternative if _log_evidence(alternative) > _log_evidence(estimate) + VERY_STRONG else estimate


def _led(tracked: Estimate, by_hand: Estimate) -> Estimate:
    """Prefer way-points to steps if the evidence of the echoes for them is more than that of the errors for steps."""
    is_marked = are_quantised(tracked.measured_poses)
    errors = 0.0 if is_marked else -scatter(tracked.measured_poses, tracked.poses)
    return by_hand if _log_evidence(by_hand) > _log_evidence(tracked) + max(errors, VERY_STRONG) else tracked


def _tracked(estimate: Estimate, status: PoseStatus) -> Estimate:
    priors = estimate.odometry()
    rested = _rested(track_poses(estimate, priors), priors)
    steady = _without_slips(rested, priors)
    best = _without_misplaced(steady, priors)
    status = replace(status, has_slips=status.has_slips or steady is not rested)
    return replace(best, pose_model=PoseModel.ODOMETRY, pose_status=status)


def _rested(estimate: Estimate, priors: PosePrior) -> Estimate:
    """Settle again as long as that explains more; what is remembered came to rest before."""
    while estimate.marginal_prior.is_empty:
        moved = _settled(estimate, estimate.poses, priors)
        if moved is estimate:
            break
        estimate = moved
    return estimate


def _without_slips(estimate: Estimate, priors: PosePrior) -> Estimate:
    """Take slips back as long as that explains more."""
    while (poses := without_wheel_slip(estimate, priors)) is not None:
        moved = _settled(estimate, poses, priors)
        if moved is estimate:
            break
        estimate = moved
    return estimate


def _without_misplaced(estimate: Estimate, priors: PosePrior) -> Estimate:
    """Put single stations elsewhere where that explains more."""
    for station in range(max(1, len(estimate.marginal_prior.poses)), len(estimate.poses)):
        pose = relocalised(estimate, priors, station)
        if pose is not None:
            poses = estimate.poses.copy()
            poses[station] = pose
            estimate = _settled(estimate, poses, priors)
    return estimate


def _settled(estimate: Estimate, poses: FloatArray, priors: PosePrior) -> Estimate:
    """Explain everything from other poses, if that explains more."""
    return _better(estimate, refine(replace(estimate, poses=poses), priors))


def _reconsidered(estimate: Estimate, tracked: Estimate | None) -> Estimate:
    """Keep the poses as they are, or correct them as those of odometry, or as those of way-points set by eye.

    Steps that were followed at first sight, because walls were torn apart, lead to the same place again.
    """
    ratio = inlier_ratio(estimate)
    reason = PoseReason.CONSISTENT if estimate.arcs else PoseReason.TOO_FEW_ECHOES
    estimate = replace(estimate, pose_status=PoseStatus(reason=reason, inlier_ratio=ratio))
    if not _is_in_question(estimate):
        return estimate
    alternatives = _alternatives(estimate, ratio, tracked)
    if alternatives and _is_by_hand(estimate) and are_quantised(estimate.measured_poses) and is_inconsistent(estimate):
        # Nobody sets a robot down exactly on a mark, so the poses as recorded are not among the rivals.
        return max(alternatives, key=_log_evidence)
    best = _better(estimate, max(alternatives, key=_log_evidence, default=estimate))
    if best is estimate and _is_asked(estimate) and estimate.arcs:
        return replace(estimate, pose_status=_in_vain(estimate))
    return best


def _is_in_question(estimate: Estimate) -> bool:
    """Tell whether other poses are to be tried: because somebody asks, or these are doubtful."""
    return len(estimate.measured_poses) >= _FEWEST and (_is_asked(estimate) or is_inconsistent(estimate))


def _in_vain(estimate: Estimate) -> PoseStatus:
    """Return the status of poses that stay as recorded although better ones were looked for."""
    reason = PoseReason.NO_CORRECTION_NEEDED if agrees(estimate) else PoseReason.NO_BETTER_POSES
    return _corrected(estimate, reason, ratio=inlier_ratio(estimate))


def _alternatives(estimate: Estimate, ratio: float, tracked: Estimate | None) -> list[Estimate]:
    """Correct poses as those of odometry, and as those of way-points that somebody set by hand, unless too many."""
    if estimate.marginal_prior.pose_model is PoseModel.ABSOLUTE:
        return [_restarted(estimate, _why(estimate, ratio), estimate.poses)] if _is_by_hand(estimate) else []
    tracked = tracked or _tracked(estimate, _why(estimate, ratio))
    if _is_by_hand(estimate) and not _is_led_for_sure(estimate, tracked):
        return _steps_or_hand(estimate, ratio, tracked)
    return [tracked]


def _steps_or_hand(estimate: Estimate, ratio: float, tracked: Estimate) -> list[Estimate]:
    """Move the poses to those of way-points, where steps did not lead to what explains more."""
    by_hand = _set_by_hand(estimate, _why(estimate, ratio), tracked)
    return [_led(tracked, each) for each in by_hand] if _may_be_steps(tracked) else by_hand


def _may_be_steps(tracked: Estimate) -> bool:
    """Tell whether steps may be what was wrong: errors that scatter are none of steps."""
    most = -VERY_STRONG if are_quantised(tracked.measured_poses) else VERY_STRONG
    return scatter(tracked.measured_poses, tracked.poses) <= most


def _is_led_for_sure(estimate: Estimate, tracked: Estimate) -> bool:
    """Tell whether pings agree from where steps lead only, and errors add up so clearly that no hand made them."""
    adds_up = scatter(tracked.measured_poses, tracked.poses) < -_BEYOND_DOUBT and not are_quantised(
        tracked.measured_poses
    )
    return adds_up and agrees(tracked) and not agrees(estimate)


def _why(estimate: Estimate, ratio: float) -> PoseStatus:
    """Return the status of poses that explain more than those as recorded."""
    return _corrected(estimate, PoseReason.MORE_LIKELY if agrees(estimate) else PoseReason.INCONSISTENT, ratio=ratio)


def _set_by_hand(estimate: Estimate, status: PoseStatus, tracked: Estimate) -> list[Estimate]:
    """Correct poses as those of way-points, from where steps led if pings agree there, or else from more starts."""
    led = [_reset(tracked, status)] if agrees(tracked) else []
    if agrees(estimate) and any(
        _are_held_together(each) and _log_evidence(each) > _log_evidence(tracked) for each in led
    ):
        return led
    # From different starts they may come to rest at different places.
    restarted = [_restarted(estimate, status, start) for start in (estimate.poses, tracked.poses)]
    # Stations that remember others are known by their numbers: these cannot come in another order.
    placed = [_placed(estimate, status)] if estimate.marginal_prior.is_empty else []
    return [*led, *placed, *restarted]


def _are_held_together(estimate: Estimate) -> bool:
    """Tell whether pings agree and stations heard walls of each other."""
    return agrees(estimate) and not has_shared_bias(estimate)


def _placed(estimate: Estimate, status: PoseStatus) -> Estimate:
    """Place the stations one after the other, each against what those near to it know."""
    return _reset(place(estimate), status)


def _reset(tracked: Estimate, status: PoseStatus) -> Estimate:
    """Move poses to which steps led to where all way-points say they are, and let each settle about its own.

    If somebody set the way-points one by one, errors do not add up, and the first one is no better than the others.
    """
    moved = replace(tracked, poses=aligned(tracked.poses, tracked.measured_poses), features=tracked.known)
    return _at_rest(refine(moved, waypoint_prior(tracked.measured_poses, tracked.settings.pose_errors)), status)


def _restarted(estimate: Estimate, status: PoseStatus, start: FloatArray) -> Estimate:
    """Move poses a little."""
    priors = waypoint_prior(estimate.measured_poses, estimate.settings.pose_errors)
    return _at_rest(anneal(estimate, priors, start), status)


def _at_rest(estimate: Estimate, status: PoseStatus) -> Estimate:
    """Let way-points come to rest with the errors that stations have in common, and with right angles.

    What that is worth is told before, while readings count in full.
    """
    estimate = replace(estimate, pose_status=status, pose_model=PoseModel.ABSOLUTE)
    estimate = without_shared_bias(estimate, waypoint_prior(estimate.measured_poses, estimate.settings.pose_errors))
    estimate = replace(estimate, log_evidence_without_bias=log_evidence(estimate))
    estimate = estimate_shared_bias(estimate, with_estimated_waypoint_noise(estimate))
    estimate = refine_right_angles(estimate, with_estimated_waypoint_noise(estimate))
    if estimate.is_along_axes:
        estimate = estimate.alternate(estimate.noise, with_estimated_waypoint_noise(estimate), 2)
    return estimate


def _is_by_hand(estimate: Estimate) -> bool:
    """Tell whether somebody may have set the way-points by hand."""
    return len(estimate.measured_poses) <= estimate.settings.by_hand
