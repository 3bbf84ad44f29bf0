"""Half angle of a ray cone, estimated from walls that its outermost ray meets obliquely."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from echoplan.acoustics.predicted_echo import EchoModel
from echoplan.arrays import FloatArray
from echoplan.geometry import along, signed_distances
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.preprocessing.measurements import Measurements

__all__ = ["fit_cone"]

# Minimum angle of incidence at which a reading determines the half angle; greatest half angle [rad].
_ASLANT, _WIDEST = np.radians(15.0), np.radians(60.0)
# Bin width of the histogram of half angles [rad]; minimum count of its peak, absolute and relative to the median bin.
_BIN, _FEWEST, _CLEAR = np.radians(0.5), 20, 4.0


def fit_cone(measurements: Measurements, model: EchoModel, features: Sequence[Hypothesis]) -> EchoModel:
    r"""Return the model with the half angle on which most oblique readings of walls agree; unchanged if none is clear.

    If the axis is turned from the normal of a wall by :math:`\theta` and the wall is at the depth d, the outermost ray
    of a cone of half angle h reads

    .. math:: z = \frac{d}{\cos(\theta - h)}, \qquad h = \theta - \arccos(d / z)

    Each reading beyond the depth of a wall implies a half angle; those that belong to the wall imply the same one.
    """
    named = [_named(measurements, each, 1.0 + model.range_scale) for each in features if each.is_wall]
    angles = np.concatenate([np.zeros(0), *named])
    counts = np.bincount((angles / _BIN).astype(np.int64), minlength=int(_WIDEST / _BIN) + 1)
    if counts.max() < max(_FEWEST, _CLEAR * float(np.median(counts))):
        return model
    middle = (int(np.argmax(counts)) + 0.5) * _BIN
    agreeing = angles[np.abs(angles - middle) < 1.5 * _BIN]
    return replace(model, cone=float(np.median(agreeing)))


def _named(measurements: Measurements, wall: Hypothesis, scale: float) -> FloatArray:
    """Return the half angles that readings imply if they belong to the wall, shape (k,) [rad]."""
    places = np.column_stack([measurements.x, measurements.y])
    depths, feet = -signed_distances(wall.line, places), along(wall.line, places)
    cosines = depths / (scale * measurements.readings)
    met = np.isfinite(measurements.readings) & (cosines > 0.0) & (cosines < np.cos(_ASLANT))
    slant = np.arccos(cosines[met])
    turned = np.angle(np.exp(1j * (measurements.bearings[met] - wall.line[0])))
    ends = feet[met] + np.sign(turned) * depths[met] * np.tan(slant)
    angles = np.abs(turned) - slant
    possible = (ends > wall.extent[0]) & (ends < wall.extent[1]) & (angles > 0.0) & (angles < _WIDEST)
    chosen: FloatArray = angles[possible]
    return chosen
