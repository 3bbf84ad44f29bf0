"""Selection of the pose model: fixed, odometry or absolute poses, by their log evidence."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import reduce
from typing import TypeAlias

import numpy as np

from echoplan.geometry import aligned
from echoplan.joint.estimate import Estimate
from echoplan.joint.optimisation.odometry_noise import VERY_STRONG, are_quantised, log_odds_absolute_vs_odometry
from echoplan.joint.optimisation.pose_factors import PosePrior, waypoint_prior, waypoint_steps
from echoplan.joint.pose_correction.annealing import anneal, refine, with_best_calibration, with_right_angles
from echoplan.joint.pose_correction.consistency import (
    agrees,
    are_weakly_connected,
    contradicts_odometry,
    has_duplicated_walls,
    inlier_ratio,
    is_inconsistent,
    log_evidence,
)
from echoplan.joint.pose_correction.pose_tracking import (
    are_displaced,
    odometry_prediction,
    register_in_order,
    without_greatest_error,
)
from echoplan.joint.pose_correction.random_effects import estimate_shared_bias
from echoplan.joint.pose_correction.registration_order import (
    rearranged,
    spanning_tree_order,
    waypoint_prediction,
    with_estimated_waypoint_noise,
)
from echoplan.joint.pose_correction.relocalisation import relocalised
from echoplan.joint.pose_correction.servo_calibration import find_servo
from echoplan.joint.pose_correction.wheel_slip import without_wheel_slip
from echoplan.joint.pose_status import PoseModel, PoseReason, PoseStatus
from echoplan.joint.settings import PoseMode

__all__ = ["estimate_map"]

# Proposes an estimate with other poses, or none.
PoseProposal: TypeAlias = Callable[[Estimate, PosePrior], Estimate | None]

# Log-likelihood ratio of accumulating over independent pose errors above which absolute poses are not tried, since that
# doubles the computing time. A wrong odometry solution makes errors seem to accumulate, too, but by less [nats].
_BEYOND_DOUBT = 8.0 * VERY_STRONG

# Iterations of the optimisation without shared errors of stations.
_UNBIASED_ROUNDS = 6

# Least number of stations that allow a pose to be checked against the others.
_FEWEST = 3


def estimate_map(estimate: Estimate) -> Estimate:
    """Return the estimate of the pose model that is selected for the window; its pose status holds the reason."""
    solutions = list[Estimate]()
    for start in _starts(estimate):
        # A map from poses that drift takes as long as tracking them, and is rarely needed.
        first, tracked = start if _may_drift(start) else _first_map(start), None
        if (drifting := _drifting(first)) is not None:
            tracked = _tracked(drifting)
            if _may_exceed_specification(tracked):
                status = replace(drifting.pose_status, exceeds_specification=True)
                loose = replace(drifting, trusts_specified_odometry=False, pose_status=status)
                tracked = _with_likelier_noise(tracked, _tracked(loose))
        found = _explained(first, tracked)
        if _is_in_question(found):
            if tracked is None and found.marginal_prior.pose_model is not PoseModel.ABSOLUTE:
                tracked = _tracked(replace(found, pose_status=_alternative_status(found)))
            found = _most_likely(found, tracked, _absolute_alternatives(found, tracked))
        solutions.append(found)
    best = reduce(_better, solutions)
    return best.reselect_classes().remove_multipath_walls().refine_calibration()


def _starts(estimate: Estimate) -> list[Estimate]:
    """Return the estimate and, if the first window determines the servo, the estimate with a calibrated servo."""
    servo = find_servo(estimate) if estimate.marginal_prior.is_empty else None
    return [estimate] if servo is None else [estimate, estimate.calibrate(servo)]


def _first_map(start: Estimate) -> Estimate:
    """Return the estimate with a first map from the recorded poses, unless it has one of marginalised stations."""
    return start.initialise() if start.marginal_prior.is_empty else start


def _may_drift(start: Estimate) -> bool:
    """Return True if poses come from odometry, or if a correction is requested: it tries odometry in any case."""
    model = start.marginal_prior.pose_model
    is_tried = _is_requested(start) and model is not PoseModel.ABSOLUTE
    return model is PoseModel.ODOMETRY or _uses_odometry(start) or is_tried


def _drifting(first: Estimate) -> Estimate | None:
    """Return the estimate whose poses are tracked first, or None.

    Poses are tracked first if they may come from odometry, or if many walls are duplicated in the first map.
    """
    if first.marginal_prior.pose_model is PoseModel.ODOMETRY:
        return replace(first, pose_status=first.marginal_prior.pose_status)
    if _may_drift(first):
        return replace(first, pose_status=_status(first, PoseReason.ODOMETRY))
    is_checked = first.marginal_prior.is_empty and first.settings.poses is not PoseMode.TRUST
    if is_checked and has_duplicated_walls(first):
        return replace(first, pose_status=_status(first, PoseReason.DUPLICATED_WALLS))
    return None


def _explained(first: Estimate, tracked: Estimate | None) -> Estimate:
    """Return the estimate with the recorded poses, or the odometry solution if that is the better one.

    The recorded poses are not tried if nothing but odometry is possible.
    """
    if tracked is not None and _is_surely_odometry(tracked):
        return tracked
    explained = (_first_map(first) if _may_drift(first) else first).explain()
    if explained.settings.poses is PoseMode.TRUST:
        return explained
    if tracked is not None and _uses_odometry(first):
        return _better(replace(explained, pose_status=_uncorrected_status(explained)), tracked)
    reason = PoseReason.CONSISTENT if explained.arcs else PoseReason.TOO_FEW_ECHOES
    return replace(explained, pose_status=PoseStatus(reason=reason, inlier_ratio=inlier_ratio(explained)))


def _with_likelier_noise(tracked: Estimate, loose: Estimate) -> Estimate:
    """Return the odometry solution with the specified noise, or with estimated noise if that is clearly more likely."""
    # The log evidence omits the normalisation of the pose prior, which is smaller for the wider one.
    wider = float(np.log(loose.odometry().sigmas[1:] / tracked.odometry().sigmas[1:]).sum())
    return loose if _log_evidence(loose) > _log_evidence(tracked) + wider + VERY_STRONG else tracked


def _is_surely_odometry(tracked: Estimate) -> bool:
    """Return True if the recorded poses cannot be better than the odometry solution.

    They cannot if they duplicate walls and are no waypoints. Where a first map was made, it showed the duplicates;
    otherwise they follow from how far the poses were moved.
    """
    if tracked.marginal_prior.pose_model is PoseModel.ODOMETRY:
        return True
    return _moved_walls(tracked) if _uses_odometry(tracked) else not _may_be_waypoints(tracked)


def _moved_walls(tracked: Estimate) -> bool:
    """Return True if the corrected poses explain the echoes, and one is far from where it was recorded.

    Then walls are duplicated in a map from the recorded poses.
    """
    return agrees(tracked) and bool(are_displaced(tracked.poses, tracked.measured_poses).any())


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


def _may_exceed_specification(tracked: Estimate) -> bool:
    """Return True if the odometry noise is specified, no earlier window confirmed it, and poses contradict it."""
    is_specified = tracked.odometry_noise is not None and tracked.marginal_prior.pose_model is not PoseModel.ODOMETRY
    return is_specified and (not agrees(tracked) or contradicts_odometry(tracked))


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


def _odometry_or_absolute(tracked: Estimate, by_hand: Estimate) -> Estimate:
    """Return absolute poses if the evidence of the echoes for them exceeds that of the pose errors for odometry.

    Pose errors that are clearly independent exclude odometry. Poses at round numbers are waypoints, whose errors are no
    evidence for odometry.
    """
    log_odds = log_odds_absolute_vs_odometry(tracked.measured_poses, tracked.poses)
    is_marked = are_quantised(tracked.measured_poses)
    if log_odds > (-VERY_STRONG if is_marked else VERY_STRONG):
        return by_hand
    errors = 0.0 if is_marked else -log_odds
    return by_hand if _log_evidence(by_hand) > _log_evidence(tracked) + max(errors, VERY_STRONG) else tracked


def _most_likely(estimate: Estimate, tracked: Estimate | None, by_hand: Sequence[Estimate]) -> Estimate:
    """Keep the recorded poses, or select odometry or absolute poses if these have the greater log evidence."""
    alternatives = (
        by_hand if tracked is None else [_odometry_or_absolute(tracked, each) for each in by_hand] or [tracked]
    )
    likeliest = max(alternatives, key=_log_evidence, default=estimate)
    # Nobody places a robot exactly on a mark, so inconsistent poses at round numbers are always corrected.
    if _may_be_waypoints(estimate) and are_quantised(estimate.measured_poses) and is_inconsistent(estimate):
        return likeliest
    best = _better(estimate, likeliest)
    if best is estimate and _is_requested(estimate) and estimate.arcs:
        return replace(estimate, pose_status=_uncorrected_status(estimate))
    return best


def _tracked(estimate: Estimate) -> Estimate:
    """Return the odometry solution: tracked, refined, without wrong registrations, wheel slips and misplaced stations.

    Each step is kept if its log evidence is clearly greater.
    """
    priors = estimate.odometry()
    tracked = register_in_order(estimate, priors, odometry_prediction(estimate, priors))
    steady = refine(tracked, priors)
    steady = _improved(steady, priors, propose=without_greatest_error)
    best = _improved(steady, priors, propose=without_wheel_slip)
    status = replace(estimate.pose_status, has_slips=estimate.pose_status.has_slips or best is not steady)
    for station in range(max(1, len(best.marginal_prior.poses)), len(best.poses)):
        if (pose := relocalised(best, priors, station)) is not None:
            poses = best.poses.copy()
            poses[station] = pose
            best = _refined_if_better(best, replace(best, poses=poses), priors=priors)
    return replace(best, pose_model=PoseModel.ODOMETRY, pose_status=status)


def _improved(estimate: Estimate, priors: PosePrior, *, propose: PoseProposal) -> Estimate:
    """Return the estimate refined from proposals, again and again while they are better."""
    while (proposed := propose(estimate, priors)) is not None:
        moved = _refined_if_better(estimate, proposed, priors=priors)
        if moved is estimate:
            break
        estimate = moved
    return estimate


def _refined_if_better(estimate: Estimate, proposed: Estimate, *, priors: PosePrior) -> Estimate:
    """Return the proposal, refined, if its log evidence is clearly greater with the best calibration of both."""
    calibrated, moved = map(with_best_calibration, (estimate, refine(proposed, priors)))
    return estimate if _better(calibrated, moved) is calibrated else moved


def _is_in_question(estimate: Estimate) -> bool:
    """Return True if recorded poses may be corrected as waypoints: on request, or if the echoes contradict them."""
    is_fixed = estimate.pose_model is PoseModel.FIXED and estimate.settings.poses is not PoseMode.TRUST
    if not is_fixed or _uses_odometry(estimate) or len(estimate.measured_poses) < _FEWEST:
        return False
    return _is_requested(estimate) or is_inconsistent(estimate)


def _absolute_alternatives(estimate: Estimate, tracked: Estimate | None) -> list[Estimate]:
    """Return solutions with absolute poses from several starting poses, if the poses may be waypoints.

    The start is the odometry solution if it is consistent. Registration of neighbours and annealing from the recorded
    and from the odometry poses follow, unless the recorded poses are consistent and the first solution is already
    better.
    """
    if not _may_be_waypoints(tracked or estimate):
        return []
    settings, solutions, status = estimate.settings.pose_errors, list[Estimate](), _alternative_status(estimate)
    priors = waypoint_prior(estimate.measured_poses, settings)
    if tracked is not None and agrees(tracked):
        solutions.append(_absolute(refine(_aligned(tracked), priors), status))
        if _is_sufficient(solutions[0], estimate, tracked):
            return solutions
    # With a marginal prior the order of the stations is fixed.
    if estimate.marginal_prior.is_empty:
        order = spanning_tree_order(estimate.measured_poses[:, :2])
        part = rearranged(estimate, order)
        steps = waypoint_steps(part.measured_poses, settings)
        part = refine(register_in_order(part, steps, waypoint_prediction(part.measured_poses, settings)), steps)
        placed = replace(estimate, poses=part.poses[np.argsort(order)])
        solutions.append(_absolute(refine(_aligned(placed), priors), status))
    # The optimisation may converge to different local minima.
    solutions.append(_absolute(anneal(estimate, priors, estimate.poses), status))
    if tracked is not None:
        solutions.append(_absolute(anneal(estimate, priors, tracked.poses), status))
    return solutions


def _is_sufficient(absolute: Estimate, estimate: Estimate, tracked: Estimate) -> bool:
    """Return True if absolute poses are better than odometry, stations share walls, and the recorded poses agree."""
    is_connected = agrees(estimate) and agrees(absolute) and not are_weakly_connected(absolute)
    return is_connected and _log_evidence(absolute) > _log_evidence(tracked)


def _aligned(tracked: Estimate) -> Estimate:
    """Return an odometry solution aligned with all recorded poses, without its landmarks.

    Errors of waypoints are independent, so the first pose is no better than the others and must not define the frame.
    """
    return replace(tracked, poses=aligned(tracked.poses, tracked.measured_poses), features=tracked.known)


def _uncorrected_status(estimate: Estimate) -> PoseStatus:
    """Return the status of poses that stay as recorded although other pose models were tried."""
    reason = PoseReason.NO_CORRECTION_NEEDED if agrees(estimate) else PoseReason.NO_BETTER_POSES
    return _status(estimate, reason, ratio=inlier_ratio(estimate))


def _alternative_status(estimate: Estimate) -> PoseStatus:
    """Return the status of poses that explain more than the recorded ones."""
    reason = PoseReason.MORE_LIKELY if agrees(estimate) else PoseReason.INCONSISTENT
    return _status(estimate, reason, ratio=estimate.pose_status.inlier_ratio)


def _absolute(estimate: Estimate, status: PoseStatus) -> Estimate:
    """Return absolute poses refined with shared errors of stations and with right angles.

    They are first optimised as if readings of a station shared no error but that of rounding. The default of the shared
    error lowers the weights of the readings and leaves poses near their priors, even if echoes fit better elsewhere;
    residuals there would then be taken for shared errors. The log evidence is that with the full weights.
    """
    priors = waypoint_prior(estimate.measured_poses, estimate.settings.pose_errors)
    estimate = replace(estimate, pose_status=status, pose_model=PoseModel.ABSOLUTE, bias_sigma=estimate.offset_sigma)
    estimate = estimate.alternate(estimate.noise, priors, _UNBIASED_ROUNDS).estimate_noise()
    estimate = replace(estimate, log_evidence_without_bias=log_evidence(estimate))
    priors = with_estimated_waypoint_noise(estimate)
    estimate = estimate_shared_bias(estimate, priors)
    estimate = estimate.alternate(estimate.noise, priors, 2)
    priors = with_estimated_waypoint_noise(estimate)
    if (squared := with_right_angles(estimate, priors)) is not estimate:
        estimate = squared.alternate(squared.noise, priors, 2)
    if estimate.is_along_axes:
        estimate = estimate.alternate(estimate.noise, with_estimated_waypoint_noise(estimate), 2)
    return estimate


def _may_be_waypoints(estimate: Estimate) -> bool:
    """Return True if there are few enough stations for the poses to be waypoints.

    They are no waypoints if the odometry solution explains the echoes from other poses, and its pose errors clearly
    accumulate.
    """
    if len(estimate.measured_poses) > estimate.settings.max_waypoints:
        return False
    if estimate.pose_model is not PoseModel.ODOMETRY or are_quantised(estimate.measured_poses):
        return True
    adds_up = log_odds_absolute_vs_odometry(estimate.measured_poses, estimate.poses) < -_BEYOND_DOUBT
    return not (adds_up and _moved_walls(estimate))
