"""Air: how fast sound travels in it and how much of an ultrasonic wave it swallows."""

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from echoplan.arrays import FloatArray
from echoplan.settings import Settings

__all__ = ["Air", "absorption", "speed_of_sound"]

_STANDARD_PRESSURE = 101_325.0
_CARBON_DIOXIDE = 0.0004  # mole fraction, as in open air after 2015
_REFERENCE_KELVIN = 293.15
_TRIPLE_POINT_KELVIN = 273.16
_CELSIUS_ZERO = 273.15


class Air(Settings):
    """The air in which a sonar works."""

    temperature: float = Field(default=20.0, ge=-30.0, le=60.0, description="Temperature of the air [degrees Celsius].")
    relative_humidity: float = Field(
        default=0.5, ge=0.0, le=1.0, description="Relative humidity of the air, from 0 to 1."
    )
    pressure: float = Field(default=_STANDARD_PRESSURE, gt=10_000.0, lt=200_000.0, description="Air pressure [Pa].")

    @property
    def speed_of_sound(self) -> float:
        """Speed of sound [m/s]."""
        speed = speed_of_sound(self.temperature, relative_humidity=self.relative_humidity, pressure=self.pressure)
        return float(speed)

    def absorption(self, frequency: float) -> float:
        """Absorption of a pure tone [dB/m].

        Parameters
        ----------
        frequency : float
            Frequency [Hz].

        Returns
        -------
        float
            Loss per metre of path [dB/m].

        Examples
        --------
        >>> round(Air().absorption(40_000.0), 2)
        1.32
        """
        loss = absorption(
            frequency,
            temperature=self.temperature,
            relative_humidity=self.relative_humidity,
            pressure=self.pressure,
        )
        return float(loss)


def speed_of_sound(
    temperature: ArrayLike, *, relative_humidity: ArrayLike = 0.5, pressure: ArrayLike = _STANDARD_PRESSURE
) -> FloatArray:
    """Speed of sound in humid air by the polynomial of Cramer.

    O. Cramer, "The variation of the specific heat ratio and the speed of sound in air with temperature, pressure,
    humidity, and CO2 concentration", J. Acoust. Soc. Am. 93 (1993) 2510, Eq. 15, for 0 to 30 degrees Celsius,
    75 to 102 kPa and up to 0.06 of water; outside it is an extrapolation.

    Parameters
    ----------
    temperature : array_like
        Temperature [degrees Celsius].
    relative_humidity : array_like, optional
        Share of saturation, 0 to 1.
    pressure : array_like, optional
        Pressure [Pa].

    Returns
    -------
    ndarray of float64
        Speed of sound [m/s]; the arguments broadcast.

    Examples
    --------
    >>> speed_of_sound([0.0, 20.0, 30.0]).round(1)
    array([331.6, 344. , 350.3])
    """
    t, p = np.asarray(temperature, dtype=np.float64), np.asarray(pressure, dtype=np.float64)
    w = _mole_fraction_of_water(t, np.asarray(relative_humidity, dtype=np.float64), p)
    c = _CARBON_DIOXIDE
    dry = 331.5024 + 0.603055 * t - 0.000528 * t**2
    water = (51.471935 + 0.1495874 * t - 0.000782 * t**2) * w - 2.835149 * w**2
    pressing = (-1.82e-7 + 3.73e-8 * t - 2.93e-10 * t**2) * p - 2.15e-13 * p**2
    carbon = (-85.20931 - 0.228525 * t + 5.91e-5 * t**2) * c + 29.179762 * c**2
    speed: FloatArray = dry + water + pressing + carbon + 0.000486 * w * p * c
    return speed


def absorption(
    frequency: ArrayLike,
    *,
    temperature: ArrayLike = 20.0,
    relative_humidity: ArrayLike = 0.5,
    pressure: ArrayLike = _STANDARD_PRESSURE,
) -> FloatArray:
    """Absorption of a pure tone in humid air by ISO 9613-1, Eq. 3 to 6 and B.2 to B.3.

    Parameters
    ----------
    frequency : array_like
        Frequency [Hz].
    temperature : array_like, optional
        Temperature [degrees Celsius].
    relative_humidity : array_like, optional
        Share of saturation, 0 to 1.
    pressure : array_like, optional
        Pressure [Pa].

    Returns
    -------
    ndarray of float64
        Loss per metre of path [dB/m]; the arguments broadcast.

    Examples
    --------
    >>> absorption([25e3, 40e3, 58e3]).round(2)
    array([0.73, 1.32, 1.92])
    """
    kelvin = np.asarray(temperature, dtype=np.float64) + _CELSIUS_ZERO
    warmth = kelvin / _REFERENCE_KELVIN
    atmospheres = np.asarray(pressure, dtype=np.float64) / _STANDARD_PRESSURE
    saturation = 10 ** (-6.8346 * (_TRIPLE_POINT_KELVIN / kelvin) ** 1.261 + 4.6151)
    h = 100 * np.asarray(relative_humidity, dtype=np.float64) * saturation / atmospheres  # molar humidity [%]
    oxygen = atmospheres * (24 + 4.04e4 * h * (0.02 + h) / (0.391 + h))
    nitrogen = atmospheres * warmth**-0.5 * (9 + 280 * h * np.exp(-4.170 * (warmth ** (-1 / 3) - 1)))
    f = np.asarray(frequency, dtype=np.float64)
    classical = 1.84e-11 / atmospheres * warmth**0.5
    relaxing = 0.01275 * np.exp(-2239.1 / kelvin) / (oxygen + f**2 / oxygen)
    relaxing = relaxing + 0.1068 * np.exp(-3352.0 / kelvin) / (nitrogen + f**2 / nitrogen)
    loss: FloatArray = 8.686 * f**2 * (classical + warmth**-2.5 * relaxing)
    return loss


def _mole_fraction_of_water(temperature: FloatArray, relative_humidity: FloatArray, pressure: FloatArray) -> FloatArray:
    # Saturation and enhancement as Cramer takes them from Giacomo, Metrologia 18 (1982) 33.
    kelvin = temperature + _CELSIUS_ZERO
    saturation = np.exp(1.2811805e-5 * kelvin**2 - 1.9509874e-2 * kelvin + 34.04926034 - 6.3536311e3 / kelvin)
    enhancement = 1.00062 + 3.14e-8 * pressure + 5.6e-7 * temperature**2
    fraction: FloatArray = relative_humidity * enhancement * saturation / pressure
    return fraction
