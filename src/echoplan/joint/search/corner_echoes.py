"""Corner echoes: double bounces between two walls, and detections and non-detections of their corner."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import BoolArray, FloatArray
from echoplan.geometry import intersections
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.ping_likelihood import PingLikelihood
from echoplan.joint.likelihood.ping_scores import NO_ECHO

__all__ = ["CornerEcho", "Echoes", "corner_echoes", "returns_sound"]

# A corner that deviates from a right angle by d returns the two halves of a wave 2 d r apart at range r. They act as
# one wave while that is less than the first Fresnel zone, sqrt(r wavelength / 2): at 40 kHz up to one degree at 3 m
# [rad].
_SQUARE = math.radians(1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class CornerEcho:
    """Detections of the corner of two walls."""

    # Number of pings that detected a double bounce.
    pings: int = 0
    # Number of their stations.
    stations: int = 0
    # Log-likelihood ratio of these readings as double bounces [nats].
    detections: float = 0.0
    # Log-likelihood ratio of a corner landmark at the crossing, from all stations [nats]: positive if they detect it,
    # negative if it should have been detected, 0 if no station could detect it.
    gain: float = 0.0

    @property
    def evidence(self) -> float:
        """Log-likelihood ratio of the corner from double bounces and as a landmark [nats]."""
        return self.detections + self.gain

    def joined(self, other: "CornerEcho") -> "CornerEcho":
        """Add the detections of other stations."""
        return CornerEcho(
            pings=self.pings + other.pings,
            stations=self.stations + other.stations,
            detections=self.detections + other.detections,
            gain=self.gain + other.gain,
        )


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Echoes:
    """Corner echoes of all walls."""

    # Echoes by the numbers of two walls, the lower one first.
    pairs: Mapping[tuple[int, int], CornerEcho] = field(default_factory=dict)
    # Corners that are landmarks themselves [m], shape (c, 2).
    corners_xy: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))

    @classmethod
    def of(cls, features: Sequence[Hypothesis], pairs: Mapping[tuple[int, int], CornerEcho]) -> "Echoes":
        """Collect the corners among landmarks."""
        corners = [each.reflector[1:3] for each in features if each.kind is Kind.CORNER]
        return cls(pairs=pairs, corners_xy=np.array(corners).reshape(-1, 2))

    def between(self, one: int, other: int) -> CornerEcho:
        """Return the echoes of the corner of two walls."""
        return self.pairs.get((min(one, other), max(one, other)), CornerEcho())

    def is_detected_at(self, point_xy: FloatArray, *, within: float) -> bool:
        """Return True if a corner landmark is nearer than ``within`` to a point [m]."""
        return bool((np.hypot(*(self.corners_xy - point_xy).T) < within).any())


def returns_sound(one: FloatArray, other: FloatArray) -> bool:
    """Return True if a corner of two lines (normal angle, offset) [rad, m] returns sound to its origin.

    This holds for right angles, as far as sound resolves them.
    """
    return abs(math.cos(one[0] - other[0])) < math.sin(_SQUARE)


def corner_echoes(
    likelihood: PingLikelihood, features: Sequence[Hypothesis], count: int
) -> dict[tuple[int, int], CornerEcho]:
    """Return the corner echoes of all pairs of walls from the first ``count`` stations, by the indices of both."""
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
    """Return the double bounces between each pair of walls, among pings that nothing explains better."""
    direct = np.full(len(likelihood.measurements.readings), likelihood.floor)
    for each in features:
        if each.type.is_surface:
            np.maximum(direct, likelihood.log_densities_of(each), out=direct)
    least = np.maximum(np.maximum(direct + math.log(5.0), likelihood.floor + math.log(20.0)), NO_ECHO)
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
    """Return the log-likelihood ratio of a corner at each right-angled crossing, from the first ``count`` stations."""
    square = [pair for pair in pairs if returns_sound(*(features[each].line for each in pair))]
    crossings = [intersections(*(features[each].line for each in pair)) for pair in square]
    corners = [likelihood.score(np.array([Kind.CORNER, *point, 0.0])) for point in crossings]
    rescored = likelihood.score_all(corners, likelihood.log_densities(features), features)
    return {pair: float(each.llr_by_station[:count].sum()) for pair, each in zip(square, rescored, strict=True)}
