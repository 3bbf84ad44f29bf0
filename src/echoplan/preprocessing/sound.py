"""Sound: by how much readings are stretched if the air is not what modules take it to be."""

import math

from echoplan.acoustics import Air
from echoplan.model import Rig

__all__ = ["expected_scale"]


def expected_scale(rig: Rig, temperature: float) -> float:
    r"""Return by how much readings are too short, from a thermometer and the speed of sound that the modules assume.

    A module that takes the speed of sound to be u where it is c reads z = e u / c of a depth e, so that

    .. math:: z (1 + s) = e, \qquad s = c / u - 1

    Parameters
    ----------
    rig : Rig
        The modules; if it does not state the speed that they assume, that of air of 20 degrees is taken.
    temperature : float
        Of the air [degrees Celsius]; ``nan`` if it was not measured, which is taken for 20.

    Returns
    -------
    float
        The share s of a reading that it lacks.

    Examples
    --------
    >>> from echoplan.io import builtin_rig
    >>> round(expected_scale(builtin_rig("rotary-array"), 30.0), 4)
    0.0184
    """
    usual = Air()
    air = usual if math.isnan(temperature) else Air(temperature=temperature)
    return air.speed_of_sound / (rig.speed_of_sound or usual.speed_of_sound) - 1.0
