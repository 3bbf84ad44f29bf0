"""Estimates and the true objects they are of, as values."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Generic, TypeVar

from echoplan.arrays import IntArray, checked_integers, store
from echoplan.evaluation.tally import Tally
from echoplan.model import FeatureClass

__all__ = ["CylinderMatch", "Match", "Matches", "Matching", "OpeningMatch", "WallMatch"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Match:
    """An estimate and the true object it is of.

    Parameters
    ----------
    truth, estimate : int
        Numbers of the two in the truth and in the map; a true corner's is that of its vertex.
    distance : float
        By how much the estimate is off [m]: a wall's midpoint from the true line, a centre or an opening's
        midpoint from the true one, a corner from the true vertex.
    """

    truth: int
    estimate: int
    distance: float


@dataclass(frozen=True, slots=True, kw_only=True)
class WallMatch(Match):
    """An estimated wall and the true one.

    Parameters
    ----------
    angle : float
        Between the two lines, in [0, pi/2] [rad].
    """

    angle: float


@dataclass(frozen=True, slots=True, kw_only=True)
class CylinderMatch(Match):
    """An estimated cylinder and the true one.

    Parameters
    ----------
    radius_error : float
        Estimated radius less the true one [m].
    """

    radius_error: float


@dataclass(frozen=True, slots=True, kw_only=True)
class OpeningMatch(Match):
    """An estimated opening and the true one.

    Parameters
    ----------
    width_error : float
        Estimated width minus the true one [m].
    """

    width_error: float


Kind_co = TypeVar("Kind_co", bound=Match, covariant=True)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Matching(Generic[Kind_co]):
    """Matches between the true objects and the estimates of one class.

    Parameters
    ----------
    right : tuple of Match
        Estimates that stand for their true object.
    duplicate : tuple of Match
        Further estimates of the same objects.
    spurious : tuple of int
        Numbers of the estimates that match nothing.
    detected_by : ndarray of int, shape (n,)
        Number of stations that can detect each true object.
    wanted, found : tuple of int
        True objects that count for recall, and those of them that the map has.
    """

    right: tuple[Kind_co, ...]
    duplicate: tuple[Kind_co, ...]
    spurious: tuple[int, ...]
    detected_by: IntArray
    wanted: tuple[int, ...]
    found: tuple[int, ...]

    def __post_init__(self) -> None:
        store(self, detected_by=checked_integers(self.detected_by, name="detected_by", shape=(None,)))

    @property
    def tally(self) -> Tally:
        """The counts."""
        return Tally(
            wanted=len(self.wanted),
            found=len(self.found),
            right=len(self.right),
            duplicate=len(self.duplicate),
            spurious=len(self.spurious),
        )


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Matches:
    """The matchings of all classes.

    Parameters
    ----------
    walls : Matching of WallMatch
        The walls.
    corners : Matching of Match
        The corners; true objects are the vertices.
    cylinders : Matching of CylinderMatch
        The cylinders.
    """

    walls: Matching[WallMatch]
    corners: Matching[Match]
    cylinders: Matching[CylinderMatch]

    @property
    def by_class(self) -> Mapping[FeatureClass, Matching[Match]]:
        """The same by class, in the order of ``FeatureClass``."""
        return {
            FeatureClass.WALL: self.walls,
            FeatureClass.CORNER: self.corners,
            FeatureClass.CYLINDER: self.cylinders,
        }
