"""A servo that turns farther than it records, or less far, has an offset, or lags behind: where its pings looked."""

from typing import NamedTuple

from echoplan.preprocessing.measurements import Measurements, turned

__all__ = ["AS_RECORDED", "ServoError", "apply_servo_latency", "turned_by"]


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


def turned_by(measurements: Measurements, *, error: ServoError, before: ServoError) -> Measurements:
    """Turn pings to where a servo was whose gain and offset are other than assumed before.

    Parameters
    ----------
    measurements : Measurements
        The pings.
    error : ServoError
        Gain and offset of the servo.
    before : ServoError
        Those with which the pings were computed.

    Returns
    -------
    Measurements
        The pings as they were.
    """
    if error == before:
        return measurements
    return turned(measurements, error.offset - before.offset + (error.gain - before.gain) * measurements.angles)


def apply_servo_latency(measurements: Measurements, latency: float) -> Measurements:
    """Turn pings back to where the servo was, if it lags behind what was recorded.

    Parameters
    ----------
    measurements : Measurements
        The pings as recorded.
    latency : float
        How long the servo takes to reach the commanded angle [s].

    Returns
    -------
    Measurements
        The pings as they were.
    """
    if latency == 0.0:
        return measurements
    return turned(measurements, -latency * measurements.rates)
