"""Wheel slip: steps with errors far outside the odometry noise, found by landmarks duplicated before and after them."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.geometry import compose, invert, wrap
from echoplan.joint.estimate import Estimate
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.optimisation.pose_factors import PosePrior, dead_reckoned
from echoplan.joint.pose_correction.pose_tracking import local_scans_of, with_rest_at
from echoplan.joint.search.duplicates import DuplicateSettings, are_duplicates
from echoplan.joint.search.scan_matching import LandmarkMap, LocalScan, locate

__all__ = ["without_wheel_slip"]

# Greatest angle between duplicates, and greatest gap between their ends [rad, m].
_TURN, _APART = 0.3, 1.0
# Greatest difference of the radii of one cylinder as detected from two sides [m].
_RADII = 0.06
# Distance at which a yaw error displaces landmarks sideways [m].
_LEVER = 1.0
# Share of the LLR of a landmark that stations on one side of the step contribute.
_MOSTLY = 0.8
# Standard deviations of the present pose given the arcs of its stations [m, m, rad].
_HERE = np.array([0.005, 0.005, 0.01])


def without_wheel_slip(estimate: Estimate, priors: PosePrior) -> Estimate | None:
    """Return the estimate with poses without the wheel slip that explains most duplicates, or None.

    The stations after a step are registered as one rigid body to the landmarks of those before it. The result is None
    if nothing is duplicated, or if no other place fits better.
    """
    first = max(1, len(estimate.marginal_prior.poses))
    settings = estimate.settings.localisation
    # Greatest distance between duplicates due to the error of each step.
    pose_sigma: FloatArray = priors.sigmas[:, :2].max(axis=1) + _LEVER * priors.sigmas[:, 2]
    reaches = settings.search_sigmas * settings.slip_inflation * pose_sigma
    steps = [step for step in range(first, len(estimate.poses)) if _has_twins(estimate.features, step, reaches[step])]
    if not steps:
        return None
    scans = local_scans_of(estimate)
    gain, poses = max((_taken_back(estimate, priors, scans, step) for step in steps), key=lambda each: each[0])
    return replace(estimate, poses=poses) if gain > 0.0 else None


def _taken_back(
    estimate: Estimate, priors: PosePrior, scans: Sequence[LocalScan], step: int
) -> tuple[float, FloatArray]:
    """Return the gain [nats] and the poses if all stations from a step on move to where they fit best."""
    poses, settings = estimate.poses, estimate.settings.localisation
    known = LandmarkMap.of(
        [each for each in estimate.features if _before(each, step) > 0.0], estimate.measurements.centers
    )
    # Walls are extended by the gap allowed between duplicates.
    known = known._replace(extents=known.extents + np.array([-_APART, _APART]))
    scan = _together(scans[step:], poses[step:])
    guess, sigmas = dead_reckoned(priors.measured_poses, poses, step), settings.slip_inflation * priors.reaches[step]
    _, here = locate(scan, known, poses[step], _HERE, settings)
    found, there = locate(scan, known, guess, sigmas, settings)
    moved = compose(invert(poses[step]), found)
    # Within the uncertainty of the present pose, it is the same place, and nothing slipped.
    is_elsewhere = bool((np.abs([*moved[:2], wrap(moved[2])]) > settings.search_sigmas * _HERE).any())
    return (there - here) * is_elsewhere, with_rest_at(poses, step, pose=found)


def _together(scans: Sequence[LocalScan], poses: FloatArray) -> LocalScan:
    """Return the arcs of several stations in the frame of the first of them."""
    origins, normals = [], []
    for scan, pose in zip(scans, compose(invert(poses[0]), poses), strict=True):
        turned = np.exp(1j * pose[2]) * (scan.origins_xy[:, 0] + 1j * scan.origins_xy[:, 1])
        origins.append(np.column_stack([pose[0] + turned.real, pose[1] + turned.imag]))
        normals.append(scan.normals + pose[2])
    return LocalScan(
        np.concatenate(origins),
        np.concatenate(normals),
        np.concatenate([each.depths for each in scans]),
        np.concatenate([each.weights for each in scans]),
    )


def _has_twins(features: Sequence[Hypothesis], step: int, reach: float) -> bool:
    """Return whether a landmark detected mostly before a step resembles one detected mostly after it."""
    before = [each for each in features if _before(each, step) > _MOSTLY * _llr_of_all(each)]
    after = [each for each in features if _before(each, step) < (1.0 - _MOSTLY) * _llr_of_all(each)]
    return any(_alike(one, other, reach) for one in before for other in after)


def _before(feature: Hypothesis, step: int) -> float:
    """Return the LLR of a landmark from the stations before a step [nats]."""
    return feature.history.llr + float(np.maximum(feature.llr_by_station[:step], 0.0).sum())


def _llr_of_all(feature: Hypothesis) -> float:
    """Return the LLR of a landmark from all stations [nats]."""
    return _before(feature, len(feature.llr_by_station))


def _alike(one: Hypothesis, other: Hypothesis, reach: float) -> bool:
    """Return whether two landmarks may be duplicates at this distance [m]."""
    if one.kind is not other.kind:
        return False
    if one.is_wall:
        return are_duplicates(
            one, other, DuplicateSettings(angle_gate=_TURN, normal_distance_gate=reach, gap_gate=_APART)
        )
    apart = one.reflector[1:] - other.reflector[1:]
    return bool(np.hypot(apart[0], apart[1]) < reach and abs(apart[2]) < _RADII)
