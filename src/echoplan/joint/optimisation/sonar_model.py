"""What sonar a rig has: what to expect, and what is learned from who heard what."""

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

# That of the burst, one fitted to the recording, or a table of signal excess [dB] and what it is read too far by [m].
Walk: TypeAlias = str | Sequence[tuple[float, float]]

# Fewer pings do not tell a piece of a walk, and more pieces tell no more.
_A_PIECE, _PIECES = 25, 24


def expected_sonar(
    rig: Rig, measurements: Measurements, known: EchoModel | None = None, *, walk: Walk = "physical"
) -> EchoModel:
    """Tell what to expect of a sonar.

    Parameters
    ----------
    rig : Rig
        What heard it; if it does not tell whether readings are those of rays, they tell themselves.
    measurements : Measurements
        The pings.
    known : EchoModel, optional
        What was learned from earlier pings.
    walk : str or sequence of tuple of float, optional
        Range walk: "physical", "fitted" or a table.

    Returns
    -------
    EchoModel
        That of the transducer, or of one that is usual, in the air of the day; or a cone of rays.

    Raises
    ------
    InvalidValueError
        If a table is out of order.
    """
    transducer = rig.transducer or typical_transducer(rig.sensors[0])
    model = EchoModel.of(transducer).scaled(expected_scale(rig, measurements.temperature))
    if walk == "fitted" and known is not None:
        model = replace(model, walk=known.walk, walk_gain=known.walk_gain)
    elif not isinstance(walk, str):
        excess, late = np.array(walk, dtype=np.float64).reshape(-1, 2).T
        model = replace(model, walk=WalkCurve.from_table(excess, late), walk_gain=float(late[0] - late[-1]))
    return model.seeing(half_aperture_of(rig)) if _reads_rays(rig, measurements, known) else model


def estimated_sonar(
    measurements: Measurements, model: EchoModel, features: Sequence[Hypothesis], *, prior_mean: float
) -> EchoModel:
    """Learn figure of merit and beam of a sonar, or the cone of rays.

    Parameters
    ----------
    measurements : Measurements
        The pings.
    model : EchoModel
        The sonar so far.
    features : sequence of Hypothesis
        What is there.
    prior_mean : float
        Figure of merit that the rig leads one to expect [dB].

    Returns
    -------
    EchoModel
        Another one; the given one where nothing is clear enough.
    """
    if model.cone:
        return fit_cone(measurements, model, features)
    return fit_figure_of_merit(measurements, model, features, prior_mean=prior_mean)


def walking(model: EchoModel, solution: Solution | None, noise: float) -> EchoModel:
    """Fit the range walk to what is left of the readings.

    Parameters
    ----------
    model : EchoModel
        The sonar so far.
    solution : Solution
        Features, and what is left, if any were adjusted.
    noise : float
        Standard deviation of readings [m].

    Returns
    -------
    EchoModel
        With another walk; the given one for rays, and where there are too few readings or no walk falls with loudness.
    """
    explained = np.zeros(0, dtype=np.int64) if solution is None else np.flatnonzero(solution.owners >= 0)
    pieces = min(_PIECES, len(explained) // _A_PIECE)
    if solution is None or model.cone or pieces < 2:
        return model
    excess = np.maximum(solution.excesses[explained], 0.0)
    shape = model.walk.blurred(model.spread)(excess) ** model.walk_exponent
    late = solution.residuals[explained] + model.walk_gain * shape
    weights = 1.0 / model.variances(excess, noise=noise)
    try:
        curve, fall = fitted_walk(excess, late, weights=weights, pieces=pieces)
    except InvalidValueError:
        return model
    return replace(model, walk=curve, walk_gain=fall, walk_exponent=1.0)


def half_aperture_of(rig: Rig) -> float:
    """Tell half of the opening angle of the sensors, where they differ the median [rad].

    Parameters
    ----------
    rig : Rig
        What heard it.

    Returns
    -------
    float
        The angle [rad].
    """
    return float(np.median([sensor.half_aperture for sensor in rig.sensors]))


def _reads_rays(rig: Rig, measurements: Measurements, known: EchoModel | None) -> bool:
    if known is not None:
        return known.cone > 0.0
    return are_rays(measurements) if rig.rays is None else rig.rays
