"""Quality: whether a map can be trusted, and if not, why and what to do."""

from dataclasses import dataclass
from enum import StrEnum

__all__ = ["Quality", "Verdict"]


class Verdict(StrEnum):
    """Whether a map can be trusted."""

    GOOD = "good"
    DOUBTFUL = "doubtful"
    FAILED = "failed"


@dataclass(frozen=True, slots=True, kw_only=True)
class Quality:
    """Whether a map can be trusted, and if not, why and what to do.

    Parameters
    ----------
    verdict : Verdict
        ``good``: measure in it; ``doubtful``: parts of it may be wrong; ``failed``: it does not show the room.
    reasons : tuple of str, optional
        One sentence each, the most serious first.
    next_step : str, optional
        What to do about it; empty if nothing is to be done.

    Examples
    --------
    >>> Quality(verdict=Verdict.GOOD).verdict.value
    'good'
    """

    verdict: Verdict
    reasons: tuple[str, ...] = ()
    next_step: str = ""
