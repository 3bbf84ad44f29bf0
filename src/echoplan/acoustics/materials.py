"""What surfaces do to sound: how much of the pressure of a wave they return at about 40 kHz.

Rigid solids return all of it: their impedance is at least a thousand times that of air, so that
(Z2 - Z1) / (Z2 + Z1) exceeds 0.998.  What they lose they lose to roughness and pores.  No table reaches 40 kHz;
the absorption coefficients a are those of M. Vorlaender, "Auralization" (2008), appendix, at its highest octaves
(4 or 8 kHz), and the amplitude is sqrt(1 - a).  That they hold at 40 kHz is an assumption; it errs on
the loud side for pores, which swallow more the higher the tone.
"""

from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from echoplan.arrays import FloatArray
from echoplan.errors import UnknownNameError

__all__ = ["material_names", "reflection_coefficients"]

_ABSORPTION = MappingProxyType(
    {
        "hard": 0.0,  # the ideal mirror of the echo laws
        "metal": 0.0,  # from its impedance; not in the table
        "glass": 0.02,  # single pane, 3 mm
        "tile": 0.02,  # ceramic, smooth surface
        "concrete": 0.05,  # smooth, unpainted
        "brick": 0.04,  # rendered
        "plaster": 0.05,  # plasterboard, painted
        "wood": 0.07,  # 16 mm on studs
        "door": 0.10,  # solid wood
        "cardboard": 0.07,  # assumed: as thin plywood
        "carpet": 0.44,  # 6 mm pile
        "curtain": 0.73,  # densely woven, before a wall
        "upholstery": 0.81,  # heavily upholstered seats
        "foam": 0.95,  # melamine
    }
)


def material_names() -> list[str]:
    """Names of the materials that are known.

    Returns
    -------
    list of str
        In the order of the alphabet.

    Examples
    --------
    >>> "curtain" in material_names()
    True
    """
    return sorted(_ABSORPTION)


def reflection_coefficients(names: ArrayLike) -> FloatArray:
    """Amplitude reflection coefficients of materials.

    Parameters
    ----------
    names : array_like of str
        Names of materials.

    Returns
    -------
    ndarray of float64
        Pressure returned over pressure received, 0 to 1, in the shape of the names.

    Raises
    ------
    UnknownNameError
        If a name is not known.

    Examples
    --------
    >>> reflection_coefficients(["hard", "wood", "foam"]).round(2)
    array([1.  , 0.96, 0.22])
    """
    asked = np.asarray(names, dtype=np.str_)
    strange = sorted(set(asked.ravel().tolist()) - set(_ABSORPTION))
    if strange:
        raise UnknownNameError("material", strange[0], known=_ABSORPTION)
    absorbed = np.array([_ABSORPTION[name] for name in asked.ravel().tolist()], dtype=np.float64)
    return np.sqrt(1 - absorbed).reshape(asked.shape)
