"""Copies of recordings with a little noise: where poses are found by a search, they show how much is luck."""

from dataclasses import replace

import numpy as np

from echoplan.model import Source, Sweep

__all__ = ["noisy_copy"]

# Noise of copies [m].
_NOISE = 0.001


def noisy_copy(recording: Source, copy: int | None) -> list[Sweep]:
    """Add 1 mm of noise to readings with a resolution of 1 cm; none for the recording itself.

    Parameters
    ----------
    recording : Source
        The recording.
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
    return [replace(each, ranges=each.ranges + rng.normal(0.0, _NOISE, len(each))) for each in recording]
