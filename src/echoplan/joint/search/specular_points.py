"""Echoes of corners: how often two walls were heard in each other, and whether their corner was missed where it is."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import BoolArray, FloatArray
from echoplan.geometry import intersections
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.ping_likelihood import PingLikelihood
from echoplan.joint.likelihood.ping_scores import UNHEARD

__all__ = ["CornerEcho", "Echoes", "corner_echoes", "returns_sound"]

# A corner that is off a right angle by d sends the two halves of a wave back 2 d r apart, r away.  They are one wave
# still while that is less than the first Fresnel zone, sqrt(r wavelength / 2): at 40 kHz up to a degree at 3 m [rad].
_SQUARE = math.radians(1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class CornerEcho:
    """What was heard of the corner of two walls.

    Parameters
    ----------
    pings : int, optional
        How many heard one wall in the other.
    stations : int, optional
        From how many stations.
    detections : float, optional
        By how much more likely what these heard is for that [nats].
    gain : float, optional
        By how much more likely what all stations heard is with a corner there than without one [nats]: above 0 if they
        heard one, below if it should have been heard and was not, 0 if nobody could tell.
    """

    pings: int = 0
    stations: int = 0
    detections: float = 0.0
    gain: float = 0.0

    @property
    def evidence(self) -> float:
        """By how much those that heard one wall in the other say more for the corner than all others against it."""
        return self.detections + self.gain

    def joined(self, other: "CornerEcho") -> "CornerEcho":
        """Add what other stations heard.

        Parameters
        ----------
        other : CornerEcho
            Of the same walls.

        Returns
        -------
        CornerEcho
            What all of them heard.
        """
        return CornerEcho(
            pings=self.pings + other.pings,
            stations=self.stations + other.stations,
            detections=self.detections + other.detections,
            gain=self.gain + other.gain,
        )


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Echoes:
    """What was heard of corners.

    Parameters
    ----------
    pairs : mapping of tuple of int to CornerEcho, optional
        Of two walls, by the numbers of both, the lower one first.
    corners_xy : ndarray, shape (c, 2), optional
        Corners that were heard as such [m].
    """

    pairs: Mapping[tuple[int, int], CornerEcho] = field(default_factory=dict)
    corners_xy: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))

    @classmethod
    def of(cls, features: Sequence[Hypothesis], pairs: Mapping[tuple[int, int], CornerEcho]) -> "Echoes":
        """Collect the corners among features."""
        corners = [each.reflector[1:3] for each in features if each.kind is Kind.CORNER]
        return cls(pairs=pairs, corners_xy=np.array(corners).reshape(-1, 2))

    def between(self, one: int, other: int) -> CornerEcho:
        """Return what was heard of the corner of two walls."""
        return self.pairs.get((min(one, other), max(one, other)), CornerEcho())

    def is_detected_at(self, point_xy: FloatArray, *, within: float) -> bool:
        """Tell whether a corner was heard near a point."""
        return bool((np.hypot(*(self.corners_xy - point_xy).T) < within).any())


def returns_sound(one: FloatArray, other: FloatArray) -> bool:
    """Tell whether the corner of two walls sends sound back to wherever it comes from.

    Parameters
    ----------
    one, other : ndarray, shape (2,)
        ``(normal_angle, offset)`` of their lines [rad, m].

    Returns
    -------
    bool
        Whether they are at right angles, as far as sound can tell.
    """
    return abs(math.cos(one[0] - other[0])) < math.sin(_SQUARE)


def corner_echoes(
    likelihood: PingLikelihood, features: Sequence[Hypothesis], count: int
) -> dict[tuple[int, int], CornerEcho]:
    """Tell what stations heard of the corners of all pairs of walls.

    Parameters
    ----------
    likelihood : PingLikelihood
        The pings.
    features : sequence of Hypothesis
        What is there.
    count : int
        Only the first so many stations are asked.

    Returns
    -------
    dict of tuple of int to CornerEcho
        By the places of both in the list.
    """
    among = likelihood.measurements.stations < count
    walls = [number for number, each in enumerate(features) if each.is_wall]
    pairs = [(one, other) for place, one in enumerate(walls) for other in walls[place + 1 :]]
    detections, llr_by_station = (
        _detected(likelihood, features, pairs, among),
        _gains(likelihood, features, pairs, count),
    )
    return {pair: replace(detections[pair], gain=llr_by_station.get(pair, 0.0)) for pair in pairs}


def _detected(
    likelihood: PingLikelihood, features: Sequence[Hypothesis], pairs: Sequence[tuple[int, int]], among: BoolArray
) -> dict[tuple[int, int], CornerEcho]:
    """Tell which pings heard one wall in another, and nothing that explains them better."""
    direct = np.full(len(likelihood.measurements.readings), likelihood.floor)
    for each in features:
        if each.kind in (Kind.WALL, Kind.CYLINDER):
            np.maximum(direct, likelihood.log_densities_of(each), out=direct)
    least = np.maximum(np.maximum(direct + math.log(5.0), likelihood.floor + math.log(20.0)), UNHEARD)
    log_densities_of = {pair: likelihood.pair_log_densities(*(features[each] for each in pair)) for pair in pairs}
    for log_densities in log_densities_of.values():
        np.maximum(least, log_densities, out=least)
    echoes = {}
    for (one, other), log_densities in log_densities_of.items():
        clear = (log_densities >= least) & among
        echoes[one, other] = CornerEcho(
            pings=int(clear.sum()),
            stations=len(np.unique(likelihood.measurements.stations[clear])),
            detections=float((log_densities - direct)[clear].sum()),
        )
    return echoes


def _gains(
    likelihood: PingLikelihood, features: Sequence[Hypothesis], pairs: Sequence[tuple[int, int]], count: int
) -> dict[tuple[int, int], float]:
    """Hold corners where two walls cross at right angles against what the first stations heard."""
    square = [pair for pair in pairs if returns_sound(*(features[each].line for each in pair))]
    crossings = [intersections(*(features[each].line for each in pair)) for pair in square]
    corners = [likelihood.score(np.array([Kind.CORNER, *point, 0.0])) for point in crossings]
    rescored = likelihood.score_all(corners, likelihood.log_densities(features), features)
    return {pair: float(each.llr_by_station[:count].sum()) for pair, each in zip(square, rescored, strict=True)}
