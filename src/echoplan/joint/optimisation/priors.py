"""Priors of sonar, servo and poses before any ping is used, and the settings of the optimiser."""

import math
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from echoplan.arrays import FloatArray
from echoplan.joint.optimisation.corner_factors import CornerFactorSettings
from echoplan.joint.optimisation.factors import LinearFactor, prior
from echoplan.joint.optimisation.layout import SONAR_UNKNOWNS
from echoplan.joint.optimisation.manhattan import ManhattanPrior
from echoplan.joint.optimisation.pose_factors import PosePrior
from echoplan.joint.optimisation.values import Values
from echoplan.preprocessing.servo import ServoError
from echoplan.settings import Settings

__all__ = ["OptimiserSettings", "Priors", "sonar_prior"]


class OptimiserSettings(Settings):
    """Settings of the optimiser: iterations, robust kernel and standard deviations of the priors."""

    former_keys: ClassVar = {
        "told_scale_sigma": "scale_sigma_with_thermometer",
        "rounds": "max_iterations",
        "rest": "tolerance",
        "robust": "geman_mcclure_scale",
        "gain_share": "walk_gain_sigma",
        "offset_floor": "min_offset_sigma",
        "exponent_sigma": "walk_exponent_sigma",
        "determined": "min_latency_z",
        "ties": "corner_factors",
    }

    max_iterations: int = Field(default=6, ge=1, description="Largest number of Gauss-Newton steps.")
    # Squared length of a step, in standard deviations, below which the optimisation stops.
    tolerance: ClassVar[float] = 1e-4
    geman_mcclure_scale: float = Field(
        default=2.5,
        gt=0.0,
        description="Scale of the Geman-McClure kernel: the residual, in standard deviations, at which a reading "
        "has a quarter of its weight.",
    )
    walk_gain_sigma: float = Field(
        default=0.24, gt=0.0, description="Standard deviation of the gain of the range walk, as a share of it."
    )
    scale_sigma: float = Field(
        default=0.03, gt=0.0, description="Standard deviation of the range scale: 50 degrees of temperature."
    )
    scale_sigma_with_thermometer: float = Field(
        default=0.002, gt=0.0, description="Standard deviation of the range scale with a thermometer or on a drive."
    )
    # Smallest standard deviation of the range offset as corners determine it [m]: 1.8 mm in rooms of 100 stations.
    min_offset_sigma: ClassVar[float] = 0.002
    latency_sigma: float = Field(
        default=0.02, gt=0.0, description="Standard deviation of the latency of the servo [s]."
    )
    servo_gain_sigma: float = Field(
        default=0.05,
        gt=0.0,
        description="Standard deviation of the gain of a servo that is calibrated: hobby servos of one kind "
        "differ by 5 %.",
    )
    servo_offset_sigma: float = Field(
        default=math.radians(5.0),
        gt=0.0,
        description="Standard deviation of the offset of a servo that is calibrated [rad]: a horn fits on every "
        "17 degrees (21 teeth), so it is up to 8.5 degrees off.",
    )
    merit_sigma: float = Field(
        default=0.6, gt=0.0, description="Standard deviation of the figure of merit as detections determine it [dB]."
    )
    ka_sigma: float = Field(
        default=0.015,
        gt=0.0,
        description="Standard deviation of the logarithm of ka of the beam as detections determine it.",
    )
    # Standard deviation of the exponent of the range walk: 0.17 is the root mean square over bursts of 4 to 16 cycles
    # and resonators of a quality of 5 to 30.
    walk_exponent_sigma: ClassVar[float] = 0.2
    # Standard deviation of each end of a wall, and of a point, however many readings determine it [m]: 0.16 mm in rooms
    # of 60 to 150 stations.
    model_error: ClassVar[float] = 0.0002
    # Smallest latency of the servo that is used while poses drift, in standard deviations.
    min_latency_z: ClassVar[float] = 2.0
    # Expected radius of a cylinder with few readings [m].
    radius: ClassVar[float] = 0.12
    # Standard deviation of the expected radius [m].
    radius_sigma: ClassVar[float] = 0.1
    corner_factors: ClassVar[CornerFactorSettings] = CornerFactorSettings()

    def servo_strain(self, gain: ArrayLike, offset: ArrayLike) -> FloatArray:
        """Return the negative log prior density of gains and offsets [rad] of a servo, up to a constant [nats]."""
        turned = (np.asarray(gain, dtype=np.float64) - 1.0) / self.servo_gain_sigma
        askew = np.asarray(offset, dtype=np.float64) / self.servo_offset_sigma
        strain: FloatArray = 0.5 * (turned**2 + askew**2)
        return strain


