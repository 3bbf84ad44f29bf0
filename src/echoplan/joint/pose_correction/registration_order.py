"""Registration order: stations that were placed by hand, each registered to those near it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.geometry import wrap
from echoplan.joint.arcs import find_arcs
from echoplan.joint.estimate import Estimate
from echoplan.joint.likelihood_cache import LikelihoodCache
from echoplan.joint.optimisation.odometry_noise import estimate_waypoint_noise
from echoplan.joint.optimisation.pose_factors import PosePrior, PoseSettings, waypoint_prior
from echoplan.joint.pose_correction.pose_tracking import Prediction
from echoplan.preprocessing.measurements import rearranged_stations

__all__ = [
    "rearranged",
    "seen_from_others",
    "spanning_tree_order",
    "waypoint_prediction",
    "with_estimated_waypoint_noise",
]


def rearranged(estimate: Estimate, order: Sequence[int]) -> Estimate:
    """Return the estimate with its stations in another order, at their recorded poses."""
    recorded, measured_poses = rearranged_stations(estimate.recorded, order), estimate.measured_poses[list(order)]
    return replace(
        estimate,
        recorded=recorded,
        measurements=recorded,
        measured_poses=measured_poses,
        poses=measured_poses,
        arcs=find_arcs(recorded, resolution=estimate.resolution, settings=estimate.settings.arcs),
        likelihoods=LikelihoodCache(),
    )


def waypoint_prediction(waypoints: FloatArray, settings: PoseSettings) -> Prediction:
    """Return the prediction of a pose by the waypoints that were registered before it.

    Yaw is known poorly at waypoints, so a single station hardly predicts where the others are relative to it. The more
    stations are registered, the better the rotation of their frame is known. ``waypoints``, shape (s, 3) [m, m, rad],
    are ordered such that each is near one before it and shares landmarks with it, whenever it was recorded.
    """

    def expected(poses: FloatArray, station: int, recognised: Sequence[int]) -> tuple[FloatArray, FloatArray]:
        """Return the pose of a station as waypoints nearby predict it, and how far it may be off."""
        found = list(recognised)
        return seen_from_others(waypoints[station], waypoints[found], poses[found], settings)

    return expected


def with_estimated_waypoint_noise(estimate: Estimate) -> PosePrior:
    """Return the prior of waypoints with standard deviations estimated from the optimised poses.

    They are estimated only after convergence: with unlimited errors waypoints would constrain nothing. If walls are
    along the axes of the map, these determine yaw, and its standard deviation is estimated as well.
    """
    assert estimate.solution is not None
    pose_prior = waypoint_prior(estimate.measured_poses, estimate.settings.pose_errors)
    poses = slice(estimate.solution.layout.pose, None)
    covariance, settings = estimate.solution.covariance[poses, poses], estimate.settings.odometry_noise
    return estimate_waypoint_noise(pose_prior, estimate.poses, covariance, settings, headings=estimate.is_along_axes)


def spanning_tree_order(places_xy: FloatArray) -> list[int]:
    """Return an order of places in which each is the nearest to any before it (Prim 1957), from the middle outwards.

    Places have shape (s, 2) [m].

    Examples
    --------
    >>> spanning_tree_order(np.array([[0.0, 0.0], [5.0, 0.0], [1.0, 0.0], [2.5, 0.0]]))
    [2, 0, 3, 1]
    """
    apart = np.hypot(*(places_xy[:, None] - places_xy[None]).transpose(2, 0, 1))
    order = [int(apart.sum(axis=1).argmin())]
    while len(order) < len(places_xy):
        away = apart[order].min(axis=0)
        away[order] = np.inf
        order.append(int(away.argmin()))
    return order


def seen_from_others(
    waypoint: FloatArray, others_measured: FloatArray, others: FloatArray, settings: PoseSettings
) -> tuple[FloatArray, FloatArray]:
    r"""Return the predicted pose of a waypoint in the frame of registered ones, and its sigmas [m, m, rad].

    The frame is rotated by the most likely angle given positions and headings, of which positions are normal about
    their mean and headings von Mises (Mardia and Jupp 2000). With complex positions, g as recorded and p as registered,
    and headings a and b,

    .. math:: z = \sum_k \frac{\bar g_k p_k}{\sigma_p^2} + \sum_k \frac{e^{i (b_k - a_k)}}{\sigma_a^2},
              \qquad \theta = \arg z, \quad \sigma_\theta = |z|^{-1/2}

    ``waypoint`` is its recorded pose, shape (3,); ``others_measured`` and ``others``, shape (k, 3), are at least one
    other pose as recorded and as registered [m, m, rad].
    """
    recorded, found = others_measured[:, 0] + 1j * others_measured[:, 1], others[:, 0] + 1j * others[:, 1]
    by_places = np.vdot(recorded - recorded.mean(), found - found.mean()) / settings.absolute_xy_sigma**2
    by_headings = np.exp(1j * (others[:, 2] - others_measured[:, 2])).sum() / settings.absolute_yaw_sigma**2
    turn, turn_sigma = float(np.angle(by_places + by_headings)), float(np.abs(by_places + by_headings)) ** -0.5
    arm = complex(waypoint[0], waypoint[1]) - recorded.mean()
    place = found.mean() + arm * np.exp(1j * turn)
    away = np.hypot(settings.absolute_xy_sigma * np.sqrt(1.0 + 1.0 / len(others)), abs(arm) * turn_sigma)
    pose = np.array([place.real, place.imag, wrap(waypoint[2] + turn)])
    return pose, np.array([away, away, np.hypot(settings.absolute_yaw_sigma, turn_sigma)])
