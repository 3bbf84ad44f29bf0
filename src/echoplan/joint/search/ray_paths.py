"""Paths: the ways that sound went from sensors to the points where features sent it back."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.geometry import directions
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.ping_likelihood import PingLikelihood
from echoplan.joint.likelihood.ping_scores import UNHEARD
from echoplan.preprocessing.measurements import Measurements

__all__ = ["Paths", "trace_paths", "unoccluded_stations"]

# A reading that is this many times likelier than if it were anything is explained.
_EXPLAINED = math.log(20.0)
# Groups of pings of one feature and station that span less than this may be chance [rad].
_SPAN = math.radians(12.0)
# A station has a free view of a feature if this share of the pings that should hear it heard nothing nearer.
_MOSTLY = 0.5
# So far along a wall from all that was heard of it there may be a gap in it [m].
_BESIDE = 0.2
# A path crosses a line only if both its ends are this far from it [m].
_CLEAR = 0.02
# What stands less than this behind a wall may stand before it [m]: that well walls and poses are known.
_BEHIND = 0.05


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Paths:
    """Ways of sound that features explain.

    Parameters
    ----------
    starts_xy, ends_xy : ndarray, shape (n, 2)
        Sensors, and where the sound turned back [m]; ``nan`` for pings that nothing explains.
    owners : ndarray of int, shape (n,)
        The feature that explains each ping; -1 for none.
    sure : ndarray of bool, shape (n,)
        Whether enough other pings of the station agree.
    stations : ndarray of int, shape (n,)
        The station that made each ping.
    """

    starts_xy: FloatArray
    ends_xy: FloatArray
    owners: IntArray
    sure: BoolArray
    stations: IntArray

    def chosen(self, pings: BoolArray) -> "Paths":
        """Keep some of them.

        Parameters
        ----------
        pings : ndarray of bool, shape (n,)
            Which.

        Returns
        -------
        Paths
            Those.
        """
        return Paths(
            starts_xy=self.starts_xy[pings],
            ends_xy=self.ends_xy[pings],
            owners=self.owners[pings],
            sure=self.sure[pings],
            stations=self.stations[pings],
        )

    def feet(self, owner: int, line: FloatArray) -> FloatArray:
        """Tell where along a wall the pings that it explains were reflected.

        Parameters
        ----------
        owner : int
            Number of the wall.
        line : ndarray, shape (2,)
            Its normal angle and offset [rad, m].

        Returns
        -------
        ndarray, shape (k,)
            Places along it, in order [m].
        """
        own = self.starts_xy[self.owners == owner]
        places: FloatArray = np.sort(own @ directions(line[0] + math.pi / 2))
        return places

    def crossings(self, owner: int, line: FloatArray) -> FloatArray:
        """Return where sound of other features crossed the line of a wall: one place a station and feature [m]."""
        pings, places = self.through(line, behind=_BEHIND)
        others = self.sure[pings] & (self.owners[pings] != owner)
        pings, places = pings[others], places[others]
        _, groups = np.unique(np.column_stack([self.stations[pings], self.owners[pings]]), axis=0, return_inverse=True)
        means: FloatArray = np.bincount(groups.ravel(), places) / np.maximum(np.bincount(groups.ravel()), 1)
        return means

    def through(self, line: FloatArray, *, behind: float = _CLEAR) -> tuple[IntArray, FloatArray]:
        """Tell which sound went through a line, and where.

        Parameters
        ----------
        line : ndarray, shape (2,)
            Normal angle and offset [rad, m].
        behind : float, optional
            How far beyond it the sound must have turned back [m].

        Returns
        -------
        pings : ndarray of int, shape (k,)
            Which pings.
        places : ndarray, shape (k,)
            Places along the line [m].
        """
        normal, along = directions(line[0]), directions(line[0] + math.pi / 2)
        before, beyond = line[1] - self.starts_xy @ normal, line[1] - self.ends_xy @ normal
        with np.errstate(invalid="ignore"):
            crossed = (before * beyond < 0.0) & (np.abs(before) > _CLEAR) & (np.abs(beyond) > behind)
        pings = np.flatnonzero(crossed & (self.owners >= 0))
        share = (before[pings] / (before[pings] - beyond[pings]))[:, None]
        starts, ends = self.starts_xy[pings], self.ends_xy[pings]
        places: FloatArray = (starts + share * (ends - starts)) @ along
        return pings, places


def trace_paths(likelihood: PingLikelihood, features: Sequence[Hypothesis], *, step: float) -> Paths:
    """Trace the paths of all pings that features explain better than ghosts do.

    Parameters
    ----------
    likelihood : PingLikelihood
        The pings.
    features : sequence of Hypothesis
        What is there.
    step : float
        Turn from one ping to the next [rad].

    Returns
    -------
    Paths
        One a ping.
    """
    measurements = likelihood.measurements
    starts = np.column_stack([measurements.x, measurements.y])
    owners = _owners(likelihood, features)
    ends = np.full_like(starts, np.nan)
    for number, feature in enumerate(features):
        own = owners == number
        ends[own] = _turning_points(feature, starts[own])
    groups = measurements.stations * max(len(features), 1) + np.maximum(owners, 0)
    counts = np.bincount(groups[owners >= 0], minlength=int(groups.max(initial=0)) + 1)
    sure = (owners >= 0) & (counts[groups] >= max(1.0, _SPAN / step))
    return Paths(starts_xy=starts, ends_xy=ends, owners=owners, sure=sure, stations=measurements.stations)


def unoccluded_stations(feature: Hypothesis, measurements: Measurements, *, step: float) -> BoolArray:
    """Tell which stations should hear a feature if it is there, for nothing nearer was heard.

    Of a wall that was heard on both sides of a door those stand before the gap who hear nothing.

    Parameters
    ----------
    feature : Hypothesis
        The feature, with fresh evidence and the gains of stations.
    measurements : Measurements
        The pings.
    step : float
        Turn from one ping to the next [rad].

    Returns
    -------
    ndarray of bool, shape (s,)
        By station.
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
    """Tell which places along a wall are near to any where it was heard."""
    ends = np.concatenate([[-np.inf], np.sort(detected), [np.inf]])
    after = np.searchsorted(ends, places)
    near: BoolArray = np.minimum(places - ends[np.maximum(after - 1, 0)], ends[after] - places) < _BESIDE
    return near


def _owners(likelihood: PingLikelihood, features: Sequence[Hypothesis]) -> IntArray:
    count = len(likelihood.measurements.readings)
    if not features:
        return np.full(count, -1)
    log_densities = np.stack([likelihood.log_densities_of(each) for each in features])
    best = log_densities.max(axis=0)
    explained = (best > likelihood.floor + _EXPLAINED) & (best > likelihood.multipath_log_densities(features))
    return np.where(explained & (best > UNHEARD), log_densities.argmax(axis=0), -1)


def _turning_points(feature: Hypothesis, starts_xy: FloatArray) -> FloatArray:
    if feature.is_wall:
        normal = directions(feature.line[0])
        feet: FloatArray = starts_xy + (feature.line[1] - starts_xy @ normal)[:, None] * normal
        return feet
    away = feature.reflector[1:3] - starts_xy
    length = np.hypot(*away.T)[:, None] + 1e-12
    radius = feature.reflector[3] if feature.kind is Kind.CYLINDER else 0.0
    points: FloatArray = starts_xy + away * (length - radius) / length
    return points
