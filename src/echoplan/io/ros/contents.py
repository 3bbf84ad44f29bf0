"""The content of a bag, read in one pass."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from echoplan.errors import InputError
from echoplan.io.ros.bag import Topic, open_bag
from echoplan.io.ros.choice import Choice, choose_topics
from echoplan.io.ros.clock import with_one_clock
from echoplan.io.ros.frames import Frames, frames_of
from echoplan.io.ros.messages import rows_of
from echoplan.io.ros.options import BagOptions
from echoplan.io.ros.series import Role, Series, SeriesKey, as_contents
from echoplan.io.units import LARGEST_ANGLE, looks_like_degrees

__all__ = ["BagContents", "contents_of", "read_contents"]

_ANGLES = ("servo", "yaw")


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class BagContents:
    """The content of a bag, whether or not it suffices for a map.

    Parameters
    ----------
    path : Path
        The bag.
    options : BagOptions
        Options of the user.
    topics : tuple of Topic
        All its topics.
    choice : Choice
        Those that were read.
    series : dict
        Their numbers, stamped by one clock and sorted by time.
    frames : Frames
        The transforms.
    notes : tuple of str
        How times were determined if not from the stamps in the headers.
    without_stamps : frozenset of str, optional
        Topics of which the times of recording are used.
    """

    path: Path
    options: BagOptions
    topics: tuple[Topic, ...]
    choice: Choice
    series: dict[SeriesKey, Series]
    frames: Frames
    notes: tuple[str, ...]
    without_stamps: frozenset[str] = frozenset()

    def of_role(self, role: Role) -> dict[SeriesKey, Series]:
        """Return the series for a purpose."""
        return {key: series for key, series in self.series.items() if key.role is role}

    def field(self, key: str) -> Series | None:
        """Return the finite numbers of a field that the user names; None if no field is named.

        Raises ``InputError`` if there are none, or angles are not radians.
        """
        found = next((series for own, series in self.of_role(Role.FIELD).items() if own.frame == key), None)
        if found is None:
            return None
        series, place = found.finite(), f"{key}={self.options.field(key)}"
        if not len(series):
            remedy = "name another field"
            raise InputError("--field", "none of its messages has a finite number", place=place, remedy=remedy)
        if key in _ANGLES and (looks_like_degrees(series.values) or np.abs(series.values).max() > LARGEST_ANGLE):
            remedy = f"write --field {key}={self.options.field(key)}*{math.radians(1):.7f}"
            raise InputError("--field", "the angles look like degrees", place=place, remedy=remedy)
        return series


def read_contents(path: Path, options: BagOptions) -> BagContents:
    """Read everything that a map may need from a bag.

    Raises ``InputError`` if the bag cannot be read, time goes back in it, or several topics have odometry.
    """
    with open_bag(path) as bag:
        choice = choose_topics(bag.topics, options, path=path)
        rows = (row for message in bag.messages(choice.topics) for row in rows_of(message, options))
        return contents_of(as_contents(rows), path=path, options=options, topics=bag.topics, choice=choice)


def contents_of(
    series: Mapping[SeriesKey, Series],
    *,
    path: Path,
    options: BagOptions,
    topics: tuple[Topic, ...],
    choice: Choice,
    is_whole: bool = True,
) -> BagContents:
    """Stamp what was read by one clock, and gather its transforms; more may follow if it is not the whole.

    Raises ``InputError`` if time goes back.
    """
    timed = with_one_clock(series, path=path)
    return BagContents(
        path=path,
        options=options,
        topics=topics,
        choice=choice,
        series=dict(timed.series),
        frames=frames_of(timed.series, is_whole=is_whole),
        notes=timed.notes,
        without_stamps=timed.without_stamps,
    )
