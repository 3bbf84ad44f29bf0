"""Calibration: what a recording told of the sonar that made it."""

import math
from dataclasses import asdict

import numpy as np

from echoplan.acoustics import Air
from echoplan.joint.estimate import Estimate
from echoplan.joint.optimisation.solution import Solution
from echoplan.joint.pose_correction.consistency import inlier_ratio

__all__ = ["calibration"]


def calibration(estimate: Estimate, solution: Solution) -> dict[str, object]:
    """Tell what was learned of the sonar, and how well.

    Parameters
    ----------
    estimate : Estimate
        What was heard, and what is made of it.
    solution : Solution
        An adjustment of all that was ever heard.

    Returns
    -------
    dict
        Values with standard deviations and what was believed before, in SI units; beam, noise, and what was done
        about the poses.
    """
    sigmas, model, settings = solution.sonar_sigmas(), solution.model, estimate.settings.optimiser
    priors = estimate.priors(estimate.noise, estimate.pose_prior)
    sigmas["range_scale"] = solution.considered_sigma("range_scale", "walk_exponent", settings.exponent_sigma)
    if estimate.has_odometry_model:
        # Then it is held at what was believed.
        sigmas["range_scale"] = priors.scale_sigma
    open_lag = _open_lag(estimate)
    sigmas["servo_latency"] = math.hypot(sigmas["servo_latency"], open_lag)
    numbers = {
        "range_offset": (model.range_offset, priors.offset_sigma),
        "walk_gain": (model.walk_gain, settings.gain_share * priors.walk_gain),
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
        name: {"value": value, "sigma": sigmas[name], "believed": prior_sigma}
        for name, (value, prior_sigma) in numbers.items()
        if name not in silent
    }
    if not math.isnan(estimate.recorded.temperature):
        learned["range_scale"]["temperature"] = estimate.recorded.temperature
    beam_prior = {"figure_of_merit": model.figure_of_merit, "ka": model.ka}
    beam = {"cone": model.cone} if model.cone else beam_prior
    poses = {"model": estimate.pose_model, **asdict(estimate.pose_status)}
    return {**learned, **beam, "noise": estimate.noise, "agreement": inlier_ratio(estimate), "poses": poses}


def _open_lag(estimate: Estimate) -> float:
    """Tell half of the lag by which a servo that stands still in each ping would seem to be late [s].

    Sound is heard where the servo has turned to in the meantime.  Nobody tells whether it did: one that waits for the
    echo seems to be late by as long as sound takes one way.
    """
    readings = estimate.recorded.readings
    detected = readings[np.isfinite(readings)]
    return 0.5 * float(np.median(detected)) / Air().speed_of_sound if len(detected) else 0.0
