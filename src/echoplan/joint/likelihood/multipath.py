"""Multipath of landmarks: double bounces, crosstalk, and oblique returns of ray cones."""

import math
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np

from echoplan.acoustics.predicted_echo import Kind, SonarTables
from echoplan.arrays import FloatArray, IntArray
from echoplan.compiled import compiled, inlined
from echoplan.joint.likelihood.crosstalk import Emissions, add_crosstalk, emissions_of
from echoplan.joint.likelihood.double_bounces import add_ghosts_of_cylinder, add_ghosts_of_walls
from echoplan.joint.likelihood.hypothesis import Hypothesis, Key
from echoplan.joint.likelihood.image_sources import Extent, farthest_audible
from echoplan.joint.likelihood.ping_scores import NO_ECHO
from echoplan.joint.likelihood.ray_cone_returns import flanks_of
from echoplan.joint.likelihood.tangents import PATHS, tangents
from echoplan.kernels import doubled
from echoplan.preprocessing.measurements import Measurements

__all__ = ["STRETCH", "Multipath", "Part", "reflecting"]

# A wall reflects multipath up to the first distance beyond its extent, or up to a crossing within the second [m].
STRETCH, _TO_CROSSING = 0.4, 2.0
# Sine of the angle below which two walls count as parallel: they cross too far away.
_PARALLEL = 0.1
_WALL, _CYLINDER = int(Kind.WALL), int(Kind.CYLINDER)

# Explained pings, and the log densities of their readings [log 1/m].
Ghost: TypeAlias = tuple[IntArray, FloatArray]


class Part(NamedTuple):
    """Readings that one landmark or a pair of landmarks explains."""

    # Indices of both landmarks; the same index twice for one.
    owners: tuple[int, int]
    # Indices of the pings, shape (k,).
    pings: IntArray
    # Log densities of their readings [log 1/m], shape (k,).
    log_densities: FloatArray


