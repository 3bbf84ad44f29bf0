"""Health of sensors: which of them do not listen, or always say the same."""

import numpy as np
from pydantic import BaseModel, Field

from echoplan.arrays import BoolArray, FloatArray
from echoplan.preprocessing.soundings import Soundings

__all__ = ["HealthSettings", "healthy"]


class HealthSettings(BaseModel, frozen=True, extra="forbid"):
    """When a sensor is believed to work."""

    least_pings: int = Field(default=30, ge=1, description="fewer tell nothing about a sensor")
    least_stations: int = Field(default=3, ge=1, description="from fewer the world itself may look alike")
    dead_share: float = Field(default=0.05, gt=0.0, description="of the echoes that the others hear, at least")
    stuck_share: float = Field(default=0.5, gt=0.0, description="of its pings that give one reading, at most")
    width: float = Field(default=0.01, gt=0.0, description="readings this near to each other are one [m]")


def healthy(soundings: Soundings, settings: HealthSettings) -> BoolArray:
    """Tell which pings come from sensors that work.

    A dead sensor hears nothing where its mates hear something; a stuck one gives the same reading wherever the robot
    stands.  Both would speak against every wall.

    Parameters
    ----------
    soundings : Soundings
        Pings of several stations.
    settings : HealthSettings
        When a sensor is believed to work.

    Returns
    -------
    ndarray of bool, shape (n,)
        Whether to listen to each ping; all of them if there are too few to tell.
    """
    count = int(soundings.sensors.max(initial=-1)) + 1
    if len(soundings.centers) < settings.least_stations or not count:
        return np.ones(len(soundings.readings), dtype=bool)
    pings = np.bincount(soundings.sensors, minlength=count)
    echoes = np.bincount(soundings.sensors, np.isfinite(soundings.readings), minlength=count) / np.maximum(pings, 1)
    usual = float(np.median(echoes[pings > 0]))
    dead = echoes < settings.dead_share * usual
    stuck = np.array([_commonest(soundings.readings[soundings.sensors == k], settings) for k in range(count)])
    ill = (pings >= settings.least_pings) & (dead | (stuck > settings.stuck_share * np.maximum(pings, 1)))
    listened: BoolArray = ~ill[soundings.sensors]
    return listened


def _commonest(readings: FloatArray, settings: HealthSettings) -> int:
    """How often the commonest reading was given."""
    heard = np.sort(readings[np.isfinite(readings)])
    if not len(heard):
        return 0
    together = np.searchsorted(heard, heard + settings.width, side="right") - np.arange(len(heard))
    return int(together.max())
