"""Home-made heads: a servo with unknown gain and offset, and poses measured by hand."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.model import Sweep
from echoplan.simulation import Simulation
from library.rooms import random_simulation

__all__ = ["measured_by_hand", "simulate_head"]

_STATIONS = 8
# Standard deviations of a pose measured by tape and eye [m, m, rad].
_BY_HAND = (0.015, 0.015, math.radians(3.0))


def simulate_head(seed: int, *, gain: float, offset: float) -> tuple[str, Simulation]:
    """Simulate a room recorded by a head whose servo has an unknown gain and offset [degrees at most]."""
    array = "rotary-array" if seed % 5 == 4 else "hc-sr04-servo"
    simulation, rng = random_simulation(seed, array=array, stations=_STATIONS), np.random.default_rng((seed, 11))
    gain_factor, offset_angle = 1.0 + rng.uniform(-gain, gain), math.radians(rng.uniform(-offset, offset))
    settings = simulation.settings.model_copy(update={"servo_gain": gain_factor, "servo_offset": offset_angle})
    return array, replace(simulation, settings=settings)


def measured_by_hand(sweeps: Sequence[Sweep], seed: int) -> list[Sweep]:
    """Replace true poses by poses measured by hand, in whole centimetres and degrees."""
    rng = np.random.default_rng((seed, 12))
    return [replace(each, map_from_base=_rounded(each.map_from_base + rng.normal(0.0, _BY_HAND))) for each in sweeps]


def _rounded(poses: FloatArray) -> FloatArray:
    steps = np.array([0.01, 0.01, math.radians(1.0)])
    rounded: FloatArray = steps * np.round(poses / steps)
    return rounded
