"""Hypotheses: reflectors that may be there, with the evidence for them."""

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import BoolArray, FloatArray
from echoplan.geometry import directions
from echoplan.joint.likelihood.ping_scores import PingScores
from echoplan.joint.likelihood.track_history import NO_HISTORY, TrackHistory

__all__ = ["Hypothesis", "Key"]

# Plain numbers are faster to compare than members of an enumeration.
_WALL = int(Kind.WALL)

# What tells one hypothesis, or several together, from others.
Key: TypeAlias = tuple[object, ...]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Hypothesis:
    """A reflector that may be there, and what speaks for it.

    Parameters
    ----------
    reflector : ndarray, shape (4,)
        Value of ``Kind`` and three parameters.
    ping_scores : PingScores
        What single pings say.
    llr_by_station : ndarray, shape (s,)
        Gain by station over what explains the pings without it [nats].
    total : float, optional
        Their sum [nats].
    extent : tuple of float, optional
        Ends of a wall along it [m].
    history : TrackHistory, optional
        What stations said of it whose pings are no longer at hand; it counts in the total and the extent.
    is_square : bool, optional
        Whether a wall is believed to stand at right angles to others.
    """

    reflector: FloatArray
    ping_scores: PingScores
    llr_by_station: FloatArray
    total: float = 0.0
    extent: tuple[float, float] = (0.0, 0.0)
    history: TrackHistory = NO_HISTORY
    is_square: bool = False

    @property
    def best(self) -> float:
        """Gain of the station that says most for it [nats]."""
        return max(float(self.llr_by_station.max(initial=0.0)), self.history.best)

    @property
    def is_known(self) -> bool:
        """Whether it was believed before any of the stations at hand."""
        return self.history.number >= 0

    @property
    def kind(self) -> Kind:
        """What it is taken for."""
        return Kind(int(self.reflector[0]))

    @property
    def is_wall(self) -> bool:
        """Whether it is a wall."""
        return bool(self.reflector[0] == _WALL)

    @property
    def parameters(self) -> FloatArray:
        """Its free parameters: two, or three of a cylinder."""
        return self.reflector[1 : 4 if self.kind is Kind.CYLINDER else 3]

    @property
    def line(self) -> FloatArray:
        """Normal angle and offset of a wall [rad, m], shape (2,)."""
        return self.reflector[1:3]

    @property
    def ends_xy(self) -> FloatArray:
        """Ends of a wall [m], shape (2, 2)."""
        normal = directions(self.line[0])
        ends: FloatArray = self.line[1] * normal + np.outer(self.extent, (-normal[1], normal[0]))
        return ends

    def supporting(self, least: float) -> int:
        """Count the stations that speak for it by more than this [nats]."""
        return int((self.llr_by_station > least).sum()) + self.history.supporting

    def newly_explained(self, log_densities: FloatArray) -> BoolArray:
        """Tell which pings it explains, and better than anything else.

        Parameters
        ----------
        log_densities : ndarray, shape (n,)
            Logarithm of the density of each reading by what explains it without it [log 1/m].

        Returns
        -------
        ndarray of bool, shape (m,)
            One a ping of its evidence.
        """
        anew: BoolArray = self.ping_scores.densities > np.maximum(log_densities[self.ping_scores.pings], 0.0)
        return anew

    @property
    def key(self) -> Key:
        """What tells it from others: reflector and extent."""
        return (*self.reflector.tolist(), *self.extent)

    def rescored(self, llr_by_station: FloatArray, total: float, extent: tuple[float, float]) -> "Hypothesis":
        """Say anew what speaks for it.

        Parameters
        ----------
        llr_by_station : ndarray, shape (s,)
            Gain by station [nats].
        total : float
            Their sum [nats].
        extent : tuple of float
            Ends of a wall along it [m].

        Returns
        -------
        Hypothesis
            The same reflector with the same evidence and past.
        """
        # Searches judge a hundred thousand times: dataclasses.replace takes three times as long.
        return Hypothesis(
            reflector=self.reflector,
            ping_scores=self.ping_scores,
            llr_by_station=llr_by_station,
            total=total,
            extent=extent,
            history=self.history,
            is_square=self.is_square,
        )

    def has_other_multipath_than(self, other: "Hypothesis") -> bool:
        """Whether it explains other readings than another hypothesis: it reaches elsewhere, or others hear it.

        Parameters
        ----------
        other : Hypothesis
            The other one.

        Returns
        -------
        bool
            Whether it does.
        """
        return self.key != other.key or not np.array_equal(self.llr_by_station > 0.0, other.llr_by_station > 0.0)
