"""What sonar a rig has: what to expect, and what is learned from who heard what."""

from collections.abc import Sequence

import numpy as np

from echoplan.acoustics import typical_transducer
from echoplan.acoustics.expectation import EchoModel
from echoplan.classification.hypotheses import Hypothesis
from echoplan.mapping.cones import fit_cone
from echoplan.mapping.loudness import fit_loudness
from echoplan.model import Rig
from echoplan.preprocessing import expected_scale
from echoplan.preprocessing.rays import share_of_ramps
from echoplan.preprocessing.soundings import Soundings

__all__ = ["expected_sonar", "half_aperture_of", "learned_sonar"]

# Of the readings of sound hardly one in a hundred is in a ramp; of rays, with a centimetre of noise, one in ten.
_RAMPS = 0.05


def expected_sonar(rig: Rig, heard: Soundings, known: EchoModel | None = None) -> EchoModel:
    """Tell what to expect of a sonar.

    Parameters
    ----------
    rig : Rig
        What heard it; if it does not tell whether readings are those of rays, they tell themselves.
    heard : Soundings
        The pings.
    known : EchoModel, optional
        What was learned from earlier pings.

    Returns
    -------
    EchoModel
        That of the transducer, or of one that is usual, in the air of the day; or a cone of rays.
    """
    transducer = rig.transducer or typical_transducer(rig.sensors[0])
    model = EchoModel.of(transducer).scaled(expected_scale(rig, heard.temperature))
    return model.seeing(half_aperture_of(rig)) if _reads_rays(rig, heard, known) else model


def learned_sonar(
    soundings: Soundings, model: EchoModel, features: Sequence[Hypothesis], *, believed: float
) -> EchoModel:
    """Learn figure of merit and beam of a sonar, or the cone of rays.

    Parameters
    ----------
    soundings : Soundings
        The pings.
    model : EchoModel
        The sonar so far.
    features : sequence of Hypothesis
        What is there.
    believed : float
        Figure of merit that the rig leads one to expect [dB].

    Returns
    -------
    EchoModel
        Another one; the given one where nothing is clear enough.
    """
    if model.cone:
        return fit_cone(soundings, model, features)
    return fit_loudness(soundings, model, features, believed=believed)


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


def _reads_rays(rig: Rig, heard: Soundings, known: EchoModel | None) -> bool:
    if known is not None:
        return known.cone > 0.0
    return share_of_ramps(heard) > _RAMPS if rig.rays is None else rig.rays