class Multipath:
    """Multipath of landmarks, computed once per pair: most pairs explain no ping, and that is cached, too.

    ``noise`` is the standard deviation of readings [m]. ``before`` holds the multipath of the same pings for other
    poses or another sonar model: its list of emissions is reused if it still applies.
    """

    def __init__(
        self, measurements: Measurements, tables: SonarTables, noise: float, *, before: "Multipath | None" = None
    ) -> None:
        self._measurements = measurements
        self._tables = tables
        self._noise = noise
        self._emissions: Emissions | None = before.emissions_if(measurements, tables) if before else None
        self._parts: dict[tuple[Key, ...], list[Part]] = {}
        self._numbers: dict[Key, int] = {}
        # By number of the first landmark, in order of appearance: the partners that were computed, and those that
        # explain pings.
        self._tried: defaultdict[int, set[int]] = defaultdict(set)
        self._ghosts: defaultdict[int, dict[int, Ghost]] = defaultdict(dict)

    def emissions_if(self, measurements: Measurements, tables: SonarTables) -> Emissions | None:
        """Return the listed emissions if they hold for other poses and another sonar model, None otherwise.

        They depend on readings, range scale and detectable depth only.
        """
        same = (
            measurements.readings is self._measurements.readings
            and measurements.crosstalk_sources is self._measurements.crosstalk_sources
        )
        return self._emissions if same and _range_of(tables) == _range_of(self._tables) else None

    def parts(self, features: Sequence[Hypothesis]) -> Sequence[Part]:
        """Return the multipath of distinct landmarks, as far as it explains readings."""
        keys = tuple(each.key for each in features)
        if keys not in self._parts:
            numbers = [self._numbers.setdefault(key, len(self._numbers)) for key in keys]
            self._parts[keys] = list(self._worked_out(dict(zip(numbers, features, strict=True))))
        return self._parts[keys]

    def _worked_out(self, numbered: Mapping[int, Hypothesis]) -> Iterator[Part]:
        """Compute the pairs that are not cached, and yield all that explain readings."""
        pairs = _met if self._tables.cone else _casting
        self._try(numbered, [(one, other) for one, others in pairs(numbered) for other in others - self._tried[one]])
        places = {number: place for place, number in enumerate(numbered)}
        for one, others in pairs(numbered):
            ghosts = self._ghosts[one]
            for other in ghosts.keys() & others:
                yield Part((places[one], places[other]), *ghosts[other])

    def _try(self, numbered: Mapping[int, Hypothesis], pairs: Sequence[tuple[int, int]]) -> None:
        """Compute and cache the multipath of pairs, for ray cones or for sound."""
        if pairs:
            learn = self._compute_oblique_returns if self._tables.cone else self._compute
            learn(numbered, pairs)

    def _compute_oblique_returns(self, numbered: Mapping[int, Hypothesis], pairs: Sequence[tuple[int, int]]) -> None:
        """Compute the oblique returns of ray cones; rays have no second reflection."""
        for one, _ in pairs:
            extent = numbered[one].extent
            ends = extent[0] - _TO_CROSSING, extent[1] + _TO_CROSSING
            log_densities = flanks_of(self._measurements, self._tables, numbered[one].reflector, ends, self._noise)
            pings = np.flatnonzero(log_densities > NO_ECHO)
            self._remember((one, one), (pings, log_densities[pings]))

    def _compute(self, numbered: Mapping[int, Hypothesis], pairs: Sequence[tuple[int, int]]) -> None:
        """Compute double bounces and crosstalk of pairs of landmarks, and inside round walls."""
        flat = [pair for pair in pairs if numbered[pair[0]].is_wall]
        if flat:
            self._compute_between(numbered, flat)
        for one, _ in pairs:
            if numbered[one].kind is Kind.ROUND:
                self._remember((one, one), self._compute_inside(numbered[one].reflector))

    def _compute_between(self, numbered: Mapping[int, Hypothesis], pairs: Sequence[tuple[int, int]]) -> None:
        """Compute double bounces and crosstalk of pairs of walls, or of a wall and a cylinder."""
        places = {number: place for place, number in enumerate(numbered)}
        landmarks = (
            np.array([each.reflector for each in numbered.values()]),
            np.array([e.extent for e in numbered.values()]),
        )
        inputs = self._measurements, self._tables, self._listed_emissions()
        wanted = np.array([(places[one], places[other]) for one, other in pairs])
        bounds, pings, log_densities = _cast(*inputs, landmarks, wanted, self._noise)
        for pair, low, high in zip(pairs, bounds[:-1].tolist(), bounds[1:].tolist(), strict=True):
            self._remember(pair, (pings[low:high], log_densities[low:high]))

    def _compute_inside(self, round_wall: FloatArray) -> Ghost:
        """Compute crosstalk and double bounces inside a round wall, which looks different from each station."""
        stations, log_densities = self._measurements.stations, np.full(len(self._measurements.readings), NO_ECHO)
        emissions = self._listed_emissions()
        for station, center_xy in enumerate(self._measurements.centers):
            # All other stations have no emissions.
            first, last = emissions.bounds[station : station + 2]
            bounds = np.where(np.arange(len(emissions.bounds)) <= station, first, last)
            inputs = self._measurements, self._tables, emissions._replace(bounds=bounds)
            _, pings, found = _cast(*inputs, tangents(round_wall, center_xy), PATHS, self._noise)
            own = stations[pings] == station
            np.maximum.at(log_densities, pings[own], found[own])
        pings = np.flatnonzero(log_densities > NO_ECHO)
        return pings, log_densities[pings]

    def _listed_emissions(self) -> Emissions:
        if self._emissions is None:
            self._emissions = emissions_of(self._measurements, self._tables)
        return self._emissions

    def _remember(self, pair: tuple[int, int], ghost: Ghost) -> None:
        one, other = pair
        self._tried[one].add(other)
        if len(ghost[0]):
            self._ghosts[one][other] = ghost


def _range_of(tables: SonarTables) -> tuple[float, float]:
    """Return the range scale and the greatest detectable depth [m], on which the list of emissions depends."""
    return tables.scale, farthest_audible(tables)


