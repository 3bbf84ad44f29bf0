"""Selection of the pose model: fixed, odometry or absolute poses, by their log evidence."""

from dataclasses import replace

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.geometry import aligned
from echoplan.joint.estimate import Estimate
from echoplan.joint.optimisation.odometry_noise import VERY_STRONG, are_quantised, log_odds_absolute_vs_odometry
from echoplan.joint.optimisation.pose_factors import PosePrior, waypoint_prior
from echoplan.joint.pose_correction.annealing import anneal, refine, refine_right_angles
from echoplan.joint.pose_correction.consistency import (
    agrees,
    are_weakly_connected,
    contradicts_odometry,
    has_duplicated_walls,
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

__all__ = ["estimate_map"]

# Log-likelihood ratio of accumulating over independent pose errors above which absolute poses are not tried, since that
# doubles the computing time. A wrong odometry solution makes errors seem to accumulate, too, but by less [nats].
_BEYOND_DOUBT = 8.0 * VERY_STRONG

# Least number of stations that allow a pose to be checked against the others.
_FEWEST = 3


def estimate_map(estimate: Estimate) -> Estimate:
    """Return the estimate of the pose model that is selected for the window; its pose status holds the reason."""
    servo = find_servo(estimate) if estimate.marginal_prior.is_empty else None
    best = _explained(estimate)
    if servo is not None:
        best = _better(best, _explained(estimate.calibrate(servo)))
    return best.reselect_classes().remove_multipath_walls().refine_calibration()


def _explained(estimate: Estimate) -> Estimate:
    """Return the estimate of the best pose model; odometry is kept if it was selected for earlier stations."""
    if estimate.marginal_prior.pose_model is PoseModel.ODOMETRY:
        return _tracked(estimate, estimate.marginal_prior.pose_status)
    return _from_odometry(estimate) if _uses_odometry(estimate) else _from_recorded_poses(estimate)


def _from_recorded_poses(estimate: Estimate) -> Estimate:
    """Use the recorded poses, or correct them if the echoes contradict them, where no odometry noise is specified."""
    initial, drifting = _initialised(estimate)
    if drifting and (not _may_be_waypoints(drifting) or _is_clearly_odometry(initial, drifting)):
        return drifting
    explained = initial.explain()
    return explained if estimate.settings.poses is PoseMode.TRUST else _reconsidered(explained, drifting)


def _uses_odometry(estimate: Estimate) -> bool:
    """Return True if the poses come from odometry.

    They do if the rig specifies odometry noise, or if a correction is requested and they cannot be waypoints.
    """
    if estimate.settings.poses is PoseMode.TRUST:
        return False
    few = estimate.marginal_prior.is_empty and len(estimate.measured_poses) >= _FEWEST and _may_be_waypoints(estimate)
    may_be_by_hand = few or estimate.marginal_prior.pose_model is PoseModel.ABSOLUTE
    return estimate.odometry_noise is not None or (_is_requested(estimate) and not may_be_by_hand)


def _is_requested(estimate: Estimate) -> bool:
    return estimate.settings.poses is PoseMode.CORRECT


def _initialised(estimate: Estimate) -> tuple[Estimate, Estimate | None]:
    """Make a first map from the recorded poses, and an odometry solution if many of its walls are duplicated."""
    if not estimate.marginal_prior.is_empty:
        return estimate, None
    initial = estimate.initialise()
    if estimate.settings.poses is PoseMode.TRUST or not has_duplicated_walls(initial):
        return initial, None
    return initial, _tracked(initial, _status(estimate, PoseReason.DUPLICATED_WALLS))


def _from_odometry(estimate: Estimate) -> Estimate:
    """Return the odometry solution, unless the recorded poses explain the pings as well."""
    tracked, initial = _tracked_with_best_noise(estimate, _status(estimate, PoseReason.ODOMETRY)), estimate
    if estimate.marginal_prior.is_empty:
        initial = estimate.initialise()
        if has_duplicated_walls(initial):
            return tracked
    explained = initial.explain()
    return _better(replace(explained, pose_status=_uncorrected_status(explained)), tracked)


def _tracked_with_best_noise(estimate: Estimate, status: PoseStatus) -> Estimate:
    """Return the odometry solution with the specified noise, or with estimated noise if that is clearly more likely."""
    tracked = _tracked(estimate, status)
    if estimate.odometry_noise is None or (agrees(tracked) and not contradicts_odometry(tracked)):
        return tracked
    loose = _tracked(replace(estimate, trusts_specified_odometry=False), replace(status, exceeds_specification=True))
    # The log evidence omits the normalisation of the pose prior, which is smaller for the wider one.
    wider = float(np.log(loose.odometry().sigmas[1:] / tracked.odometry().sigmas[1:]).sum())
    return loose if _log_evidence(loose) > _log_evidence(tracked) + wider + VERY_STRONG else tracked


def _status(estimate: Estimate, reason: PoseReason, *, ratio: float | None = None) -> PoseStatus:
    """Return the pose status for a reason, with what the user and the rig specify."""
    return PoseStatus(
        reason=reason,
        inlier_ratio=ratio,
        is_requested=_is_requested(estimate),
        is_odometry_specified=estimate.odometry_noise is not None,
    )


def _log_evidence(estimate: Estimate) -> float:
    """Return the log evidence at full weights of the readings, before shared errors were estimated."""
    return log_evidence(estimate) if estimate.log_evidence_without_bias is None else estimate.log_evidence_without_bias


def _better(estimate: Estimate, alternative: Estimate) -> Estimate:
    """Return the alternative if there is very strong evidence for it, else the estimate."""
    return alternative if _log_evidence(alternative) > _log_evidence(estimate) + VERY_STRONG else estimate


def _log_odds_absolute(tracked: Estimate) -> float:
    """Return the log odds of independent pose errors against those of odometry [nats]."""
    return log_odds_absolute_vs_odometry(tracked.measured_poses, tracked.poses)


def _odometry_or_absolute(tracked: Estimate, by_hand: Estimate) -> Estimate:
    """Return absolute poses if the evidence of the echoes for them exceeds that of the pose errors for odometry.

    Poses at round numbers are waypoints, whose errors are no evidence for odometry.
    """
    is_marked = are_quantised(tracked.measured_poses)
    errors = 0.0 if is_marked else -_log_odds_absolute(tracked)
    return by_hand if _log_evidence(by_hand) > _log_evidence(tracked) + max(errors, VERY_STRONG) else tracked


def _tracked(estimate: Estimate, status: PoseStatus) -> Estimate:
    """Return the odometry solution: tracked, refined, without wheel slips and misplaced stations."""
    priors = estimate.odometry()
    rested = _refined_until_converged(track_poses(estimate, priors), priors)
    steady = _without_slips(rested, priors)
    best = _without_misplaced(steady, priors)
    status = replace(status, has_slips=status.has_slips or steady is not rested)
    return replace(best, pose_model=PoseModel.ODOMETRY, pose_status=status)


def _refined_until_converged(estimate: Estimate, priors: PosePrior) -> Estimate:
    """Repeat the refinement while the log evidence grows.

    With marginalised stations it is not repeated, since their landmarks have converged.
    """
    while estimate.marginal_prior.is_empty:
        moved = _refined_if_better(estimate, estimate.poses, priors)
        if moved is estimate:
            break
        estimate = moved
    return estimate


def _without_slips(estimate: Estimate, priors: PosePrior) -> Estimate:
    """Correct wheel slips while the log evidence grows."""
    while (poses := without_wheel_slip(estimate, priors)) is not None:
        moved = _refined_if_better(estimate, poses, priors)
        if moved is estimate:
            break
        estimate = moved
    return estimate


def _without_misplaced(estimate: Estimate, priors: PosePrior) -> Estimate:
    """Relocalise single stations where that increases the log evidence."""
    for station in range(max(1, len(estimate.marginal_prior.poses)), len(estimate.poses)):
        pose = relocalised(estimate, priors, station)
        if pose is not None:
            poses = estimate.poses.copy()
            poses[station] = pose
            estimate = _refined_if_better(estimate, poses, priors)
    return estimate


def _refined_if_better(estimate: Estimate, poses: FloatArray, priors: PosePrior) -> Estimate:
    """Return the estimate refined from other poses if its log evidence is clearly greater."""
    return _better(estimate, refine(replace(estimate, poses=poses), priors))


def _reconsidered(estimate: Estimate, tracked: Estimate | None) -> Estimate:
    """Keep the recorded poses, or select odometry or absolute poses if these have the greater log evidence.

    An odometry solution ``tracked`` that exists because of duplicated walls is reused: tracking again would give the
    same.
    """
    ratio = inlier_ratio(estimate)
    reason = PoseReason.CONSISTENT if estimate.arcs else PoseReason.TOO_FEW_ECHOES
    estimate = replace(estimate, pose_status=PoseStatus(reason=reason, inlier_ratio=ratio))
    if not _is_in_question(estimate):
        return estimate
    alternatives = _alternatives(estimate, ratio, tracked)
    if (
        alternatives
        and _may_be_waypoints(estimate)
        and are_quantised(estimate.measured_poses)
        and is_inconsistent(estimate)
    ):
        # Nobody places a robot exactly on a mark, so inconsistent poses at round numbers are always corrected.
        return max(alternatives, key=_log_evidence)
    best = _better(estimate, max(alternatives, key=_log_evidence, default=estimate))
    if best is estimate and _is_requested(estimate) and estimate.arcs:
        return replace(estimate, pose_status=_uncorrected_status(estimate))
    return best


def _is_in_question(estimate: Estimate) -> bool:
    """Return True if other pose models are to be tried: on request, or if the echoes contradict the poses."""
    return len(estimate.measured_poses) >= _FEWEST and (_is_requested(estimate) or is_inconsistent(estimate))


def _uncorrected_status(estimate: Estimate) -> PoseStatus:
    """Return the status of poses that stay as recorded although other pose models were tried."""
    reason = PoseReason.NO_CORRECTION_NEEDED if agrees(estimate) else PoseReason.NO_BETTER_POSES
    return _status(estimate, reason, ratio=inlier_ratio(estimate))


def _alternatives(estimate: Estimate, ratio: float, tracked: Estimate | None) -> list[Estimate]:
    """Return the odometry solution or, if the poses may be waypoints, the solutions with absolute poses."""
    if estimate.marginal_prior.pose_model is PoseModel.ABSOLUTE:
        return (
            [_restarted(estimate, _alternative_status(estimate, ratio), estimate.poses)]
            if _may_be_waypoints(estimate)
            else []
        )
    tracked = tracked or _tracked(estimate, _alternative_status(estimate, ratio))
    if _may_be_waypoints(estimate) and not _is_clearly_odometry(estimate, tracked):
        by_hand = _set_by_hand(estimate, _alternative_status(estimate, ratio), tracked)
        return [_odometry_or_absolute(tracked, each) for each in by_hand] if _may_be_steps(tracked) else by_hand
    return [tracked]


def _may_be_steps(tracked: Estimate) -> bool:
    """Return True unless the pose errors are clearly independent, which excludes odometry."""
    most = -VERY_STRONG if are_quantised(tracked.measured_poses) else VERY_STRONG
    return _log_odds_absolute(tracked) <= most


def _is_clearly_odometry(estimate: Estimate, tracked: Estimate) -> bool:
    """Return True if only the odometry solution is consistent, and its pose errors clearly accumulate."""
    adds_up = _log_odds_absolute(tracked) < -_BEYOND_DOUBT and not are_quantised(tracked.measured_poses)
    return adds_up and agrees(tracked) and not agrees(estimate)


def _alternative_status(estimate: Estimate, ratio: float) -> PoseStatus:
    """Return the status of poses that explain more than the recorded ones."""
    return _status(estimate, PoseReason.MORE_LIKELY if agrees(estimate) else PoseReason.INCONSISTENT, ratio=ratio)


def _set_by_hand(estimate: Estimate, status: PoseStatus, tracked: Estimate) -> list[Estimate]:
    """Return solutions with absolute poses from several starting poses.

    The start is the odometry solution if it is consistent. Registration of neighbours and annealing from the recorded
    and from the odometry poses follow, unless the recorded poses are consistent and the first solution is already
    better.
    """
    reset = [_reset(tracked, status)] if agrees(tracked) else []
    if agrees(estimate) and any(
        _are_held_together(each) and _log_evidence(each) > _log_evidence(tracked) for each in reset
    ):
        return reset
    # The optimisation may converge to different local minima.
    restarted = [_restarted(estimate, status, start) for start in (estimate.poses, tracked.poses)]
    # With a marginal prior the order of the stations is fixed.
    placed = [_reset(place(estimate), status)] if estimate.marginal_prior.is_empty else []
    return [*reset, *placed, *restarted]


def _are_held_together(estimate: Estimate) -> bool:
    """Return True if the echoes are consistent and stations share walls with each other."""
    return agrees(estimate) and not are_weakly_connected(estimate)


def _reset(tracked: Estimate, status: PoseStatus) -> Estimate:
    """Return absolute poses that start from an odometry solution, aligned with all recorded poses.

    Errors of waypoints are independent, so the first pose is no better than the others and must not define the frame.
    """
    moved = replace(tracked, poses=aligned(tracked.poses, tracked.measured_poses), features=tracked.known)
    return _refined_absolute(
        refine(moved, waypoint_prior(tracked.measured_poses, tracked.settings.pose_errors)), status
    )


def _restarted(estimate: Estimate, status: PoseStatus, start: FloatArray) -> Estimate:
    """Return absolute poses by annealing from the given poses, shape (s, 3) [m, m, rad]."""
    priors = waypoint_prior(estimate.measured_poses, estimate.settings.pose_errors)
    return _refined_absolute(anneal(estimate, priors, start), status)


def _refined_absolute(estimate: Estimate, status: PoseStatus) -> Estimate:
    """Refine absolute poses with shared errors of stations and with right angles.

    The log evidence is computed before that, while readings have their full weights.
    """
    estimate = replace(estimate, pose_status=status, pose_model=PoseModel.ABSOLUTE)
    estimate = without_shared_bias(estimate, waypoint_prior(estimate.measured_poses, estimate.settings.pose_errors))
    estimate = replace(estimate, log_evidence_without_bias=log_evidence(estimate))
    estimate = estimate_shared_bias(estimate, with_estimated_waypoint_noise(estimate))
    estimate = refine_right_angles(estimate, with_estimated_waypoint_noise(estimate))
    if estimate.is_along_axes:
        estimate = estimate.alternate(estimate.noise, with_estimated_waypoint_noise(estimate), 2)
    return estimate


def _may_be_waypoints(estimate: Estimate) -> bool:
    """Return True if there are few enough stations for the poses to be waypoints."""
    return len(estimate.measured_poses) <= estimate.settings.max_waypoints
