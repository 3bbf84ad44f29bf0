"""Calibration of the servo before a recording is checked."""

from collections.abc import Sequence

from echoplan.diagnosis.consistency import estimate_of, gathered, sampled
from echoplan.joint.optimisation.odometry_noise import VERY_STRONG
from echoplan.joint.pose_correction.consistency import log_evidence
from echoplan.joint.pose_correction.servo_calibration import find_servo
from echoplan.model import Rig, Sweep
from echoplan.preprocessing.servo import AS_RECORDED, ServoError

__all__ = ["servo_error"]


def servo_error(sweeps: Sequence[Sweep], rig: Rig) -> ServoError:
    """Return gain and offset of the servo if a sample of the recording clearly supports them, as `joint` does."""
    some = sampled(sweeps, rig)
    estimate = gathered(some, rig)
    error = None if estimate is None else find_servo(estimate)
    if error is None:
        return AS_RECORDED
    recorded, calibrated = estimate_of(some, rig), estimate_of(some, rig, servo=error)
    if recorded is None or calibrated is None or log_evidence(calibrated) < log_evidence(recorded) + VERY_STRONG:
        return AS_RECORDED
    return calibrated.servo or error
