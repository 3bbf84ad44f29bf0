"""How often a map was right about one class of objects: recall and precision."""

from dataclasses import dataclass
from math import nan

__all__ = ["Tally"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Tally:
    """Counts of true objects and of estimates; tallies of several maps add up.

    Parameters
    ----------
    wanted : int, optional
        True objects that enough stations can detect to count for recall.
    found : int, optional
        How many of those the map has.
    right : int, optional
        Estimates that stand for a true object, wanted or not.
    duplicate : int, optional
        Further estimates of a true object that already has one.
    spurious : int, optional
        Estimates that match nothing true.

    Examples
    --------
    >>> both = Tally(wanted=4, found=3, right=3) + Tally(wanted=1, found=1, right=1, spurious=1)
    >>> both.recall, both.precision
    (0.8, 0.8)
    """

    wanted: int = 0
    found: int = 0
    right: int = 0
    duplicate: int = 0
    spurious: int = 0

    def __add__(self, other: "Tally") -> "Tally":
        return Tally(
            wanted=self.wanted + other.wanted,
            found=self.found + other.found,
            right=self.right + other.right,
            duplicate=self.duplicate + other.duplicate,
            spurious=self.spurious + other.spurious,
        )

    @property
    def estimates(self) -> int:
        """How many objects of the class the map has."""
        return self.right + self.duplicate + self.spurious

    @property
    def recall(self) -> float:
        """Share of the wanted objects that were found; nan if none was wanted."""
        return self.found / self.wanted if self.wanted else nan

    @property
    def precision(self) -> float:
        """Share of the estimates that are right; nan if there is none."""
        return self.right / self.estimates if self.estimates else nan
