"""Odometry solutions, as the selection of the pose model makes them first."""

from echoplan.joint.estimate import Estimate
from echoplan.joint.optimisation.pose_factors import PosePrior
from echoplan.joint.pose_correction.annealing import refine
from echoplan.joint.pose_correction.pose_tracking import odometry_prediction, register_in_order

__all__ = ["track_poses"]


def track_poses(estimate: Estimate, priors: PosePrior) -> Estimate:
    """Return the estimate with poses corrected station by station, and refined."""
    tracked = register_in_order(estimate, priors, odometry_prediction(estimate, priors))
    return refine(tracked, priors)
