"""Settling: poses, features and sonar brought to rest together, with right angles where walls stand at such."""

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
    """Explain everything from poses that are nearly right, learn the sonar, and refine all together.

    Parameters
    ----------
    estimate : Estimate
        What was heard, with poses that are nearly right.
    priors : PosePrior
        What is believed of these.
    """
    first, settings = estimate.first_noise, estimate.settings
    estimate = replace(
        estimate, noise=first, measurements=at_poses(estimate.recorded, estimate.measured_poses, estimate.poses)
    )
    estimate = estimate.with_squareness(None).search()
    estimate = replace(estimate, features=_merged(estimate.features, settings.pose_errors.copies))
    if not priors.relative and _rests_on_few(estimate):
        square = roughly_square(estimate.features, settings.squareness, may_lie_along_axes=True)
        estimate = estimate.with_squareness(square)
    estimate = estimate.alternate(first, priors, 3).estimate_figure_of_merit()
    estimate = estimate.alternate(0.75 * first, priors, 2).estimate_noise()
    estimate, learned = _learned(replace(estimate, has_heading_factors=True), priors)
    estimate = estimate.search()
    estimate = estimate.alternate(estimate.noise, learned, 3).prune_and_reclassify()
    estimate = replace(estimate, effective_sample_ratio=estimate.estimate_effective_sample_ratio())
    return refine_right_angles(estimate.alternate(estimate.noise, learned, 2), learned)


def _learned(estimate: Estimate, priors: PosePrior) -> tuple[Estimate, PosePrior]:
    """Learn how far odometry is off, unless the rig tells, from poses corrected with what is believed of it."""
    if estimate.solution is None or not priors.relative or priors.specified:
        return estimate, priors
    estimate = estimate.alternate(estimate.noise, priors, 2)
    assert estimate.solution is not None
    poses = slice(estimate.solution.layout.pose, None)
    information_inflation = estimate.estimate_effective_sample_ratio() / estimate.effective_sample_ratio
    covariance = estimate.solution.covariance[poses, poses]
    return estimate, estimate_odometry_noise(
        priors, estimate.poses, covariance, estimate.settings.drift, information_inflation=information_inflation
    )


def anneal(estimate: Estimate, priors: PosePrior, start: FloatArray) -> Estimate:
    """Start over, move the poses to where the pings agree, and do so again with the sonar that this has taught.

    Parameters
    ----------
    estimate : Estimate
        What was heard.
    priors : PosePrior
        What is believed of the poses.
    start : ndarray, shape (s, 3)
        Where they are moved from [m, m, rad].
    """
    estimate = estimate.restart_servo()
    estimate = replace(estimate, poses=start, measurements=at_poses(estimate.recorded, estimate.measured_poses, start))
    coarse_to_fine = [max(each, estimate.rounding) for each in estimate.settings.pose_errors.noises]
    for noises in (coarse_to_fine, coarse_to_fine[1:]):
        estimate = replace(estimate, features=estimate.known)
        for noise in noises:
            estimate = _agree_on(estimate, noise, priors).estimate_figure_of_merit()
        # Who hears a wall tells which way it lies only once it is known how wide the sonar hears.
        estimate = replace(estimate, has_heading_factors=True)
    estimate = estimate.estimate_noise()
    estimate = _agree_on(estimate, estimate.noise, priors).prune_and_reclassify()
    return estimate.optimise(estimate.noise, priors).rescore(estimate.noise)


def _agree_on(estimate: Estimate, noise: float, priors: PosePrior) -> Estimate:
    estimate = impose_right_angles(replace(estimate, noise=noise).search())
    return estimate.alternate(noise, priors, 6)


def impose_right_angles(estimate: Estimate) -> Estimate:
    """Join walls that poses pulled apart; drop weak ones that stand askew where almost all are at right angles.

    Parameters
    ----------
    estimate : Estimate
        What was heard, and what is made of it.
    """
    settings = estimate.settings.squareness
    estimate = replace(estimate, features=_merged(estimate.features, estimate.settings.copies))
    pose_prior = roughly_square(estimate.features, settings, may_lie_along_axes=_rests_on_few(estimate))
    estimate = estimate.with_squareness(pose_prior)
    if pose_prior is None:
        return estimate
    kept = [each for each in estimate.features if not each.is_wall or each.is_square or each.total > settings.cost]
    return replace(estimate, features=kept)


def _rests_on_few(estimate: Estimate) -> bool:
    return rest_on_few_stations(estimate.features, estimate.settings.search.second_station)


def refine_right_angles(estimate: Estimate, priors: PosePrior | None) -> Estimate:
    """Adjust with walls drawn to right angles, where they stand so by themselves.

    Parameters
    ----------
    estimate : Estimate
        What was heard, and what is made of it, at rest.
    priors : PosePrior or None
        What is believed of the poses; nothing where these are trusted.
    """
    now, pose_prior, settings = estimate.solution, estimate.squareness, estimate.settings.squareness
    by_hand = priors is not None and not priors.relative
    assert now is not None
    found = estimate_right_angles(now.reflectors, now.layout, now.covariance, settings, pose_prior, by_hand=by_hand)
    estimate = estimate.with_squareness(found)
    if found is None and pose_prior is None:
        return estimate
    return estimate.alternate(estimate.noise, priors, 2)


def _merged(features: Sequence[Hypothesis], settings: DuplicateSettings) -> list[Hypothesis]:
    """Keep one of several copies of each wall, and record those that go."""
    kept = without_duplicates(features, settings)
    for each in features:
        if not any(each is other for other in kept):
            record_event(Decision.REMOVED, each, reason=Reason.DUPLICATE)
    return kept
