"""A servo that turns farther than it records, or less far, and sits askew: where its pings looked."""

from typing import NamedTuple

from echoplan.preprocessing.soundings import Soundings, turned

__all__ = ["AS_RECORDED", "ServoError", "turned_by"]


class ServoError(NamedTuple):
    """How the true angle of a servo follows from the recorded one: ``gain * angle + offset``.

    Attributes
    ----------
    gain : float
        How far it turns for each radian that is recorded.
    offset : float
        Where it stands when it records 0 [rad].
    """

    gain: float = 1.0
    offset: float = 0.0


AS_RECORDED = ServoError()


def turned_by(soundings: Soundings, *, error: ServoError, before: ServoError) -> Soundings:
    """Turn soundings to where a servo was whose gain and offset are other than taken before.

    Parameters
    ----------
    soundings : Soundings
        The pings.
    error : ServoError
        Gain and offset of the servo.
    before : ServoError
        Those with which the soundings are as they are.

    Returns
    -------
    Soundings
        The pings as they were.
    """
    if error == before:
        return soundings
    return turned(soundings, error.offset - before.offset + (error.gain - before.gain) * soundings.angles)
