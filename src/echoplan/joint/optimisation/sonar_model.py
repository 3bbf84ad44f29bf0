"""The sonar model of a rig: as expected before any ping, and as estimated from detections and residuals."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from echoplan.acoustics import typical_transducer
from echoplan.acoustics.predicted_echo import EchoModel
from echoplan.acoustics.range_walk_model import WalkCurve, fitted_walk
from echoplan.errors import InvalidValueError
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.optimisation.figure_of_merit import fit_figure_of_merit
from echoplan.joint.optimisation.ray_cones import fit_cone
from echoplan.joint.optimisation.solution import Solution
from echoplan.model import Rig
from echoplan.preprocessing import expected_scale
from echoplan.preprocessing.measurements import Measurements
from echoplan.preprocessing.rays import are_rays

__all__ = ["Walk", "estimated_sonar", "expected_sonar", "half_aperture_of", "walking"]

# Range walk: that of the burst ("physical"), one fitted to the recording ("fitted"), or a table of signal excess [dB]
# and range error [m].
Walk: TypeAlias = str | Sequence[tuple[float, float]]

# Minimum number of pings per piece of a fitted range walk, and maximum number of pieces.
_A_PIECE, _PIECES = 25, 24


def expected_sonar(
    rig: Rig, measurements: Measurements, known: EchoModel | None = None, *, walk: Walk = "physical"
) -> EchoModel:
    """Return the model of the transducer of a rig, or of a typical one, at the measured temperature; or a ray cone.

    ``known`` is the model estimated from earlier pings. If the rig does not state whether its readings are those of
    rays, this is detected from the pings. InvalidValueError is raised if a table of the range walk is not sorted.
    """
    transducer = rig.transducer or typical_transducer(rig.sensors[0])
    model = EchoModel.of(transducer).scaled(expected_scale(rig, measurements.temperature))
    if walk == "fitted" and known is not None:
        model = replace(model, walk=known.walk, walk_gain=known.walk_gain)
    elif not isinstance(walk, str):
        excess, late = np.array(walk, dtype=np.float64).reshape(-1, 2).T
        model = replace(model, walk=WalkCurve.from_table(excess, late), walk_gain=float(late[0] - late[-1]))
    if known is not None:
        reads_rays = known.cone > 0.0
    elif rig.rays is not None:
        reads_rays = rig.rays
    else:
        reads_rays = are_rays(measurements)
    return model.as_ray_cone(half_aperture_of(rig)) if reads_rays else model


def estimated_sonar(
    measurements: Measurements, model: EchoModel, features: Sequence[Hypothesis], *, prior_mean: float
) -> EchoModel:
    """Return the model with estimated figure of merit and beam, or ray cone; unchanged if too few landmarks are clear.

    ``prior_mean`` is the figure of merit expected of the rig [dB].
    """
    if model.cone:
        return fit_cone(measurements, model, features)
    return fit_figure_of_merit(measurements, model, features, prior_mean=prior_mean)


def walking(model: EchoModel, solution: Solution | None, noise: float) -> EchoModel:
    """Return the model with a range walk that is fitted to the residuals of a solution.

    It is unchanged for ray cones, if there are too few readings, and if the fitted walk does not decrease with excess.
    ``noise`` is the standard deviation of a reading [m].
    """
    explained = np.zeros(0, dtype=np.int64) if solution is None else np.flatnonzero(solution.owners >= 0)
    pieces = min(_PIECES, len(explained) // _A_PIECE)
    if solution is None or model.cone or pieces < 2:
        return model
    excess = np.maximum(solution.excesses[explained], 0.0)
    shape = model.walk.blurred(model.excess_scale)(excess) ** model.walk_exponent
    late = solution.residuals[explained] + model.walk_gain * shape
    weights = 1.0 / model.variances(excess, noise=noise)
    try:
        curve, fall = fitted_walk(excess, late, weights=weights, pieces=pieces)
    except InvalidValueError:
        return model
    return replace(model, walk=curve, walk_gain=fall, walk_exponent=1.0)


def half_aperture_of(rig: Rig) -> float:
    """Return half of the opening angle of the sensors of a rig, the median if they differ [rad]."""
    return float(np.median([sensor.half_aperture for sensor in rig.sensors]))
