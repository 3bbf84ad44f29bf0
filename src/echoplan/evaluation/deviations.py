"""How far each true object of a room is off in a map, object by object: Table 5 of the paper."""

from dataclasses import dataclass
from typing import Generic, TypeVar

from echoplan.evaluation.matches import Match, Matching

__all__ = ["Deviation", "deviations"]

Kind = TypeVar("Kind", bound=Match)
Kind_co = TypeVar("Kind_co", bound=Match, covariant=True)


@dataclass(frozen=True, slots=True, kw_only=True)
class Deviation(Generic[Kind_co]):
    """A line of Table 5: a true object and the estimate that stands for it.

    Parameters
    ----------
    index : int
        Number of the true object, from 1.
    detected_by : int
        Number of stations that can detect it.
    match : Match or None
        By how much its estimate is off; None where the map lacks the object.
    """

    index: int
    detected_by: int
    match: Kind_co | None


def deviations(matching: Matching[Kind]) -> tuple[Deviation[Kind], ...]:
    """List the true objects of a class, found or not.

    Parameters
    ----------
    matching : Matching
        Which estimate is of which true object.

    Returns
    -------
    tuple of Deviation
        One for each true object, in their order; a corner that has several estimates has its nearest.
    """
    nearest = {match.truth: match for match in sorted(matching.right, key=lambda match: -match.distance)}
    return tuple(
        Deviation(index=number + 1, detected_by=detected_by, match=nearest.get(number))
        for number, detected_by in enumerate(matching.detected_by.tolist())
    )
