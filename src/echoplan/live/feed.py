"""What a live page needs of a source: its pings as they come, and where the next sweep is made."""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

from echoplan.arrays import FloatArray
from echoplan.model import Rig, Sweep

__all__ = ["Complete", "Control", "Event", "Feed", "Notice", "Partial"]


class Control(StrEnum):
    """What a viewer may ask of a feed."""

    PAUSE = "pause"
    SWEEP = "sweep"


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Partial:
    """The pings so far of the current sweep.

    Parameters
    ----------
    sweep : Sweep
        The pings so far.
    """

    sweep: Sweep


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Complete:
    """The end of a sweep.

    Parameters
    ----------
    sweep : Sweep
        All its pings.
    """

    sweep: Sweep


@dataclass(frozen=True, slots=True, kw_only=True)
class Notice:
    """What the viewers should know about the source: a cable was unplugged, a recording has ended.

    Parameters
    ----------
    text : str
        One sentence; empty when there is nothing to say any more.
    is_problem : bool, optional
        Whether somebody has to do something about it.
    """

    text: str
    is_problem: bool = False


Event = Partial | Complete | Notice


class Feed(Protocol):
    """A source that is mapped while it is recorded, or played as if it were.

    ``events`` runs in a thread of its own and may block; the other methods return at once and are called from the
    thread of the server. Numbers and stamps of sweeps need not follow each other: the survey renumbers them.
    """

    @property
    def name(self) -> str:
        """What to call the source."""
        ...

    @property
    def rig(self) -> Rig:
        """What makes the sweeps."""
        ...

    @property
    def controls(self) -> frozenset[Control]:
        """What a viewer may ask of it."""
        ...

    def events(self) -> Iterator[Event]:
        """Yield what happens, as it happens; end after ``close``, or when nothing more can come."""
        ...

    def place(self, map_from_base: FloatArray) -> None:
        """Set where the following sweeps are made [m, m, rad]; a robot that knows its pose may ignore it."""
        ...

    def sweep(self) -> None:
        """Sweep from there (``Control.SWEEP``): once, or as often as the feed does at each station."""
        ...

    def play(self, *, playing: bool) -> None:
        """Go on, or pause (``Control.PAUSE``)."""
        ...

    def close(self) -> None:
        """Release the source and end ``events``, which may be waiting in another thread."""
        ...
