"""The estimate before anything is estimated: pings, arcs and poses as recorded, and what was marginalised."""

from echoplan.arrays import FloatArray
from echoplan.joint.arcs import find_arcs
from echoplan.joint.estimate import Account, initial_noise
from echoplan.joint.marginal_prior import Memory
from echoplan.joint.optimisation.pose_factors import at_poses, continued
from echoplan.joint.optimisation.sonar_model import expected_sonar, half_aperture_of
from echoplan.joint.settings import AccountSettings
from echoplan.model import Odometry, Rig
from echoplan.preprocessing.measurements import Measurements
from echoplan.preprocessing.servo import AS_RECORDED, turned_by

__all__ = ["initial_estimate"]

# Features this far beyond the reach of the stations may still matter [m].
_AROUND = 0.5


def initial_estimate(
    rig: Rig, measurements: Measurements, given: FloatArray, settings: AccountSettings, memory: Memory | None = None
) -> Account:
    """Start from pings of s stations, from the poses of these as recorded and from what was marginalised."""
    memory = memory or Memory()
    resolution = max(sensor.resolution for sensor in rig.sensors)
    prior = expected_sonar(rig, measurements, memory.model, walk=settings.walk)
    recorded = measurements if memory.servo is None else turned_by(measurements, error=memory.servo, before=AS_RECORDED)
    poses = continued(given, memory.poses)
    measurements = at_poses(recorded, given, poses)
    at_hand = memory.near(measurements.centers, _AROUND + measurements.max_range)
    return Account(
        settings=settings,
        memory=memory,
        resolution=resolution,
        half_aperture=half_aperture_of(rig),
        # A table that says nothing is none.
        rig_odometry=None if rig.odometry == Odometry() else rig.odometry,
        prior=prior,
        recorded=recorded,
        arcs=find_arcs(recorded, resolution=resolution, settings=settings.arcs),
        given=given,
        poses=poses,
        measurements=measurements,
        at_hand=at_hand,
        model=memory.model or prior,
        noise=initial_noise(settings, resolution) if memory.is_empty else memory.noise,
        features=[*at_hand.features, *memory.pending],
        pair_sigma=settings.pose_errors.pair_sigma,
        servo=memory.servo,
        first_servo=memory.servo or AS_RECORDED,
        trusts_specified_odometry=memory.trusts_specified_odometry,
        asks_bearings=memory.servo is not None,
        loudness=memory.loudness,
        independence=memory.independence,
    )
