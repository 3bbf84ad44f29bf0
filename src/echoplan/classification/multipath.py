"""Multipath: what features are heard as by sound that met more than one of them, or was meant for another ping."""

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from echoplan.acoustics.expectation import Hearing, Kind
from echoplan.arrays import FloatArray
from echoplan.classification.evidence import UNHEARD
from echoplan.classification.ghosts import ghosts_of_cylinder, ghosts_of_walls
from echoplan.classification.hypotheses import Hypothesis, Key
from echoplan.classification.volleys import Volleys, bursts_of, volleys_over
from echoplan.preprocessing.soundings import Soundings

__all__ = ["Multipath", "Part"]

# Walls may reflect so far beyond what was heard of them, or up to a crossing that is no farther [m].
_STRETCH, _TO_CROSSING = 0.4, 2.0
# Walls that turn less than this toward each other cross too far away (sine).
_PARALLEL = 0.1


class Part(NamedTuple):
    """What one feature, or several together, explain.

    Attributes
    ----------
    owners : tuple of int
        Numbers of the features.
    levels : ndarray, shape (n,)
        Logarithm of the density of each reading [log 1/m]; ``UNHEARD`` where it is not explained.
    """

    owners: tuple[int, ...]
    levels: FloatArray


class Multipath:
    """Ghosts of features, worked out once: most explain nothing, and are remembered as such.

    Parameters
    ----------
    soundings : Soundings
        The pings.
    hearing : Hearing
        The sonar.
    noise : float
        Standard deviation of readings [m].
    """

    def __init__(self, soundings: Soundings, hearing: Hearing, noise: float) -> None:
        self._soundings = soundings
        self._hearing = hearing
        self._noise = noise
        self._bursts = bursts_of(soundings, hearing)
        self._known: dict[Key, FloatArray | None] = {}
        self._volleys: dict[Key, Volleys] = {}

    def parts(self, features: Sequence[Hypothesis]) -> Iterator[Part]:
        """Work out the ghosts of features.

        Parameters
        ----------
        features : sequence of Hypothesis
            What casts them.

        Yields
        ------
        Part
            A ghost that explains something.
        """
        keys = [each.key for each in features]
        for owners in _casting(features):
            key = sum((keys[each] for each in owners), ())
            levels = self._once(key, partial(self._cast_by, [features[each] for each in owners]))
            if levels is not None:
                yield Part(owners, levels)

    def mirrored(self, wall: Hypothesis, other: Hypothesis) -> FloatArray | None:
        """Explain pings by echoes of one wall in another.

        Parameters
        ----------
        wall, other : Hypothesis
            Two walls.

        Returns
        -------
        ndarray, shape (n,), or None
            As ``Part.levels``; nothing if there is no such echo.
        """
        return self._once(("mirrored", *wall.key, *other.key), partial(self._of_images, wall, other))

    def _cast_by(self, owners: Sequence[Hypothesis]) -> FloatArray:
        wall, other = owners[0], owners[-1]
        if other is wall:
            levels = np.full(len(self._soundings.readings), UNHEARD)
            self._add_volleys(levels, [wall], [_stretched(wall, None)])
            return levels
        return self._of_walls(wall, other) if other.is_wall else self._of_cylinder(wall, other)

    def _of_walls(self, wall: Hypothesis, other: Hypothesis) -> FloatArray:
        levels = self.mirrored(wall, other)
        levels = np.full(len(self._soundings.readings), UNHEARD) if levels is None else levels.copy()
        first, second = _reflecting(wall, other)
        self._add_volleys(levels, [wall, other], [first, second])
        self._add_volleys(levels, [other, wall], [second, first])
        return levels

    def _of_images(self, wall: Hypothesis, other: Hypothesis) -> FloatArray:
        pair, extents = (wall.reflector, other.reflector), _reflecting(wall, other)
        return ghosts_of_walls(self._soundings, self._hearing, pair, extents, self._noise)

    def _of_cylinder(self, wall: Hypothesis, cylinder: Hypothesis) -> FloatArray:
        return ghosts_of_cylinder(self._soundings, self._hearing, wall.reflector, cylinder.reflector, self._noise)

    def _add_volleys(self, levels: FloatArray, walls: Sequence[Hypothesis], extents: Sequence[FloatArray]) -> None:
        """Raise levels to what volleys over some walls explain, in the order in which the sound strikes them."""
        reflectors = np.array([each.reflector for each in walls])
        key = tuple(reflectors.ravel().tolist())
        if key not in self._volleys:
            self._volleys[key] = volleys_over(self._soundings, self._hearing, self._bursts, reflectors, self._noise)
        volleys = self._volleys[key]
        if len(volleys.pings):
            np.maximum(levels, volleys.within(np.array(extents), len(levels)), out=levels)

    def _once(self, key: Key, explain: Callable[[], FloatArray]) -> FloatArray | None:
        if key not in self._known:
            levels = explain()
            self._known[key] = levels if levels.max(initial=UNHEARD) > UNHEARD else None
        return self._known[key]


def _casting(features: Sequence[Hypothesis]) -> Iterator[tuple[int, ...]]:
    """List the walls that may cast ghosts, alone and with another wall or a cylinder.

    Nobody need have heard both: a wall reflects sound on to another from places whence its own echo does not come back.
    """
    walls = [number for number, each in enumerate(features) if each.is_wall]
    columns = [number for number, each in enumerate(features) if each.kind is Kind.CYLINDER]
    for place, one in enumerate(walls):
        yield (one,)
        yield from ((one, other) for other in walls[place + 1 :] + columns)


def _reflecting(wall: Hypothesis, other: Hypothesis) -> tuple[FloatArray, FloatArray]:
    """Where two walls may reflect: as far as they were heard and a little more, or up to where they meet."""
    (angle, offset), (turned, beyond) = wall.line.tolist(), other.line.tolist()
    across = math.sin(turned - angle)
    if abs(across) < _PARALLEL:
        return _stretched(wall, None), _stretched(other, None)
    # The crossing lies on both lines: along each, as far as the other's offset less its own, turned, leaves over.
    along = math.cos(turned - angle)
    return (
        _stretched(wall, (beyond - offset * along) / across),
        _stretched(other, (beyond * along - offset) / across),
    )


def _stretched(wall: Hypothesis, place: float | None) -> FloatArray:
    low, high = wall.extent
    if place is None or max(low - place, place - high) > _TO_CROSSING:
        return np.array([low - _STRETCH, high + _STRETCH])
    return np.array([min(low - _STRETCH, place - 0.05), max(high + _STRETCH, place + 0.05)])
