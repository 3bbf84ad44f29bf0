"""Copies of recordings with a little noise: where poses are searched for, nothing else tells luck from skill."""

from dataclasses import replace

import numpy as np

from echoplan.model import Source, Sweep

__all__ = ["shaken"]

# Noise of copies [m].
SHAKEN = 0.001


def shaken(recording: Source, copy: int | None) -> list[Sweep]:
    """Add a millimetre of noise to readings, which come in centimetres; none if it is no copy.

    Parameters
    ----------
    recording : Source
        What was heard.
    copy : int or None
        Which copy: the seed of its noise.

    Returns
    -------
    list of Sweep
        The same sweeps with noise.
    """
    if copy is None:
        return list(recording)
    rng = np.random.default_rng(copy)
    return [replace(each, ranges=each.ranges + rng.normal(0.0, SHAKEN, len(each))) for each in recording]
