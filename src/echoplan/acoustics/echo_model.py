"""A sonar as a recording shows it, and the tables that compiled functions read of it."""

import math
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from echoplan.acoustics.air import Air, speed_of_sound
from echoplan.acoustics.beam import two_way_loss
from echoplan.acoustics.detection import peak_delay
from echoplan.acoustics.range_walk_model import WalkCurve, physical_walk
from echoplan.acoustics.sonar import piston_ka
from echoplan.arrays import FloatArray
from echoplan.model import Transducer

__all__ = ["COSINE_LIMIT", "PER_SQUARED_SINE", "SQUARED_SINES", "EchoModel", "SonarTables"]

# The beam is tabulated over the squared sine of the angle off its axis, up to 75 degrees; beyond that nothing is
# expected.  No sonar has a lobe there that anyone has measured.
SQUARED_SINES = 2048
COSINE_LIMIT = math.cos(math.radians(75.0))
_SQUARED_LIMIT = 1.0 - COSINE_LIMIT**2
PER_SQUARED_SINE = SQUARED_SINES / _SQUARED_LIMIT
_BEAM_FLOOR = -80.0
# The slope of the walk is taken between points this far below and above [dB].
_SLOPE_STEP = 0.25
# Patterns of pistons are tabulated up to this ``ka sin(angle)``; hardly any module has a wider piston.
_WIDEST = 16.0
# Signal excess of whatever a ray meets [dB].
_RAY_EXCESS = 300.0
# In which sonars work [degrees Celsius].
_TEMPERATURES = np.arange(-30.0, 61.0)
_SPEEDS = speed_of_sound(_TEMPERATURES)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class EchoModel:
    """A sonar as a recording shows it: loudness, beam, and how its readings relate to ranges.

    A reading z stands for the depth e by
    ``z (1 + range_scale) = e + range_offset + walk_gain (walk(M)^k - walk(M_1)^k)``, where M is the signal excess, M_1
    that of an aimed plane at 1 m, where a maker sets a module right, and k is ``walk_exponent``.

    Parameters
    ----------
    figure_of_merit : float
        Signal excess of a plane at 0.5 m, whose path is 1 m long, without absorption [dB].
    ka : float
        Circumference of the piston in wavelengths.
    absorption : float
        Of the air [dB/m].
    walk : WalkCurve
        Shape of the range walk.
    walk_gain : float
        Walk at the threshold [m].
    walk_exponent : float
        How the walk of loud echoes compares with that of faint ones: an envelope that rises as ``t^n`` crosses a
        threshold M decibels below its peak after a delay in proportion to ``10^(-M / 20n)``, so another n is a power
        of the same curve.
    range_offset : float
        Error of the reading of an aimed plane at 1 m [m].
    range_scale : float
        Share by which readings are too short.
    frequency : float
        Of the burst [Hz].
    excess_scale : float
        Uncertainty of the excess of an echo: scale of a logistic distribution [dB].  By default its deviation is half
        a decibel, what echoes that add up and steps of the readings leave of a loudness at best.
    cone : float
        Half of the angle of the cone whose nearest point a robot simulator returns [rad]; 0 for sound.
    """

    figure_of_merit: float
    ka: float
    absorption: float
    walk: WalkCurve
    walk_gain: float
    walk_exponent: float = 1.0
    range_offset: float = 0.0
    range_scale: float = 0.0
    frequency: float = 40_000.0
    excess_scale: float = 0.3
    cone: float = 0.0

    @classmethod
    def of(cls, transducer: Transducer) -> "EchoModel":
        """Return the model of a sonar with a given transducer in air of 20 degrees Celsius.

        Parameters
        ----------
        transducer : Transducer
            Burst, resonators, piston and figure of merit.

        Returns
        -------
        EchoModel
            Set right, as by its maker.
        """
        air = Air()
        return cls(
            figure_of_merit=transducer.figure_of_merit,
            ka=piston_ka(transducer, air),
            absorption=float(air.absorption(transducer.frequency)),
            walk=physical_walk(transducer),
            walk_gain=0.5 * air.speed_of_sound * peak_delay(transducer),
            frequency=transducer.frequency,
        )

    def scaled(self, range_scale: float) -> "EchoModel":
        """Return the model of the sonar in air in which sound is faster than its modules assume.

        The temperature follows from the speed of sound, and the absorption from the temperature, at a humidity of 50 %.

        Parameters
        ----------
        range_scale : float
            Share by which readings are too short.

        Returns
        -------
        EchoModel
            With another range scale and absorption.

        Examples
        --------
        >>> model = EchoModel.of(Transducer())
        >>> round(model.absorption, 2), round(model.scaled(-0.0180).absorption, 2)  # 20 and 10 degrees Celsius
        (1.32, 0.85)
        """
        speed = (1.0 + range_scale) * Air().speed_of_sound
        temperature = float(np.interp(speed, _SPEEDS, _TEMPERATURES))
        absorption = Air(temperature=temperature).absorption(self.frequency)
        return replace(self, range_scale=range_scale, absorption=absorption)

    @property
    def reference_excess(self) -> float:
        """Signal excess of an aimed plane at 1 m [dB]."""
        return self.figure_of_merit - 20 * math.log10(2.0) - 2 * self.absorption

    @property
    def reference_walk(self) -> float:
        """Walk of an aimed plane at 1 m, as a share of that at the threshold."""
        return float(self.walk.blurred(self.excess_scale)(self.reference_excess) ** self.walk_exponent)

    def sigma_from_excess(self, excess: ArrayLike) -> FloatArray:
        """Return the standard deviation of readings that follows from the uncertain excess of their echoes.

        Parameters
        ----------
        excess : array_like
            What it should be [dB].

        Returns
        -------
        ndarray
            Standard deviation [m].

        Examples
        --------
        >>> 1000 * EchoModel.of(Transducer()).sigma_from_excess([0.0, 6.0]).round(4)
        array([2.9, 1. ])
        """
        return self.walk_gain * self.walk.sigma_from_excess(excess, self.excess_scale)

    def variances(self, excess: ArrayLike, *, noise: float) -> FloatArray:
        """Return the variances of readings, which scatter by the noise on average and more the fainter their echoes.

        The noise is estimated from echoes of all strengths, so that it already contains what an uncertain excess adds
        in the median; at least half of its square is taken for the readings' own noise.

        Parameters
        ----------
        excess : array_like, shape (n,)
            What they should be [dB].
        noise : float
            Standard deviation of all readings [m].

        Returns
        -------
        ndarray, shape (n,)
            Of each [m^2].

        Examples
        --------
        >>> model = EchoModel.of(Transducer())
        >>> 1000 * np.sqrt(model.variances([1.0, 6.0, 20.0], noise=0.002)).round(5)
        array([2.98, 2.  , 1.76])
        """
        squares = self.sigma_from_excess(excess) ** 2
        usual = min(float(np.median(squares)), 0.5 * noise**2) if len(squares) else 0.0
        return noise**2 - usual + squares

    def as_ray_cone(self, half_angle: float) -> "EchoModel":
        """Return a model of what robot simulators call a sonar: the nearest point in a cone of rays.

        Parameters
        ----------
        half_angle : float
            Half of the opening angle of the cone [rad].

        Returns
        -------
        EchoModel
            Another one; this one stays as it is.

        Examples
        --------
        >>> EchoModel.of(Transducer()).as_ray_cone(0.25).cone
        0.25
        """
        return replace(self, cone=half_angle)

    def tabulated(self) -> "SonarTables":
        """Turn the model into numbers and tables.

        Returns
        -------
        SonarTables
            What compiled functions read.
        """
        if self.cone:
            return self._ray_cone_tables()
        walk = self.walk.blurred(self.excess_scale)
        shape = walk.values**self.walk_exponent - self.reference_walk
        below, above = walk(self.reference_excess + np.array([-_SLOPE_STEP, _SLOPE_STEP])) ** self.walk_exponent
        late = self.range_offset + self.walk_gain * shape
        return SonarTables(
            figure_of_merit=self.figure_of_merit,
            absorption=self.absorption,
            scale=1.0 + self.range_scale,
            beam=_main_lobe(self.ka),
            lobes=_lobes(self.ka),
            walk=late,
            walks=(float(late.min()), float(late.max())),
            reference=self.walk_gain * float(above - below) / (2 * _SLOPE_STEP),
            wavelength=(1.0 + self.range_scale) * Air().speed_of_sound / self.frequency,
            cone=self.cone,
        )

    def _ray_cone_tables(self) -> "SonarTables":
        """Tables of a ray cone: it returns whatever is in the cone, however small, at its depth, and nothing else."""
        within = np.linspace(0.0, _SQUARED_LIMIT, SQUARED_SINES + 1) <= math.sin(self.cone) ** 2
        return SonarTables(
            figure_of_merit=_RAY_EXCESS,
            absorption=0.0,
            scale=1.0 + self.range_scale,
            beam=np.where(within, 0.0, -2.0 * _RAY_EXCESS),
            lobes=np.full(SQUARED_SINES + 1, -2.0 * _RAY_EXCESS),
            walk=np.full(len(self.walk.values), self.range_offset),
            walks=(self.range_offset, self.range_offset),
            reference=0.0,
            wavelength=Air().speed_of_sound / self.frequency,
            cone=self.cone,
        )


