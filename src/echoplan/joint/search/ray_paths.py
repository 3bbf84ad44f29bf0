"""Paths of sound from sensors to the specular points of landmarks."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.geometry import directions
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.ping_likelihood import PingLikelihood
from echoplan.joint.likelihood.ping_scores import NO_ECHO
from echoplan.preprocessing.measurements import Measurements

__all__ = ["Paths", "trace_paths", "unoccluded_stations"]

# Log-likelihood ratio over clutter from which a reading counts as explained [nats].
_EXPLAINED = math.log(20.0)
# Smallest angle that pings of one landmark from one station must span, as fewer may agree by chance [rad].
_SPAN = math.radians(12.0)
# A station has a free view of a landmark if this share of the pings that should detect it is unmasked.
_MOSTLY = 0.5
# A wall may have a gap at this distance along it from any detection [m].
_BESIDE = 0.2
# A path crosses a line only if the sensor is this far from it [m].
_CLEAR = 0.02
# Objects less than this behind a wall may be before it, given the errors of walls and poses [m].
_BEYOND = 0.05


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Paths:
    """Paths of the sound that landmarks reflected, by ping."""

    # Sensors and specular points [m], shape (n, 2); ``nan`` for unexplained pings.
    starts_xy: FloatArray
    ends_xy: FloatArray
    # Index of the landmark that explains each ping, shape (n,); -1 for none.
    owners: IntArray
    # Whether enough other pings of the station agree, shape (n,).
    sure: BoolArray
    # Station of each ping, shape (n,).
    stations: IntArray

    def chosen(self, pings: BoolArray) -> "Paths":
        """Select the paths of some pings, shape (n,)."""
        return Paths(
            starts_xy=self.starts_xy[pings],
            ends_xy=self.ends_xy[pings],
            owners=self.owners[pings],
            sure=self.sure[pings],
            stations=self.stations[pings],
        )

    def feet(self, owner: int, line: FloatArray) -> FloatArray:
        """Return the specular points of the pings of a wall along its line, sorted [m]."""
        own = self.starts_xy[self.owners == owner]
        places: FloatArray = np.sort(own @ directions(line[0] + math.pi / 2))
        return places

    def bearings(self, owner: int, center_xy: FloatArray) -> FloatArray:
        """Return the specular points of the pings of a round wall as bearings from its centre, sorted [rad]."""
        away = self.ends_xy[self.owners == owner] - center_xy
        bearings: FloatArray = np.sort(np.arctan2(away[:, 1], away[:, 0]))
        return bearings

    def crossings(self, owner: int, line: FloatArray) -> FloatArray:
        """Return where sound of other landmarks crossed the line of a wall [m]: the mean by station and landmark."""
        pings, places = self.through(line)
        others = self.sure[pings] & (self.owners[pings] != owner)
        pings, places = pings[others], places[others]
        _, groups = np.unique(np.column_stack([self.stations[pings], self.owners[pings]]), axis=0, return_inverse=True)
        means: FloatArray = np.bincount(groups.ravel(), places) / np.maximum(np.bincount(groups.ravel()), 1)
        return means

    def through(self, line: FloatArray) -> tuple[IntArray, FloatArray]:
        """Return the indices of pings whose paths cross a line, and the positions of the crossings along it [m].

        A specular point at the line or just behind it does not count: the object may stand before the wall.
        """
        normal, along = directions(line[0]), directions(line[0] + math.pi / 2)
        before, beyond = line[1] - self.starts_xy @ normal, line[1] - self.ends_xy @ normal
        with np.errstate(invalid="ignore"):
            crossed = (before * beyond < 0.0) & (np.abs(before) > _CLEAR) & (np.abs(beyond) > _BEYOND)
        pings = np.flatnonzero(crossed & (self.owners >= 0))
        share = (before[pings] / (before[pings] - beyond[pings]))[:, None]
        starts, ends = self.starts_xy[pings], self.ends_xy[pings]
        places: FloatArray = (starts + share * (ends - starts)) @ along
        return pings, places


def trace_paths(likelihood: PingLikelihood, features: Sequence[Hypothesis], *, step: float) -> Paths:
    """Trace the paths of all pings that a landmark explains better than multipath does.

    ``step`` is the angle from one ping to the next [rad].
    """
    measurements = likelihood.measurements
    starts = np.column_stack([measurements.x, measurements.y])
    beams = np.column_stack([measurements.ux, measurements.uy])
    owners = _owners(likelihood, features)
    ends = np.full_like(starts, np.nan)
    for number, feature in enumerate(features):
        own = owners == number
        ends[own] = _specular_points(feature, starts[own], beams=beams[own])
    groups = measurements.stations * max(len(features), 1) + np.maximum(owners, 0)
    counts = np.bincount(groups[owners >= 0], minlength=int(groups.max(initial=0)) + 1)
    sure = (owners >= 0) & (counts[groups] >= max(1.0, _SPAN / step))
    return Paths(starts_xy=starts, ends_xy=ends, owners=owners, sure=sure, stations=measurements.stations)


def unoccluded_stations(feature: Hypothesis, measurements: Measurements, *, step: float) -> BoolArray:
    """Return which stations should detect a landmark, since they detected nothing nearer, shape (s,).

    Of a wall with a gap, such as a door, the stations in front of the gap are not counted, as they detect nothing.
    ``step`` is the angle from one ping to the next [rad].
    """
    evidence, count = feature.ping_scores, len(measurements.centers)
    stations, asked = measurements.stations[evidence.pings], evidence.audible
    if feature.is_wall:
        asked = asked & (evidence.feet >= feature.extent[0]) & (evidence.feet <= feature.extent[1])
        asked &= _beside(evidence.feet, evidence.feet[asked & (feature.llr_by_station > 0.0)[stations]])
    should = np.bincount(stations[asked], minlength=count)
    could = np.bincount(stations[asked & evidence.unmasked], minlength=count)
    free: BoolArray = (should >= max(1.0, _SPAN / step)) & (could > _MOSTLY * should)
    return free


def _beside(places: FloatArray, detected: FloatArray) -> BoolArray:
    """Return which positions along a wall are near a detection."""
    ends = np.concatenate([[-np.inf], np.sort(detected), [np.inf]])
    after = np.searchsorted(ends, places)
    near: BoolArray = np.minimum(places - ends[np.maximum(after - 1, 0)], ends[after] - places) < _BESIDE
    return near


def _owners(likelihood: PingLikelihood, features: Sequence[Hypothesis]) -> IntArray:
    """Return the index of the landmark that explains each ping, shape (n,); -1 if none does, or if multipath wins."""
    count = len(likelihood.measurements.readings)
    if not features:
        return np.full(count, -1)
    log_densities = np.stack([likelihood.log_densities_of(each) for each in features])
    best = log_densities.max(axis=0)
    explained = (best > likelihood.floor + _EXPLAINED) & (best > likelihood.multipath_log_densities(features))
    return np.where(explained & (best > NO_ECHO), log_densities.argmax(axis=0), -1)


def _specular_points(feature: Hypothesis, starts_xy: FloatArray, *, beams: FloatArray) -> FloatArray:
    """Return the specular points of a landmark for sensors at ``starts_xy`` [m] with unit vectors ``beams``."""
    if feature.is_wall:
        normal = directions(feature.line[0])
        feet: FloatArray = starts_xy + (feature.line[1] - starts_xy @ normal)[:, None] * normal
        return feet
    away = feature.reflector[1:3] - starts_xy
    length = np.hypot(*away.T)[:, None] + 1e-12
    if feature.kind is Kind.ROUND:
        side = np.where(np.sum(away * beams, axis=1, keepdims=True) > 0.0, 1.0, -1.0)
        across: FloatArray = feature.reflector[1:3] + side * feature.reflector[3] * away / length
        return across
    points: FloatArray = starts_xy + away * (length - feature.reflector[3]) / length
    return points
