"""Calibration of the sonar and the servo, with uncertainties, as reported with the map."""

import math
from dataclasses import asdict

import numpy as np

from echoplan.acoustics import Air
from echoplan.joint.estimate import Estimate
from echoplan.joint.optimisation.solution import Solution
from echoplan.joint.pose_correction.consistency import inlier_ratio

__all__ = ["calibration"]


def calibration(estimate: Estimate, solution: Solution) -> dict[str, object]:
    """Return the calibration with standard deviations, those of the priors, and the status of the poses.

    Values are in SI units and keyed by parameter; ``prior_sigma`` is the standard deviation of the prior. The figure of
    merit [dB] and ka of the beam (or the half angle of the ray cone [rad]), the noise [m], the inlier ratio and the
    pose status have keys of their own. ``solution`` is that of all readings so far, including marginalised ones.
    """
    sigmas, model, settings = solution.sonar_sigmas(), solution.model, estimate.settings.optimiser
    priors = estimate.priors(estimate.noise, estimate.pose_prior)
    sigmas["range_scale"] = solution.considered_sigma("range_scale", "walk_exponent", settings.walk_exponent_sigma)
    if estimate.has_odometry_model:
        # With an odometry model, the range scale is a consider parameter: it keeps its prior.
        sigmas["range_scale"] = priors.scale_sigma
    open_lag = _open_lag(estimate)
    sigmas["servo_latency"] = math.hypot(sigmas["servo_latency"], open_lag)
    numbers = {
        "range_offset": (model.range_offset, priors.offset_sigma),
        "walk_gain": (model.walk_gain, settings.walk_gain_sigma * priors.walk_gain),
        "range_scale": (model.range_scale, priors.scale_sigma),
        "servo_latency": (solution.latency - open_lag, settings.latency_sigma),
        "servo_gain": (solution.servo.gain, settings.servo_gain_sigma),
        "servo_offset": (solution.servo.offset, settings.servo_offset_sigma),
    }
    silent = [] if estimate.has_servo else ["servo_latency"]
    if estimate.servo is None:
        silent += ["servo_gain", "servo_offset"]
    if model.cone:
        silent.append("walk_gain")
    learned = {
        name: {"value": value, "sigma": sigmas[name], "prior_sigma": prior_sigma}
        for name, (value, prior_sigma) in numbers.items()
        if name not in silent
    }
    if not math.isnan(estimate.recorded.temperature):
        learned["range_scale"]["temperature"] = estimate.recorded.temperature
    beam = {"cone": model.cone} if model.cone else {"figure_of_merit": model.figure_of_merit, "ka": model.ka}
    poses = {"model": estimate.pose_model, **asdict(estimate.pose_status)}
    return {**learned, **beam, "noise": estimate.noise, "inlier_ratio": inlier_ratio(estimate), "poses": poses}


def _open_lag(estimate: Estimate) -> float:
    """Return half the median one-way travel time of the echoes [s].

    The model assumes that the servo turns while sound travels. A servo that waits for each echo therefore appears late
    by the one-way travel time. Which of both applies is unknown, so half of it is the correction and the standard
    deviation.
    """
    readings = estimate.recorded.readings
    detected = readings[np.isfinite(readings)]
    return 0.5 * float(np.median(detected)) / Air().speed_of_sound if len(detected) else 0.0
