"""Annealing: joint optimisation of poses, landmarks and calibration from a large to the estimated noise."""

from collections.abc import Sequence
from dataclasses import replace

from echoplan.arrays import FloatArray
from echoplan.joint.estimate import Estimate
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.optimisation.manhattan import estimate_right_angles, rest_on_few_stations, roughly_square
from echoplan.joint.optimisation.odometry_noise import estimate_odometry_noise
from echoplan.joint.optimisation.pose_factors import PosePrior, at_poses
from echoplan.joint.search.duplicates import DuplicateSettings, without_duplicates
from echoplan.joint.trace import Decision, Reason, record_event

__all__ = ["anneal", "impose_right_angles", "refine", "refine_right_angles"]


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
    estimate, learned = _learned(replace(estimate, has_heading_factors=True), priors)
    estimate = estimate.search()
    estimate = estimate.alternate(estimate.noise, learned, 3).prune_and_reclassify()
    estimate = replace(estimate, effective_sample_ratio=estimate.estimate_effective_sample_ratio())
    return refine_right_angles(estimate.alternate(estimate.noise, learned, 2), learned)


def _learned(estimate: Estimate, priors: PosePrior) -> tuple[Estimate, PosePrior]:
    """Return the estimate and its pose prior with estimated odometry noise; both unchanged if the rig specifies it."""
    if estimate.solution is None or not priors.relative or priors.specified:
        return estimate, priors
    estimate = estimate.alternate(estimate.noise, priors, 2)
    assert estimate.solution is not None
    poses = slice(estimate.solution.layout.pose, None)
    information_inflation = estimate.estimate_effective_sample_ratio() / estimate.effective_sample_ratio
    covariance = estimate.solution.covariance[poses, poses]
    return estimate, estimate_odometry_noise(
        priors,
        estimate.poses,
        covariance,
        estimate.settings.odometry_noise,
        information_inflation=information_inflation,
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
            estimate = _agree_on(estimate, noise, priors).estimate_figure_of_merit()
        # Detections determine directions of walls only once the beam width is estimated.
        estimate = replace(estimate, has_heading_factors=True)
    estimate = estimate.estimate_noise()
    estimate = _agree_on(estimate, estimate.noise, priors).prune_and_reclassify()
    return estimate.optimise(estimate.noise, priors).rescore(estimate.noise)


def _agree_on(estimate: Estimate, noise: float, priors: PosePrior) -> Estimate:
    estimate = impose_right_angles(replace(estimate, noise=noise).search())
    return estimate.alternate(noise, priors, 6)


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


def refine_right_angles(estimate: Estimate, priors: PosePrior | None) -> Estimate:
    """Return the estimate optimised with the Manhattan prior for which its wall directions are evidence, if any.

    A former prior without evidence is removed. ``priors`` is None if the poses are fixed.
    """
    now, manhattan_prior, settings = estimate.solution, estimate.manhattan_prior, estimate.settings.manhattan
    by_hand = priors is not None and not priors.relative
    assert now is not None
    found = estimate_right_angles(
        now.reflectors, now.layout, now.covariance, settings, manhattan_prior, by_hand=by_hand
    )
    estimate = estimate.with_manhattan_prior(found)
    if found is None and manhattan_prior is None:
        return estimate
    return estimate.alternate(estimate.noise, priors, 2)


def _merged(features: Sequence[Hypothesis], settings: DuplicateSettings) -> list[Hypothesis]:
    """Return the features with one of several duplicates of each wall, and record the removal of the others."""
    kept = without_duplicates(features, settings)
    for each in features:
        if not any(each is other for other in kept):
            record_event(Decision.REMOVED, each, reason=Reason.DUPLICATE)
    return kept
