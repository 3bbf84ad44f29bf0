"""Multipath: what features are heard as by sound that met more of them, or was meant for another ping; rays glide."""

import math
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np

from echoplan.acoustics.predicted_echo import Hearing, Kind
from echoplan.arrays import FloatArray, IntArray
from echoplan.compiled import compiled
from echoplan.joint.likelihood.crosstalk import Emissions, add_crosstalk, emissions_of
from echoplan.joint.likelihood.double_bounces import add_ghosts_of_cylinder, add_ghosts_of_walls
from echoplan.joint.likelihood.hypothesis import Hypothesis, Key
from echoplan.joint.likelihood.image_sources import Extent, farthest_audible
from echoplan.joint.likelihood.ping_scores import UNHEARD
from echoplan.joint.likelihood.ray_cone_returns import flanks_of
from echoplan.preprocessing.measurements import Measurements

__all__ = ["STRETCH", "Multipath", "Part", "reflecting"]

# Walls may reflect so far beyond what was heard of them, or up to a crossing that is no farther [m].
STRETCH, _TO_CROSSING = 0.4, 2.0
# Walls that turn less than this toward each other cross too far away (sine).
_PARALLEL = 0.1
_WALL, _CYLINDER = int(Kind.WALL), int(Kind.CYLINDER)

# Which pings are explained, and the logarithms of the densities of their readings.
Ghost: TypeAlias = tuple[IntArray, FloatArray]


class Part(NamedTuple):
    """What one feature, or two together, explain.

    Attributes
    ----------
    owners : tuple of int
        Numbers of the features; of one alone twice.
    pings : ndarray of int, shape (k,)
        Which pings.
    log_densities : ndarray, shape (k,)
        Logarithm of the density of their readings [log 1/m].
    """

    owners: tuple[int, int]
    pings: IntArray
    log_densities: FloatArray


class Multipath:
    """Ghosts of features, worked out once: most explain nothing, and are remembered as such.

    Parameters
    ----------
    measurements : Measurements
        The pings.
    hearing : Hearing
        The sonar.
    noise : float
        Standard deviation of readings [m].
    before : Multipath, optional
        Of the same pings from other poses, or with another sonar: bursts that come as far are not listed again.
    """

    def __init__(
        self, measurements: Measurements, hearing: Hearing, noise: float, *, before: "Multipath | None" = None
    ) -> None:
        self._measurements = measurements
        self._hearing = hearing
        self._noise = noise
        self._emissions: Emissions | None = before.emissions_if(measurements, hearing) if before else None
        self._parts: dict[tuple[Key, ...], list[Part]] = {}
        self._numbers: dict[Key, int] = {}
        # By number of the first feature, in the order in which they come: with which it was tried, and what came of it.
        self._tried: defaultdict[int, set[int]] = defaultdict(set)
        self._ghosts: defaultdict[int, dict[int, Ghost]] = defaultdict(dict)

    def emissions_if(self, measurements: Measurements, hearing: Hearing) -> Emissions | None:
        """Tell the bursts that were listed, if others would be the same: how far each has come no pose tells.

        Parameters
        ----------
        measurements : Measurements
            The others.
        hearing : Hearing
            Their sonar.

        Returns
        -------
        Emissions or None
            Nothing if none were listed, or others would be listed.
        """
        same = (
            measurements.readings is self._measurements.readings
            and measurements.crosstalk_sources is self._measurements.crosstalk_sources
        )
        return self._emissions if same and _range_of(hearing) == _range_of(self._hearing) else None

    def parts(self, features: Sequence[Hypothesis]) -> Sequence[Part]:
        """Work out the ghosts of features.

        Parameters
        ----------
        features : sequence of Hypothesis
            What casts them; none of them twice.

        Returns
        -------
        sequence of Part
            The ghosts that explain something.
        """
        keys = tuple(each.key for each in features)
        if keys not in self._parts:
            numbers = [self._numbers.setdefault(key, len(self._numbers)) for key in keys]
            self._parts[keys] = list(self._worked_out(dict(zip(numbers, features, strict=True))))
        return self._parts[keys]

    def _worked_out(self, numbered: Mapping[int, Hypothesis]) -> Iterator[Part]:
        pairs = _met if self._hearing.cone else _casting
        self._try(numbered, [(one, other) for one, others in pairs(numbered) for other in others - self._tried[one]])
        places = {number: place for place, number in enumerate(numbered)}
        for one, others in pairs(numbered):
            ghosts = self._ghosts[one]
            for other in ghosts.keys() & others:
                yield Part((places[one], places[other]), *ghosts[other])

    def _try(self, numbered: Mapping[int, Hypothesis], pairs: Sequence[tuple[int, int]]) -> None:
        if pairs:
            learn = self._glide if self._hearing.cone else self._learn
            learn(numbered, pairs)

    def _glide(self, numbered: Mapping[int, Hypothesis], pairs: Sequence[tuple[int, int]]) -> None:
        """Rays do not glance off anything; what they meet aslant they read."""
        for one, _ in pairs:
            extent = numbered[one].extent
            ends = extent[0] - _TO_CROSSING, extent[1] + _TO_CROSSING
            log_densities = flanks_of(self._measurements, self._hearing, numbered[one].reflector, ends, self._noise)
            pings = np.flatnonzero(log_densities > UNHEARD)
            self._remember((one, one), (pings, log_densities[pings]))

    def _learn(self, numbered: Mapping[int, Hypothesis], pairs: Sequence[tuple[int, int]]) -> None:
        if self._emissions is None:
            self._emissions = emissions_of(self._measurements, self._hearing)
        places = {number: place for place, number in enumerate(numbered)}
        landmarks = (
            np.array([each.reflector for each in numbered.values()]),
            np.array([e.extent for e in numbered.values()]),
        )
        detected = self._measurements, self._hearing, self._emissions
        wanted = np.array([(places[one], places[other]) for one, other in pairs])
        bounds, pings, log_densities = _cast(*detected, landmarks, wanted, self._noise)
        for pair, low, high in zip(pairs, bounds[:-1].tolist(), bounds[1:].tolist(), strict=True):
            self._remember(pair, (pings[low:high], log_densities[low:high]))

    def _remember(self, pair: tuple[int, int], ghost: Ghost) -> None:
        one, other = pair
        self._tried[one].add(other)
        if len(ghost[0]):
            self._ghosts[one][other] = ghost


