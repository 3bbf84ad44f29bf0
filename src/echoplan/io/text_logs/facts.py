"""What was understood of a text log, and why: the table that a person checks before anything is written."""

from dataclasses import dataclass
from enum import StrEnum

__all__ = ["Fact", "Origin", "Skipped", "stated_fact"]


class Origin(StrEnum):
    """Why something was understood as it was."""

    OPTION = "given"
    STATED = "written in the log"
    SEEN = "seen in the log"
    DEFAULT = "default"
    GUESSED = "guessed"


@dataclass(frozen=True, slots=True, kw_only=True)
class Fact:
    """One row of the table.

    Parameters
    ----------
    subject : str
        What it is about.
    value : str
        How it was understood.
    origin : Origin
        Why.
    option : str, optional
        The option that states it: a guess must be confirmed, or this option given.
    """

    subject: str
    value: str
    origin: Origin
    option: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Skipped:
    """A line of which nothing was used.

    Parameters
    ----------
    place : str
        File and line.
    text : str
        The line.
    reason : str
        Why it was skipped.
    """

    place: str
    text: str
    reason: str


def stated_fact(subject: str, *, given: str, written: str) -> Fact | None:
    """Return what an option gives, or else what the log states; None if neither does."""
    if given:
        return Fact(subject=subject, value=given, origin=Origin.OPTION)
    return Fact(subject=subject, value=written, origin=Origin.STATED) if written else None
