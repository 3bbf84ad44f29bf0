"""Hypotheses: landmarks with their scores by ping and by station."""

import math
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import BoolArray, FloatArray
from echoplan.geometry import directions, wrap
from echoplan.joint.landmarks import LANDMARKS, LandmarkType
from echoplan.joint.likelihood.ping_scores import PingScores
from echoplan.joint.likelihood.track_history import NO_HISTORY, TrackHistory

__all__ = ["ANYWHERE", "Hypothesis", "Key"]

# Plain integers compare faster than members of an enumeration.
_WALL = int(Kind.WALL)

# Stations that must detect a soft wall clearly, since one or two may detect a hard wall faintly, past something that
# stands before it; and the log-likelihood ratio of such a station [nats]: unmodelled multipath that looked like a soft
# wall reached 38 in rooms and drives (benchmarks/gate.py, seeds 0 to 49).
_CLEAR_STATIONS, _CLEAR_STATION_LLR = 3, 40.0

# Sound returns from a concave corner if its walls meet at this angle, and only between them [rad].
_RIGHT_ANGLE = 0.5 * math.pi
# All directions: their middle, and half of their width [rad].
ANYWHERE = (0.0, math.pi)

# Identity of one hypothesis, or of several together.
Key: TypeAlias = tuple[object, ...]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Hypothesis:
    """A landmark that may exist, with its log-likelihood ratio."""

    # Value of ``Kind`` and three parameters [rad and m], shape (4,).
    reflector: FloatArray
    ping_scores: PingScores
    # Contribution of each station to the log-likelihood ratio [nats], shape (s,).
    llr_by_station: FloatArray
    # Log-likelihood ratio, including the track history [nats].
    llr: float = 0.0
    # Ends of a wall along its line [m].
    extent: tuple[float, float] = (0.0, 0.0)
    # Contribution of marginalised stations, which is part of ``llr`` and ``extent``.
    history: TrackHistory = NO_HISTORY
    # Whether the Manhattan prior applies to a wall.
    is_square: bool = False

    @property
    def best_llr(self) -> float:
        """Greatest contribution of a single station [nats]."""
        return max(float(self.llr_by_station.max(initial=0.0)), self.history.best_llr)

    @property
    def is_known(self) -> bool:
        """Whether it has a track history from marginalised stations."""
        return self.history.number >= 0

    @property
    def kind(self) -> Kind:
        """Class of the landmark."""
        return Kind(int(self.reflector[0]))

    @property
    def type(self) -> LandmarkType:
        """Properties of landmarks of this class."""
        return LANDMARKS[self.kind]

    @property
    def is_wall(self) -> bool:
        """Whether it is a wall."""
        return bool(self.reflector[0] == _WALL)

    @property
    def may_be_soft(self) -> bool:
        """Whether enough stations detected a wall clearly to tell a soft wall from multipath and partial occlusion."""
        return self.is_wall and self.supporting(_CLEAR_STATION_LLR) >= _CLEAR_STATIONS

    @property
    def has_credible_loss(self) -> bool:
        """Whether it reflects all sound, or enough stations tell that it does not."""
        return not (self.is_wall and self.reflector[3]) or self.may_be_soft

    @property
    def parameters(self) -> FloatArray:
        """Free parameters: two, or three for a cylinder."""
        return self.reflector[1 : 1 + self.type.parameters]

    @property
    def line(self) -> FloatArray:
        """Normal angle and offset of a wall [rad, m], shape (2,)."""
        return self.reflector[1:3]

    @property
    def ends_xy(self) -> FloatArray:
        """Endpoints of a wall [m], shape (2, 2)."""
        normal = directions(self.line[0])
        ends: FloatArray = self.line[1] * normal + np.outer(self.extent, (-normal[1], normal[0]))
        return ends

    def detected_from(self, centers_xy: FloatArray) -> FloatArray:
        """Return the bearings, seen from a point, of the stations that detected it, shape (k,) [rad].

        ``centers_xy`` are those of all s stations [m], shape (s, 2).
        """
        away = centers_xy[self.llr_by_station > 0.0] - self.reflector[1:3]
        bearings: FloatArray = np.arctan2(away[:, 1], away[:, 0])
        return bearings

    def front(self, centers_xy: FloatArray) -> tuple[float, float]:
        """Return the middle and half of the width of the directions from which it can be detected [rad].

        A concave corner is detected only between its walls: within the right angle that contains the directions from
        which it was detected. ``centers_xy`` are those of all s stations [m], shape (s, 2).
        """
        if self.kind is not Kind.CORNER:
            return ANYWHERE
        bearings = np.concatenate([self.history.feet, self.detected_from(centers_xy)])
        if not len(bearings):
            return ANYWHERE
        middle = float(np.angle(np.exp(1j * bearings).sum()))
        turned = wrap(bearings - middle)
        low, high = float(turned.min()), float(turned.max())
        half = 0.5 * (high - low)
        # Detected from more directions, it may be two corners; then all of these directions count.
        return middle + 0.5 * (low + high), max(_RIGHT_ANGLE - half, half)

    def supporting(self, least: float) -> int:
        """Count the stations that contribute more than ``least`` [nats], and those that its history counts."""
        return int((self.llr_by_station > least).sum()) + self.history.supporting

    def newly_explained(self, log_densities: FloatArray) -> BoolArray:
        """Return which of its m pings it explains better than ``log_densities``, shape (n,) [log 1/m], do.

        Its own log density must also be positive.
        """
        anew: BoolArray = self.ping_scores.densities > np.maximum(log_densities[self.ping_scores.pings], 0.0)
        return anew

    @property
    def key(self) -> Key:
        """Identity of the hypothesis: reflector and extent."""
        return (*self.reflector.tolist(), *self.extent)

    def rescored(self, llr_by_station: FloatArray, llr: float, extent: tuple[float, float]) -> "Hypothesis":
        """Return the hypothesis with other log-likelihood ratios [nats] and another extent [m]."""
        # A search calls this about 100,000 times: dataclasses.replace takes three times as long.
        return Hypothesis(
            reflector=self.reflector,
            ping_scores=self.ping_scores,
            llr_by_station=llr_by_station,
            llr=llr,
            extent=extent,
            history=self.history,
            is_square=self.is_square,
        )

    def has_other_multipath_than(self, other: "Hypothesis") -> bool:
        """Return True if reflector, extent or supporting stations differ: then it may explain other readings."""
        return self.key != other.key or not np.array_equal(self.llr_by_station > 0.0, other.llr_by_station > 0.0)
