"""Slips: steps that led farther astray than anybody believed, told by what seems there twice: before and after."""

from collections.abc import Sequence

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.geometry import compose, invert
from echoplan.joint.estimate import Estimate
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.optimisation.pose_factors import PosePrior, dead_reckoned
from echoplan.joint.pose_correction.pose_tracking import local_scans_of
from echoplan.joint.search.duplicates import DuplicateSettings, are_duplicates
from echoplan.joint.search.scan_matching import LandmarkMap, LocalisationSettings, LocalScan, locate

__all__ = ["without_wheel_slip"]

# Twins are turned against each other by less, and their ends lie no farther apart [rad, m].
_TURN, _APART = 0.3, 1.0
# Radii of one cylinder seen from two sides differ by less [m].
_RADII = 0.06
# A turn that is off puts what is so far away off to the side [m].
_LEVER = 1.0
# This share of what is said of a feature is said from one side of the step.
_MOSTLY = 0.8
# Where the stations are now, as well as their own arcs tell [m, m, rad].
_HERE = np.array([0.005, 0.005, 0.01])


def without_wheel_slip(estimate: Estimate, priors: PosePrior) -> FloatArray | None:
    """Take back the slip that puts most of what was heard after it where it had been heard before.

    The stations after a step are one rigid body, looked for in what those before it know.

    Parameters
    ----------
    estimate : Estimate
        What was heard, and what is made of it.
    priors : PosePrior
        Odometry.

    Returns
    -------
    ndarray, shape (s, 3), or None
        Other poses [m, m, rad]; nothing if nothing seems there twice, or nothing fits better elsewhere.
    """
    first = max(1, len(estimate.marginal_prior.poses))
    reaches = _reaches(priors, estimate.settings.localisation)
    steps = [step for step in range(first, len(estimate.poses)) if _has_twins(estimate.features, step, reaches[step])]
    if not steps:
        return None
    sights = local_scans_of(estimate)
    gain, poses = max((_taken_back(estimate, priors, sights, step) for step in steps), key=lambda each: each[0])
    return poses if gain > 0.0 else None


def _taken_back(
    estimate: Estimate, priors: PosePrior, sights: Sequence[LocalScan], step: int
) -> tuple[float, FloatArray]:
    """Move all stations after a step to where they fit best, and tell how much better they fit there [nats]."""
    poses, settings = estimate.poses, estimate.settings.localisation
    known, sight = _known(estimate.features, step), _together(sights[step:], poses[step:])
    guess, sigmas = dead_reckoned(priors.measured_poses, poses, step), settings.astray * priors.reaches[step]
    _, here = locate(sight, known, poses[step], _HERE, settings)
    found, there = locate(sight, known, guess, sigmas, settings)
    return there - here, np.concatenate([poses[:step], compose(compose(found, invert(poses[step])), poses[step:])])


def _together(sights: Sequence[LocalScan], poses: FloatArray) -> LocalScan:
    """See with the arcs of several stations as if all had been heard from the first of them."""
    origins, normals = [], []
    for sight, pose in zip(sights, compose(invert(poses[0]), poses), strict=True):
        turned = np.exp(1j * pose[2]) * (sight.origins_xy[:, 0] + 1j * sight.origins_xy[:, 1])
        origins.append(np.column_stack([pose[0] + turned.real, pose[1] + turned.imag]))
        normals.append(sight.normals + pose[2])
    return LocalScan(
        np.concatenate(origins),
        np.concatenate(normals),
        np.concatenate([each.depths for each in sights]),
        np.concatenate([each.weights for each in sights]),
    )


def _known(features: Sequence[Hypothesis], step: int) -> LandmarkMap:
    """List what stations before a step heard, walls as long as they may be if their twins are the same."""
    known = LandmarkMap.of([each for each in features if _before(each, step) > 0.0])
    return known._replace(extents=known.extents + np.array([-_APART, _APART]))


def _reaches(priors: PosePrior, settings: LocalisationSettings) -> FloatArray:
    """Tell how far each step may put one twin from the other [m]."""
    astray: FloatArray = priors.sigmas[:, :2].max(axis=1) + _LEVER * priors.sigmas[:, 2]
    return settings.deviations * settings.astray * astray


def _has_twins(features: Sequence[Hypothesis], step: int, reach: float) -> bool:
    """Tell whether one feature was heard before a step, and one much like it after."""
    before = [each for each in features if _before(each, step) > _MOSTLY * _said(each)]
    after = [each for each in features if _before(each, step) < (1.0 - _MOSTLY) * _said(each)]
    return any(_alike(one, other, reach) for one in before for other in after)


def _before(feature: Hypothesis, step: int) -> float:
    return feature.history.total + float(np.maximum(feature.llr_by_station[:step], 0.0).sum())


def _said(feature: Hypothesis) -> float:
    return _before(feature, len(feature.llr_by_station))


def _alike(one: Hypothesis, other: Hypothesis, reach: float) -> bool:
    if one.kind is not other.kind:
        return False
    if one.is_wall:
        return are_duplicates(one, other, DuplicateSettings(turn=_TURN, beside=reach, apart=_APART))
    apart = one.reflector[1:] - other.reflector[1:]
    return bool(np.hypot(apart[0], apart[1]) < reach and abs(apart[2]) < _RADII)
