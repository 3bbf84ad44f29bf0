"""Calibration: what a recording told of the sonar that made it."""

import math

from echoplan.mapping.account import Account
from echoplan.mapping.adjustment import Adjusted
from echoplan.mapping.agreement import agreement

__all__ = ["calibration"]


def calibration(account: Account, adjusted: Adjusted) -> dict[str, object]:
    """Tell what was learned of the sonar, and how well.

    Parameters
    ----------
    account : Account
        What was heard, and what is made of it.
    adjusted : Adjusted
        An adjustment of all that was ever heard.

    Returns
    -------
    dict
        Values with standard deviations and what was believed before, in SI units; beam, noise, and what was done
        about the poses.
    """
    sigmas, model, settings = adjusted.sonar_sigmas(), adjusted.model, account.settings.adjustment
    beliefs = account.beliefs(account.noise, account.believed)
    if account.drifts:
        # Then it is held at what was believed.
        sigmas["range_scale"] = beliefs.scale_sigma
    numbers = {
        "range_offset": (model.range_offset, beliefs.offset_sigma),
        "walk_gain": (model.walk_gain, settings.gain_share * beliefs.walk_gain),
        "range_scale": (model.range_scale, beliefs.scale_sigma),
        "servo_latency": (adjusted.latency, settings.latency_sigma),
    }
    learned = {
        name: {"value": value, "sigma": sigmas[name], "believed": believed}
        for name, (value, believed) in numbers.items()
        if (name != "servo_latency" or account.has_servo) and not (name == "walk_gain" and model.cone)
    }
    if not math.isnan(account.recorded.temperature):
        learned["range_scale"]["temperature"] = account.recorded.temperature
    loudness = {"figure_of_merit": model.figure_of_merit, "ka": model.ka}
    beam = {"cone": model.cone} if model.cone else loudness
    return {**learned, **beam, "noise": account.noise, "agreement": agreement(account), "poses": account.verdict}
