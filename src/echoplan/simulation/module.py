"""The sensor module: what it makes of the instant at which its threshold was reached."""

from dataclasses import dataclass

import numpy as np

from echoplan.acoustics import carrier_delay, crossing_delay, plane_echo, signal_excess, speed_of_sound
from echoplan.arrays import FloatArray, IntArray
from echoplan.errors import InvalidValueError
from echoplan.model import Rig, Transducer
from echoplan.simulation.settings import SimulationSettings

__all__ = ["Module", "build_module"]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Module:
    """How the modules of a rig turn time into readings.

    Parameters
    ----------
    speed_of_sound : float
        What they take the speed of sound to be [m/s].
    zero_delay : float
        What they take off every time [s]: the slope of the echo for which their maker set them right.
    min_ranges, max_ranges, resolutions : ndarray, shape (s,)
        Dead distance, reach and step of the readings of each sensor [m].
    jitter : float
        Standard deviation of a range [m].
    dropout, stray : float
        Probabilities of no reading and of a stray echo.
    """

    speed_of_sound: float
    zero_delay: float
    min_ranges: FloatArray
    max_ranges: FloatArray
    resolutions: FloatArray
    jitter: float
    dropout: float
    stray: float

    def openings(self, sensors: IntArray) -> FloatArray:
        """When sensors begin to listen: at the end of their dead distance.

        Parameters
        ----------
        sensors : ndarray of int, shape (n,)
            Which sensors.

        Returns
        -------
        ndarray, shape (n,)
            Time after the burst [s].
        """
        return self._time(self.min_ranges[sensors])

    def deadlines(self, sensors: IntArray) -> FloatArray:
        """When sensors cease to listen: half a step beyond their reach.

        Parameters
        ----------
        sensors : ndarray of int, shape (n,)
            Which sensors.

        Returns
        -------
        ndarray, shape (n,)
            Time after the burst [s].
        """
        return self._time(self.max_ranges[sensors] + 0.5 * self.resolutions[sensors])

    def readings(self, instants: FloatArray, sensors: IntArray, rng: np.random.Generator) -> FloatArray:
        """Turn the instants at which the thresholds were reached into readings.

        An echo that is loud when listening begins reads as too close.  A stray echo comes from anywhere within
        reach, and is read only where nothing nearer was detected.  A dropout loses whatever was detected.

        Parameters
        ----------
        instants : ndarray, shape (n,)
            Times after the bursts [s]; ``inf`` and ``-inf`` as from ``first_crossings``.
        sensors : ndarray of int, shape (n,)
            Which sensors.
        rng : Generator
            Source of chance; the same number of draws whatever the settings.

        Returns
        -------
        ndarray, shape (n,)
            Readings [m] (REP 117).
        """
        noise = self.jitter * rng.standard_normal(len(instants))
        strays = rng.uniform(self.min_ranges[sensors], self.max_ranges[sensors])
        is_stray, is_lost = rng.random(len(instants)) < self.stray, rng.random(len(instants)) < self.dropout
        ranges = 0.5 * self.speed_of_sound * (instants - self.zero_delay) + noise
        ranges = np.where(is_stray, np.minimum(ranges, strays), ranges)
        ranges = self._in_steps(ranges, sensors)
        ranges = np.where(np.isfinite(ranges), np.maximum(ranges, self.min_ranges[sensors]), ranges)
        return np.where(is_lost | (ranges > self.max_ranges[sensors]), np.inf, ranges)

    def _time(self, ranges: FloatArray) -> FloatArray:
        times: FloatArray = 2 * ranges / self.speed_of_sound + self.zero_delay
        return times

    def _in_steps(self, ranges: FloatArray, sensors: IntArray) -> FloatArray:
        steps = self.resolutions[sensors]
        stepped = steps > 0
        whole = np.where(stepped, steps, 1.0)
        return np.where(stepped, np.round(ranges / whole) * whole, ranges)


def build_module(rig: Rig, transducer: Transducer, settings: SimulationSettings) -> Module:
    """Prepare the modules of a rig.

    The maker set the range right for an aimed plane at ``zero_distance``, in air of the assumed temperature, but for
    ``zero_error``.

    Parameters
    ----------
    rig : Rig
        The sensors.
    transducer : Transducer
        What they are made of.
    settings : SimulationSettings
        What they assume and how they err.

    Returns
    -------
    Module
        How they read.

    Raises
    ------
    InvalidValueError
        If the plane at ``zero_distance`` cannot be detected.
    """
    laboratory = settings.air.model_copy(update={"temperature": settings.assumed_temperature, "relative_humidity": 0.5})
    distance = settings.zero_distance
    excess = signal_excess(plane_echo(distance), 2 * distance, transducer=transducer, air=laboratory)
    if excess <= 0:
        raise InvalidValueError(
            f"zero_distance must be within reach, but a plane at {distance:g} m stays {-float(excess):.1f} dB below "
            "the threshold; choose a smaller one"
        )
    delay = carrier_delay if settings.detector == "carrier" else crossing_delay
    speed = rig.speed_of_sound or float(speed_of_sound(settings.assumed_temperature))
    return Module(
        speed_of_sound=speed,
        zero_delay=float(delay(excess, transducer)) - 2.0 * settings.zero_error / speed,
        min_ranges=rig.min_ranges,
        max_ranges=rig.max_ranges,
        resolutions=np.array([sensor.resolution for sensor in rig.sensors]),
        jitter=settings.jitter,
        dropout=settings.dropout,
        stray=settings.stray,
    )
