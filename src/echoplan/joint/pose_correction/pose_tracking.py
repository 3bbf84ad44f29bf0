"""Pose tracking: each station is registered to the landmarks that the stations before it determined."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import BoolArray, FloatArray
from echoplan.geometry import compose, directions, invert, wrap
from echoplan.joint.arcs import arc_planes
from echoplan.joint.estimate import Estimate
from echoplan.joint.likelihood.hypothesis import ANYWHERE
from echoplan.joint.likelihood_cache import LikelihoodCache
from echoplan.joint.optimisation.odometry_noise import VERY_STRONG
from echoplan.joint.optimisation.pose_factors import PosePrior, at_poses, continued, dead_reckoned
from echoplan.joint.pose_correction.consistency import pose_pulls
from echoplan.joint.search.scan_matching import LandmarkMap, LocalScan, best_score, local_scans, locate
from echoplan.preprocessing.measurements import first_stations

__all__ = [
    "are_displaced",
    "local_scan_of",
    "local_scans_of",
    "odometry_prediction",
    "register_in_order",
    "up_to_station",
    "with_rest_at",
    "without_greatest_error",
]

# Predicted pose of a station and its standard deviations, from the poses so far and the stations that were registered.
Prediction: TypeAlias = Callable[[FloatArray, int, Sequence[int]], tuple[FloatArray, FloatArray]]

# Weight of an arc that no landmark explains, relative to a landmark.
_LOOSE = 0.5
# Radius of the cylinder that an arc may be [m].
_RADIUS = 0.1
# A station whose registration exceeds this share of the best possible log-likelihood detects nothing new.
_UNDERSTOOD = 0.6
# This many stations or fewer do not determine enough landmarks to register others to them.
_FEW = 4
# Strong evidence [nats] (Kass and Raftery 1995), from which other poses are proposed.
_STRONG = 3.0
# A station that is displaced by no more than this agrees with the others; by more, and its walls are taken for other
# walls [m, rad].
_JOINED = (0.05, math.radians(3.0))


def odometry_prediction(estimate: Estimate, priors: PosePrior) -> Prediction:
    """Return the prediction of poses by odometry, of which ``priors`` are the prior."""
    reaches = priors.reaches

    def expected(poses: FloatArray, station: int, _: Sequence[int]) -> tuple[FloatArray, FloatArray]:
        """Return the pose of a station by odometry, and how far it may be off."""
        return dead_reckoned(estimate.measured_poses, poses, station), reaches[station]

    return expected


def register_in_order(estimate: Estimate, priors: PosePrior, expected: Prediction) -> Estimate:
    """Return the estimate with each station registered to the landmarks of those before it, in order.

    A station is registered near its predicted pose by its arcs, to landmarks and to arcs that no landmark explains.
    Then landmarks and poses of all stations so far are optimised together, unless this station adds little.
    ``expected`` returns the predicted pose and its standard deviations [m, m, rad], from the poses so far and the
    stations that were registered with very strong evidence.
    """
    # The calibration of the initial estimate is discarded, since it is based on wrong poses.
    estimate = replace(
        estimate.with_manhattan_prior(None).restart_servo(),
        model=estimate.marginal_prior.model or estimate.prior,
        solution=None,
        beam_prior=estimate.marginal_prior.beam_prior,
        poses=continued(estimate.measured_poses, estimate.marginal_prior.poses),
        features=estimate.known,
    )
    scans, settings = local_scans_of(estimate), estimate.settings.localisation
    first = max(1, len(estimate.marginal_prior.poses))
    # Landmarks that are known before any search, and arcs.
    part = up_to_station(estimate, first)
    known, recognised = _landmark_map(part.rescore(part.noise)), list(range(first))
    for station in range(first, len(estimate.measured_poses)):
        guess, sigmas = expected(estimate.poses, station, recognised)
        pose, score = locate(scans[station], known, guess, 1.3 * sigmas, settings)
        estimate = replace(
            estimate, poses=np.concatenate([estimate.poses[:station], [pose], estimate.poses[station + 1 :]])
        )
        if score > VERY_STRONG:
            recognised.append(station)
        if score <= _UNDERSTOOD * best_score(scans[station], settings):
            count, noise = station + 1, estimate.settings.pose_errors.tracking_sigma
            steps = priors._replace(measured_poses=priors.measured_poses[:count], sigmas=priors.sigmas[:count])
            part = replace(up_to_station(estimate, count), noise=noise).search(rounds=1)
            part = part.optimise(noise, steps).rescore(noise)
            poses = np.concatenate([part.poses, estimate.poses[station + 1 :]])
            estimate, known = replace(estimate, poses=poses, features=part.features), _landmark_map(part)
    return estimate


def local_scans_of(estimate: Estimate) -> list[LocalScan]:
    """Return the arcs of each station in the frame of the robot."""
    return [local_scan_of(estimate, station) for station in range(len(estimate.measured_poses))]


def local_scan_of(estimate: Estimate, station: int) -> LocalScan:
    """Return the arcs of one station in the frame of the robot."""
    arcs = [each for each in estimate.arcs if each.station == station]
    return local_scans(arcs, estimate.recorded, estimate.model.tabulated(), estimate.measured_poses[station])


def without_greatest_error(estimate: Estimate, priors: PosePrior) -> Estimate | None:
    """Return the estimate with the step of the odometry in place of the least likely step, or None.

    A station that is registered to the wrong landmarks takes all later ones with it. The optimiser cannot leave that
    minimum, so all later stations move together. The result is None unless odometry is strong evidence against a step
    between enough stations on both sides, and with marginalised stations, whose landmarks have converged.
    """
    errors = 0.5 * pose_pulls(estimate, priors)[_FEW + 1 : -_FEW].sum(axis=1)
    if not estimate.marginal_prior.is_empty or errors.max(initial=0.0) < _STRONG:
        return None
    step = _FEW + 1 + int(np.argmax(errors))
    found = dead_reckoned(estimate.measured_poses, estimate.poses, step)
    return replace(estimate, poses=with_rest_at(estimate.poses, step, pose=found), features=estimate.known)


def with_rest_at(poses: FloatArray, station: int, *, pose: FloatArray) -> FloatArray:
    """Return poses with a station at another pose, and all later ones moved with it as one rigid body."""
    after = compose(compose(pose, invert(poses[station])), poses[station:])
    return np.concatenate([poses[:station], after])


def are_displaced(poses: FloatArray, others: FloatArray) -> BoolArray:
    """Return which poses, shape (..., 3), are so far from others that their walls are taken for other walls."""
    off = compose(invert(others), poses)
    displaced: BoolArray = (np.hypot(off[..., 0], off[..., 1]) > _JOINED[0]) | (np.abs(wrap(off[..., 2])) > _JOINED[1])
    return displaced


def up_to_station(estimate: Estimate, count: int) -> Estimate:
    """Return the estimate of the first ``count`` stations, with their poses and all landmarks."""
    recorded = first_stations(estimate.recorded, count)
    measured_poses, poses = estimate.measured_poses[:count], estimate.poses[:count]
    return replace(
        estimate,
        recorded=recorded,
        measured_poses=measured_poses,
        poses=poses,
        measurements=at_poses(recorded, measured_poses, poses),
        arcs=[arc for arc in estimate.arcs if arc.station < count],
        likelihoods=LikelihoodCache(),
    )


def _landmark_map(known: Estimate) -> LandmarkMap:
    """Return the landmarks, and arcs that none of them explains as a wall, a corner and a cylinder each."""
    features, explained = known.features, known.inlier_mask(known.features)
    loose = [arc for arc in known.arcs if arc.share_of(explained) < 0.5]
    sure = LandmarkMap.of(features, known.measurements.centers)
    rows, extents = list(sure.reflectors), list(sure.extents)
    if loose:
        planes = arc_planes(loose, known.measurements, known.model.tabulated())
        for arc, (normal, offset) in zip(loose, planes, strict=True):
            center = known.measurements.centers[arc.station]
            along = float(center @ directions(normal + np.pi / 2))
            depth = offset - float(center @ directions(normal))
            point, behind = (center + away * directions(normal) for away in (depth, depth + _RADIUS))
            rows += [
                np.array([Kind.WALL, normal, offset, 0.0]),
                np.array([Kind.CORNER, *point, 0.0]),
                np.array([Kind.CYLINDER, *behind, _RADIUS]),
            ]
            extents += [(along, along), (0.0, 0.0), (0.0, 0.0)]
    weights = np.concatenate([np.ones(len(features)), np.full(len(rows) - len(features), _LOOSE)])
    fronts = np.concatenate([sure.fronts, np.tile(ANYWHERE, (len(rows) - len(features), 1))])
    return LandmarkMap(np.array(rows).reshape(-1, 4), weights, np.array(extents).reshape(-1, 2), fronts)
