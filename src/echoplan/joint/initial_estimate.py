"""Construction of the initial estimate: pings, arcs and poses as recorded, and the prior of marginalised stations."""

import math

from echoplan.acoustics.predicted_echo import EchoModel
from echoplan.arrays import FloatArray
from echoplan.joint.arcs import find_arcs
from echoplan.joint.estimate import Estimate, initial_noise
from echoplan.joint.marginal_prior import MarginalPrior
from echoplan.joint.optimisation.pose_factors import at_poses, continued
from echoplan.joint.optimisation.sonar_model import expected_sonar, half_aperture_of
from echoplan.joint.settings import EstimateSettings
from echoplan.model import Odometry, Rig
from echoplan.preprocessing.measurements import Measurements
from echoplan.preprocessing.servo import AS_RECORDED, turned_by

__all__ = ["initial_estimate"]

# Margin beyond the range of the stations within which landmarks of the marginal prior are used [m].
_AROUND = 0.5


def initial_estimate(
    rig: Rig,
    measurements: Measurements,
    measured_poses: FloatArray,
    settings: EstimateSettings,
    marginal_prior: MarginalPrior | None = None,
) -> Estimate:
    """Return the estimate before any search or optimisation.

    ``measured_poses`` are the recorded poses of the s stations, shape (s, 3) [m, m, rad].
    """
    marginal_prior = marginal_prior or MarginalPrior()
    resolution = max(sensor.resolution for sensor in rig.sensors)
    prior = _sonar(rig, measurements, marginal_prior, settings)
    recorded = (
        measurements
        if marginal_prior.servo is None
        else turned_by(measurements, error=marginal_prior.servo, before=AS_RECORDED)
    )
    poses = continued(measured_poses, marginal_prior.poses)
    measurements = at_poses(recorded, measured_poses, poses)
    active_prior = marginal_prior.near(measurements.centers, _AROUND + measurements.max_range)
    return Estimate(
        settings=settings,
        marginal_prior=marginal_prior,
        resolution=resolution,
        half_aperture=half_aperture_of(rig),
        # An empty table in the rig file specifies nothing.
        rig_odometry=None if rig.odometry == Odometry() else rig.odometry,
        prior=prior,
        recorded=recorded,
        arcs=find_arcs(recorded, resolution=resolution, settings=settings.arcs),
        measured_poses=measured_poses,
        poses=poses,
        measurements=measurements,
        active_prior=active_prior,
        model=marginal_prior.model or prior,
        noise=initial_noise(settings, resolution) if marginal_prior.is_empty else marginal_prior.noise,
        features=[*active_prior.features, *marginal_prior.pending],
        bias_sigma=settings.pose_errors.bias_sigma,
        servo=marginal_prior.servo,
        first_servo=marginal_prior.servo or AS_RECORDED,
        trusts_specified_odometry=marginal_prior.trusts_specified_odometry,
        has_heading_factors=marginal_prior.servo is not None,
        beam_prior=marginal_prior.beam_prior,
        effective_sample_ratio=marginal_prior.effective_sample_ratio,
    )


def _sonar(
    rig: Rig, measurements: Measurements, marginal_prior: MarginalPrior, settings: EstimateSettings
) -> EchoModel:
    """Return the sonar as expected before any ping; without a thermometer, in air as warm as in earlier recordings."""
    expected = expected_sonar(rig, measurements, marginal_prior.model, walk=settings.walk)
    if math.isnan(marginal_prior.range_scale) or not math.isnan(measurements.temperature):
        return expected
    return expected.scaled(marginal_prior.range_scale)