class SonarTables(NamedTuple):
    """An echo model as numbers and tables.

    Attributes
    ----------
    figure_of_merit, absorption : float
        As in the model [dB], [dB/m].
    scale : float
        What turns a reading into a range.
    beam : ndarray
        Two-way gain at even steps of the squared sine off the axis [dB].
    lobes : ndarray
        The same up to 90 degrees, as loud as the loudest lobe at or beyond each angle [dB].
    walk : ndarray
        Reading less depth at even steps of the signal excess [m].
    walks : tuple of float
        The least and the greatest of these [m].
    reference : float
        Slope of the walk where modules are set right: of an aimed plane at 1 m [m/dB].
    wavelength : float
        Of the burst [m].
    cone : float
        As in the model [rad].
    """

    figure_of_merit: float
    absorption: float
    scale: float
    beam: FloatArray
    lobes: FloatArray
    walk: FloatArray
    walks: tuple[float, float]
    reference: float
    wavelength: float
    cone: float = 0.0


# A recording is explained by one beam again and again, and by others hardly wider while it is learned.
@lru_cache(maxsize=8)
def _main_lobe(ka: float) -> FloatArray:
    """Behind the first null lobes come and go with the angle; a sonar is trusted no more there than in the null."""
    gains: FloatArray = np.minimum.accumulate(_gains(ka, _SQUARED_LIMIT))
    return gains


@lru_cache(maxsize=8)
def _lobes(ka: float) -> FloatArray:
    outward: FloatArray = np.maximum.accumulate(_gains(ka, 1.0)[::-1])
    return outward[::-1]


def _gains(ka: float, limit: float) -> FloatArray:
    """Two-way gain at even steps of the squared sine off the axis up to a limit [dB]."""
    x = ka * np.sqrt(np.linspace(0.0, limit, SQUARED_SINES + 1))
    if x[-1] > _WIDEST:
        return np.maximum(-two_way_loss(np.arcsin(x / ka), ka), _BEAM_FLOOR)
    arguments, gains = _pattern()
    interpolated: FloatArray = np.interp(x, arguments, gains)
    return interpolated


@cache
def _pattern() -> tuple[FloatArray, FloatArray]:
    """Two-way gain of any piston against ``ka sin(angle)`` [dB]."""
    arguments = np.linspace(0.0, _WIDEST, 8 * SQUARED_SINES + 1)
    return arguments, np.maximum(-two_way_loss(np.arcsin(arguments / _WIDEST), _WIDEST), _BEAM_FLOOR)