def _casting(numbered: Mapping[int, Hypothesis]) -> Iterator[tuple[int, set[int]]]:
    """Yield each wall with its partners in multipath: itself, the walls after it, and all cylinders.

    A round wall has no partner but itself. No station needs to detect both: a wall also reflects sound toward another
    one from where its own echo does not return.
    """
    others = {number for number, each in numbered.items() if each.reflector[0] == _CYLINDER}
    yield from ((number, {number}) for number, each in numbered.items() if each.kind is Kind.ROUND)
    for number, each in reversed(list(numbered.items())):
        if each.is_wall:
            others.add(number)
            yield number, others


def _met(numbered: Mapping[int, Hypothesis]) -> Iterator[tuple[int, set[int]]]:
    """Yield each wall and cylinder as its own partner, for the oblique returns of rays."""
    yield from ((number, {number}) for number, each in numbered.items() if each.type.is_surface)


@compiled
def _cast(
    measurements: Measurements,
    tables: SonarTables,
    emissions: Emissions,
    features: tuple[FloatArray, FloatArray],
    pairs: IntArray,
    noise: float,
) -> tuple[IntArray, IntArray, FloatArray]:
    """Compute the multipath of pairs: bounds of each pair in the other arrays, pings, and log densities [log 1/m]."""
    reflectors, extents = features
    count, bounds, log_densities = (
        0,
        np.zeros(len(pairs) + 1, np.int64),
        np.full(len(measurements.readings), NO_ECHO),
    )
    pings, densities = np.empty(len(log_densities), np.int64), np.empty(len(log_densities))
    for number in range(len(pairs)):
        one, other = pairs[number]
        pair = reflectors[one], reflectors[other]
        ends = reflecting(pair, ((extents[one, 0], extents[one, 1]), (extents[other, 0], extents[other, 1])))
        _cast_by(log_densities, (measurements, tables, emissions), pair, ends, noise)
        if count + len(log_densities) > len(pings):
            pings, densities = doubled(pings), doubled(densities)
        for ping in range(len(log_densities)):
            if log_densities[ping] > NO_ECHO:
                pings[count], densities[count], log_densities[ping] = ping, log_densities[ping], NO_ECHO
                count += 1
        bounds[number + 1] = count
    return bounds, pings[:count].copy(), densities[:count].copy()


@inlined
def _cast_by(
    log_densities: FloatArray,
    inputs: tuple[Measurements, SonarTables, Emissions],
    pair: tuple[FloatArray, FloatArray],
    ends: tuple[Extent, Extent],
    noise: float,
) -> None:
    """Raise log densities in place where multipath of a pair explains a reading better."""
    if pair[1][0] != _WALL:
        add_ghosts_of_cylinder(log_densities, (inputs[0], inputs[1]), pair[0], pair[1], noise)
        return
    add_crosstalk(log_densities, inputs, pair, ends, noise)
    if not (pair[0] == pair[1]).all():
        add_crosstalk(log_densities, inputs, (pair[1], pair[0]), (ends[1], ends[0]), noise)
        add_ghosts_of_walls(log_densities, (inputs[0], inputs[1]), pair, ends, noise)


@compiled
def reflecting(walls: tuple[FloatArray, FloatArray], extents: tuple[Extent, Extent]) -> tuple[Extent, Extent]:
    """Return the parts of two walls that reflect multipath [m].

    They are a little longer than the extents, and reach a crossing of the walls that is near.
    """
    angle, offset, turned, beyond = walls[0][1], walls[0][2], walls[1][1], walls[1][2]
    across = math.sin(turned - angle)
    if abs(across) < _PARALLEL:
        return _stretched(extents[0], math.nan), _stretched(extents[1], math.nan)
    # Position of the crossing along each line, from the equations n · x = d of both.
    along = math.cos(turned - angle)
    return (
        _stretched(extents[0], (beyond - offset * along) / across),
        _stretched(extents[1], (beyond * along - offset) / across),
    )


@inlined
def _stretched(extent: Extent, place: float) -> Extent:
    """Return an extent enlarged by ``STRETCH`` and up to a crossing near its ends; ``nan`` stands for no crossing."""
    low, high = extent[0] - STRETCH, extent[1] + STRETCH
    if max(extent[0] - place, place - extent[1]) <= _TO_CROSSING:
        low, high = min(low, place - 0.05), max(high, place + 0.05)
    return low, high