def _range_of(hearing: Hearing) -> tuple[float, float]:
    """How far readings are, and how far sound is heard."""
    return hearing.scale, farthest_audible(hearing)


def _casting(numbered: Mapping[int, Hypothesis]) -> Iterator[tuple[int, set[int]]]:
    """List the walls that may cast ghosts, each with what it casts them with: itself, walls after it, and cylinders.

    Nobody need have heard both: a wall reflects sound on to another from places whence its own echo does not come back.
    """
    others = {number for number, each in numbered.items() if each.reflector[0] == _CYLINDER}
    for number, each in reversed(list(numbered.items())):
        if each.is_wall:
            others.add(number)
            yield number, others


def _met(numbered: Mapping[int, Hypothesis]) -> Iterator[tuple[int, set[int]]]:
    """List the features that rays may meet aslant: each by itself."""
    yield from ((number, {number}) for number, each in numbered.items() if each.reflector[0] in (_WALL, _CYLINDER))


@compiled
def _cast(
    measurements: Measurements,
    hearing: Hearing,
    emissions: Emissions,
    features: tuple[FloatArray, FloatArray],
    pairs: IntArray,
    noise: float,
) -> tuple[IntArray, IntArray, FloatArray]:
    """Work out the ghosts of many pairs: where those of each begin and end, their pings and their levels."""
    reflectors, extents = features
    count, bounds, log_densities = 0, np.zeros(len(pairs) + 1, np.int64), np.full(len(measurements.readings), UNHEARD)
    pings, densities = np.empty(len(log_densities), np.int64), np.empty(len(log_densities))
    for number in range(len(pairs)):
        one, other = pairs[number]
        pair = reflectors[one], reflectors[other]
        ends = reflecting(pair, ((extents[one, 0], extents[one, 1]), (extents[other, 0], extents[other, 1])))
        _cast_by(log_densities, (measurements, hearing, emissions), pair, ends, noise)
        if count + len(log_densities) > len(pings):
            pings, densities = np.append(pings, np.empty_like(pings)), np.append(densities, np.empty_like(densities))
        for ping in np.flatnonzero(log_densities > UNHEARD):
            pings[count], densities[count], log_densities[ping] = ping, log_densities[ping], UNHEARD
            count += 1
        bounds[number + 1] = count
    return bounds, pings[:count].copy(), densities[:count].copy()


@compiled
def _cast_by(
    log_densities: FloatArray,
    detected: tuple[Measurements, Hearing, Emissions],
    pair: tuple[FloatArray, FloatArray],
    ends: tuple[Extent, Extent],
    noise: float,
) -> None:
    """Raise levels where ghosts of a pair explain readings better."""
    if pair[1][0] != _WALL:
        add_ghosts_of_cylinder(log_densities, (detected[0], detected[1]), pair[0], pair[1], noise)
        return
    add_crosstalk(log_densities, detected, pair, ends, noise)
    if not (pair[0] == pair[1]).all():
        add_crosstalk(log_densities, detected, (pair[1], pair[0]), (ends[1], ends[0]), noise)
        add_ghosts_of_walls(log_densities, (detected[0], detected[1]), pair, ends, noise)


@compiled
def reflecting(walls: tuple[FloatArray, FloatArray], extents: tuple[Extent, Extent]) -> tuple[Extent, Extent]:
    """Tell where two walls may reflect: as far as they were heard and a little more, or up to where they meet.

    Parameters
    ----------
    walls : tuple of ndarray, shape (4,)
        The walls; twice the same for one alone.
    extents : tuple of Extent
        Between which places each was heard [m].

    Returns
    -------
    tuple of Extent
        Between which places each may reflect [m].
    """
    angle, offset, turned, beyond = walls[0][1], walls[0][2], walls[1][1], walls[1][2]
    across = math.sin(turned - angle)
    if abs(across) < _PARALLEL:
        return _stretched(extents[0], math.nan), _stretched(extents[1], math.nan)
    # The crossing lies on both lines: along each, as far as the other's offset less its own, turned, leaves over.
    along = math.cos(turned - angle)
    return (
        _stretched(extents[0], (beyond - offset * along) / across),
        _stretched(extents[1], (beyond * along - offset) / across),
    )


@compiled
def _stretched(extent: Extent, place: float) -> Extent:
    low, high = extent[0] - STRETCH, extent[1] + STRETCH
    if max(extent[0] - place, place - extent[1]) <= _TO_CROSSING:
        low, high = min(low, place - 0.05), max(high, place + 0.05)
    return low, high
