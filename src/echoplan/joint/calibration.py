"""Calibration: what a recording told of the sonar that made it."""

import math

import numpy as np

from echoplan.acoustics import Air
from echoplan.joint.estimate import Account
from echoplan.joint.optimisation.solution import Solution
from echoplan.joint.pose_correction.consistency import agreement

__all__ = ["calibration"]


def calibration(account: Account, adjusted: Solution) -> dict[str, object]:
    """Tell what was learned of the sonar, and how well.

    Parameters
    ----------
    account : Account
        What was heard, and what is made of it.
    adjusted : Solution
        An adjustment of all that was ever heard.

    Returns
    -------
    dict
        Values with standard deviations and what was believed before, in SI units; beam, noise, and what was done
        about the poses.
    """
    sigmas, model, settings = adjusted.sonar_sigmas(), adjusted.model, account.settings.adjustment
    priors = account.priors(account.noise, account.pose_prior)
    sigmas["range_scale"] = adjusted.considered_sigma("range_scale", "walk_exponent", settings.exponent_sigma)
    if account.drifts:
        # Then it is held at what was believed.
        sigmas["range_scale"] = priors.scale_sigma
    open_lag = _open_lag(account)
    sigmas["servo_latency"] = math.hypot(sigmas["servo_latency"], open_lag)
    numbers = {
        "range_offset": (model.range_offset, priors.offset_sigma),
        "walk_gain": (model.walk_gain, settings.gain_share * priors.walk_gain),
        "range_scale": (model.range_scale, priors.scale_sigma),
        "servo_latency": (adjusted.latency - open_lag, settings.latency_sigma),
        "servo_gain": (adjusted.servo.gain, settings.servo_gain_sigma),
        "servo_offset": (adjusted.servo.offset, settings.servo_offset_sigma),
    }
    silent = [] if account.has_servo else ["servo_latency"]
    if account.servo is None:
        silent += ["servo_gain", "servo_offset"]
    if model.cone:
        silent.append("walk_gain")
    learned = {
        name: {"value": value, "sigma": sigmas[name], "believed": pose_prior}
        for name, (value, pose_prior) in numbers.items()
        if name not in silent
    }
    if not math.isnan(account.recorded.temperature):
        learned["range_scale"]["temperature"] = account.recorded.temperature
    loudness = {"figure_of_merit": model.figure_of_merit, "ka": model.ka}
    beam = {"cone": model.cone} if model.cone else loudness
    return {**learned, **beam, "noise": account.noise, "agreement": agreement(account), "poses": account.verdict}


def _open_lag(account: Account) -> float:
    """Tell half of the lag by which a servo that stands still in each ping would seem to be late [s].

    Sound is heard where the servo has turned to in the meantime.  Nobody tells whether it did: one that waits for the
    echo seems to be late by as long as sound takes one way.
    """
    readings = account.recorded.readings
    detected = readings[np.isfinite(readings)]
    return 0.5 * float(np.median(detected)) / Air().speed_of_sound if len(detected) else 0.0