class Priors(NamedTuple):
    """Priors of one optimisation."""

    # Standard deviation of a reading [m].
    noise: float
    # Standard deviation of the range offset, the error of an aimed plane at 1 m [m]: modules are adjusted to be right
    # there within a step of the readings.
    offset_sigma: float
    # Prior mean of the range walk at the threshold [m].
    walk_gain: float
    # Whether there is a servo, so that its latency is a variable.
    has_servo: bool
    # Standard deviation of the range scale.
    scale_sigma: float
    # Prior mean of the range scale, by the expected speed of sound.
    range_scale: float = 0.0
    # Whether errors of the poses accumulate.
    drifting: bool = False
    # Prior of the poses; None if they are fixed.
    poses: PosePrior | None = None
    # Standard deviation of the error that all readings of a landmark from one station share [m]; 0 if there is none.
    bias_sigma: float = 0.0
    # Ratio of the effective sample size of the readings to their weight.
    effective_sample_ratio: float = 1.0
    # Ratio of the information of the readings to that which their weights give them.
    information_inflation: float = 1.0
    # Figure of merit [dB] and logarithm of ka as estimated from detections and non-detections; None before that, and
    # while poses drift or have not converged: then both are fixed.
    beam_prior: tuple[float, float] | None = None
    # Prior of walls at right angles, if there is one.
    manhattan_prior: ManhattanPrior | None = None
    # Whether the angles at which walls are detected determine yaw or servo (heading factors).
    bearings: bool = False
    # Gain and offset of the servo by which the pings are placed; None if the servo is not calibrated.
    servo: ServoError | None = None


def sonar_prior(now: Values, first: int, priors: Priors, settings: OptimiserSettings) -> LinearFactor:
    """Return the prior factor of sonar and servo, one row per unknown; ``first`` is the position of the first."""
    model, gain_sigma = now.model, settings.walk_gain_sigma * priors.walk_gain
    # Without a servo there is no latency: the unknown is fixed.
    latency_sigma = settings.latency_sigma if priors.has_servo else 1e-9
    # Gain and offset are fixed unless the servo is calibrated.
    open_servo = priors.servo is not None
    servo_sigmas = (settings.servo_gain_sigma, settings.servo_offset_sigma) if open_servo else (1e-9, 1e-9)
    # Ray cones have no range walk: its exponent is fixed.
    exponent_sigma = 1e-9 if model.cone else settings.walk_exponent_sigma
    merit, log_ka, *beam_sigmas = (model.figure_of_merit, math.log(model.ka), 1e-9, 1e-9)
    if priors.beam_prior is not None:
        merit, log_ka, *beam_sigmas = *priors.beam_prior, settings.merit_sigma, settings.ka_sigma
    return prior(
        first + np.arange(len(SONAR_UNKNOWNS)),
        sigma=(
            priors.offset_sigma,
            gain_sigma,
            priors.scale_sigma,
            latency_sigma,
            *servo_sigmas,
            *beam_sigmas,
            exponent_sigma,
        ),
        residual=(
            -model.range_offset,
            priors.walk_gain - model.walk_gain,
            priors.range_scale - model.range_scale,
            -now.latency,
            1.0 - now.servo.gain,
            -now.servo.offset,
            merit - model.figure_of_merit,
            log_ka - math.log(model.ka),
            1.0 - model.walk_exponent,
        ),
    )
