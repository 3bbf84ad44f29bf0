"""Annealing: joint optimisation of poses, landmarks and calibration from a large to the estimated noise."""

from collections.abc import Sequence
from dataclasses import replace

from echoplan.arrays import FloatArray
from echoplan.joint.estimate import Estimate
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.optimisation.manhattan import estimate_right_angles, rest_on_few_stations, roughly_square
from echoplan.joint.optimisation.odometry_noise import estimate_odometry_noise
from echoplan.joint.optimisation.pose_factors import PosePrior, at_poses
from echoplan.joint.pose_correction.consistency import log_evidence
from echoplan.joint.search.duplicates import DuplicateSettings, without_duplicates
from echoplan.joint.trace import Decision, Reason, record_event

__all__ = [
    "anneal",
    "impose_right_angles",
    "refine",
    "with_best_calibration",
    "with_estimated_odometry_noise",
    "with_right_angles",
]

# Most calibrations, and change of the figure of merit below which it has converged [dB]: in a drive through a flat, the
# log evidence from three starts then differed by 2 nats, instead of 75 without further calibration.
_CALIBRATIONS, _CALIBRATED = 4, 0.1


def refine(estimate: Estimate, priors: PosePrior) -> Estimate:
    """Return the estimate after search, calibration and joint optimisation from poses that are nearly right.

    Unless the rig specifies the odometry noise, it is estimated on the way.
    """
    first, settings = estimate.first_noise, estimate.settings
    estimate = replace(
        estimate, noise=first, measurements=at_poses(estimate.recorded, estimate.measured_poses, estimate.poses)
    )
    estimate = estimate.with_manhattan_prior(None).search()
    estimate = replace(estimate, features=_merged(estimate.features, settings.pose_errors.duplicates))
    if not priors.relative and _rests_on_few(estimate):
        manhattan_prior = roughly_square(estimate.features, settings.manhattan, may_lie_along_axes=True)
        estimate = estimate.with_manhattan_prior(manhattan_prior)
    estimate = estimate.alternate(first, priors, 3).estimate_figure_of_merit()
    estimate = estimate.alternate(0.75 * first, priors, 2).estimate_noise()
    estimate = replace(estimate, has_heading_factors=True)
    if priors.relative and not priors.specified and estimate.solution is not None:
        estimate = estimate.alternate(estimate.noise, priors, 2)
        priors = with_estimated_odometry_noise(estimate, priors)
    estimate = estimate.search()
    estimate = estimate.alternate(estimate.noise, priors, 3).prune_and_reclassify()
    estimate = replace(estimate, effective_sample_ratio=estimate.estimate_effective_sample_ratio())
    estimate = estimate.alternate(estimate.noise, priors, 2)
    if (squared := with_right_angles(estimate, priors)) is not estimate:
        estimate = squared.alternate(squared.noise, priors, 2)
    return estimate


def with_best_calibration(estimate: Estimate) -> Estimate:
    """Return the estimate with the most likely one of its next few calibrations, or as it is.

    Figure of merit and beam are estimated by turns. That need not converge, and the log evidence depends strongly on
    them, so estimates are compared with the best calibration of each.
    """
    best = estimate
    for _ in range(_CALIBRATIONS):
        former = estimate.model.figure_of_merit
        estimate = estimate.estimate_figure_of_merit().alternate(estimate.noise, estimate.pose_prior, 3)
        estimate = estimate.estimate_noise()
        estimate = estimate.rescore(estimate.noise)
        best = max(best, estimate, key=log_evidence)
        if abs(estimate.model.figure_of_merit - former) < _CALIBRATED:
            break
    return best


def with_estimated_odometry_noise(estimate: Estimate, priors: PosePrior) -> PosePrior:
    """Return the prior of odometry with standard deviations estimated from the optimised poses."""
    assert estimate.solution is not None
    poses = slice(estimate.solution.layout.pose, None)
    return estimate_odometry_noise(
        priors,
        estimate.poses,
        estimate.solution.covariance[poses, poses],
        estimate.settings.odometry_noise,
        information_inflation=estimate.estimate_effective_sample_ratio() / estimate.effective_sample_ratio,
    )


def anneal(estimate: Estimate, priors: PosePrior, start: FloatArray) -> Estimate:
    """Return the estimate after annealing from the poses ``start``, shape (s, 3) [m, m, rad].

    The search starts anew and runs twice over decreasing noise, the second time with the sonar estimated in the first
    run.
    """
    estimate = estimate.restart_servo()
    estimate = replace(estimate, poses=start, measurements=at_poses(estimate.recorded, estimate.measured_poses, start))
    coarse_to_fine = [max(each, estimate.rounding) for each in estimate.settings.pose_errors.annealing_sigmas]
    for noises in (coarse_to_fine, coarse_to_fine[1:]):
        estimate = replace(estimate, features=estimate.known)
        for noise in noises:
            estimate = impose_right_angles(replace(estimate, noise=noise).search())
            estimate = estimate.alternate(noise, priors, 6).estimate_figure_of_merit()
        # Detections determine directions of walls only once the beam width is estimated.
        estimate = replace(estimate, has_heading_factors=True)
    estimate = impose_right_angles(estimate.estimate_noise().search())
    estimate = estimate.alternate(estimate.noise, priors, 6).prune_and_reclassify()
    return estimate.optimise(estimate.noise, priors).rescore(estimate.noise)


def impose_right_angles(estimate: Estimate) -> Estimate:
    """Return the estimate with duplicate walls merged and, if most walls are square, without weak oblique walls."""
    settings = estimate.settings.manhattan
    estimate = replace(estimate, features=_merged(estimate.features, estimate.settings.duplicates))
    manhattan_prior = roughly_square(estimate.features, settings, may_lie_along_axes=_rests_on_few(estimate))
    estimate = estimate.with_manhattan_prior(manhattan_prior)
    if manhattan_prior is None:
        return estimate
    kept = [
        each
        for each in estimate.features
        if not each.is_wall or each.is_square or each.llr > settings.min_llr_if_oblique
    ]
    return replace(estimate, features=kept)


def _rests_on_few(estimate: Estimate) -> bool:
    """Return whether most walls are supported by no more than two stations."""
    return rest_on_few_stations(estimate.features, estimate.settings.search.min_second_station_llr)


def with_right_angles(estimate: Estimate, priors: PosePrior) -> Estimate:
    """Return the estimate with the Manhattan prior for which its wall directions are evidence, if any.

    A former prior without evidence is removed. The same estimate is returned if it has neither; another one is to be
    optimised anew.
    """
    now, manhattan_prior, settings = estimate.solution, estimate.manhattan_prior, estimate.settings.manhattan
    assert now is not None
    found = estimate_right_angles(
        now.reflectors, now.layout, now.covariance, settings, manhattan_prior, by_hand=not priors.relative
    )
    if found is None and manhattan_prior is None:
        return estimate
    return estimate.with_manhattan_prior(found)


def _merged(features: Sequence[Hypothesis], settings: DuplicateSettings) -> list[Hypothesis]:
    """Return the features with one of several duplicates of each wall, and record the removal of the others."""
    kept = without_duplicates(features, settings)
    for each in features:
        if not any(each is other for other in kept):
            record_event(Decision.REMOVED, each, reason=Reason.DUPLICATE)
    return kept
