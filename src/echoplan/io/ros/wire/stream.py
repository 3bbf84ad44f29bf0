"""Sweeps from messages that keep coming: those of bags, cut as soon as no later message can change them."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import gcd
from pathlib import Path

import numpy as np

from echoplan.arrays import BoolArray, IntArray
from echoplan.errors import InputError
from echoplan.io.ros.bag import Topic
from echoplan.io.ros.choice import Choice
from echoplan.io.ros.clock import times_of
from echoplan.io.ros.contents import contents_of
from echoplan.io.ros.options import BagOptions
from echoplan.io.ros.recording import recording_of
from echoplan.io.ros.series import Role, Row, Series, SeriesKey, as_contents
from echoplan.io.ros.trajectory import trajectory_of
from echoplan.model import Recording, Rig, Sweep

__all__ = ["Advance", "Listening", "Window", "advance"]

# Messages overtake each other on their way by less than this [ns].
_LATE_NS = 250_000_000
# Sensors are mounted elsewhere if a pose differs by more [m, rad].
_SAME_MOUNTING = 0.02
# Resolutions are compared in this unit [m].
_UNIT = 1e-4
# The message that took least time of so many shows by how much clocks differ.
_RECENT = 20
_MOVING = (Role.READING, Role.POSE, Role.MOVING_TRANSFORM)
_EARLIEST_NS = -(2**62)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Listening:
    """What is listened to.

    Parameters
    ----------
    path : Path
        What errors and notes call it.
    options : BagOptions
        Options of the user.
    topics : tuple of Topic
        All topics.
    choice : Choice
        Those that are read.
    """

    path: Path
    options: BagOptions
    topics: tuple[Topic, ...]
    choice: Choice


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Window:
    """The messages that are still needed.

    The first sweeps stay: they show how sensors are mounted, how far the servo turns and which steps the readings
    have, also while the servo stands still or a sensor is silent. Of the rest, what is older than the last finished
    sweep goes.

    Parameters
    ----------
    series : dict, optional
        Their numbers.
    first_ns : int, optional
        Last ping of the first sweeps [ns].
    finished_ns : int, optional
        Last ping of the last finished sweep [ns].
    rig : Rig, optional
        The sensors; None before the first sweep.
    """

    series: Mapping[SeriesKey, Series] = field(default_factory=dict)
    first_ns: int = _EARLIEST_NS
    finished_ns: int = _EARLIEST_NS
    rig: Rig | None = None

    def with_rows(self, rows: Iterable[Row]) -> "Window":
        """Append the numbers of new messages."""
        return replace(self, series=_joined(self.series, as_contents(rows)))

    def emptied(self) -> "Window":
        """Forget all but the sensors and the transforms that never change."""
        fixed = {key: own for key, own in self.series.items() if key.role is Role.FIXED_TRANSFORM}
        return Window(series=fixed, rig=self.rig)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Advance:
    """What new messages bring.

    Parameters
    ----------
    window : Window
        What is needed for the next ones.
    rig : Rig
        The sensors.
    finished : tuple of Sweep
        Sweeps that are complete.
    partial : Sweep, optional
        The pings so far of the current one; None if there are none.
    notes : tuple of str
        What the user should know about how the messages were read.
    base, world : str
        Frames of the robot and of its poses; the latter is empty if no message names it.
    world_parent : str
        Frame in which others place that of the poses; empty if nobody does.
    clock_offset_ns : int
        By how much the clock of the robot is ahead of this computer's [ns].
    """

    window: Window
    rig: Rig
    finished: tuple[Sweep, ...]
    partial: Sweep | None
    notes: tuple[str, ...]
    base: str
    world: str
    world_parent: str
    clock_offset_ns: int


def advance(window: Window, rows: Iterable[Row], *, listening: Listening, is_silent: bool = False) -> Advance:
    """Take new messages, and cut the sweeps that they finish.

    Parameters
    ----------
    window : Window
        The messages before that are still needed.
    rows : iterable of Row
        The numbers of the new ones.
    listening : Listening
        What is listened to.
    is_silent : bool, optional
        Whether the current sweep is finished, since nothing comes any more.

    Returns
    -------
    Advance
        Finished sweeps, and the messages that are needed for the next ones.

    Raises
    ------
    InputError
        If something is missing for a map, time goes back, or sensors are mounted elsewhere than before.
    """
    window = window.with_rows(rows)
    read = contents_of(
        window.series,
        path=listening.path,
        options=listening.options,
        topics=listening.topics,
        choice=listening.choice,
        is_whole=False,
    )
    recording, trajectory = recording_of(read), trajectory_of(read)
    rig = _same_rig(window.rig, recording.rig, path=listening.path)
    moving = [own for role in _MOVING for own in read.of_role(role).values() if len(own)]
    settled_ns = np.inf if is_silent else max(int(own.stamps_ns[-1]) for own in moving) - _LATE_NS
    finished, rest = _cut(recording, after_ns=window.finished_ns, settled_ns=settled_ns)
    parents = {(step.end, step.is_down): step.start for step in read.frames.steps}
    return Advance(
        window=_shortened(replace(window, rig=rig), finished, without_stamps=read.without_stamps),
        rig=rig,
        finished=tuple(finished),
        partial=rest[-1] if rest else None,
        notes=recording.notes,
        base=trajectory.base,
        world=trajectory.world,
        world_parent=parents.get((trajectory.world, True), ""),
        clock_offset_ns=max(int((own.stamps_ns - own.log_ns)[-_RECENT:].max()) for own in moving),
    )


def _cut(recording: Recording, *, after_ns: int, settled_ns: float) -> tuple[list[Sweep], list[Sweep]]:
    """Return the sweeps after a time that no later message changes, and the others.

    Pings up to that time were part of a finished sweep, or came too late. The last sweep may go on, unless there are no
    later messages.
    """
    later = [sweep[np.flatnonzero(sweep.stamps_ns > after_ns)] for sweep in recording.sweeps]
    fresh = [sweep for sweep in later if len(sweep)]
    candidates = fresh if np.isinf(settled_ns) else fresh[:-1]
    finished = [sweep for sweep in candidates if sweep.stamps_ns[-1] <= settled_ns]
    return finished, fresh[len(finished) :]


def _shortened(window: Window, finished: Sequence[Sweep], *, without_stamps: frozenset[str]) -> Window:
    """Forget what is not needed after the finished sweeps."""
    last_ns = int(finished[-1].stamps_ns[-1]) if finished else window.finished_ns
    first_ns = last_ns if window.first_ns == _EARLIEST_NS else window.first_ns
    kept = {}
    for key, own in window.series.items():
        times = times_of(own, has_stamps=key.topic not in without_stamps)
        kept[key] = own[_needed(times, role=key.role, first_ns=first_ns, finished_ns=last_ns)]
    return replace(window, series=kept, first_ns=first_ns, finished_ns=last_ns)


def _joined(before: Mapping[SeriesKey, Series], new: Mapping[SeriesKey, Series]) -> dict[SeriesKey, Series]:
    """Append new numbers to those before."""
    joined = dict(before)
    for key, own in new.items():
        parts = (before[key], own) if key in before else (own,)
        names = ("log_ns", "stamps_ns", "values")
        joined[key] = Series(**{name: np.concatenate([getattr(part, name) for part in parts]) for name in names})
    return joined


def _needed(times_ns: IntArray, *, role: Role, first_ns: int, finished_ns: int) -> BoolArray:
    """Return which numbers are still needed: those of the first sweeps, and those since the last finished one."""
    if role is Role.FIXED_TRANSFORM:
        # The last one counts.
        is_last: BoolArray = np.arange(len(times_ns)) == len(times_ns) - 1
        return is_last
    since_ns = finished_ns + 1
    if role is not Role.READING:
        # Poses are interpolated from the last one before.
        since_ns = times_ns[times_ns <= finished_ns].max(initial=_EARLIEST_NS)
    needed: BoolArray = (times_ns <= first_ns) | (times_ns >= since_ns)
    return needed


def _same_rig(before: Rig | None, now: Rig, *, path: Path) -> Rig:
    """Return the rig with what is known of its resolutions; refuse one with other sensors or another mounting."""
    if before is None:
        return now
    pairs = list(zip(before.sensors, now.sensors, strict=False))
    differences = [np.abs(before.base_from_turret - now.base_from_turret).max()] + [
        max(abs(old.x - new.x), abs(old.y - new.y), abs(old.yaw - new.yaw)) for old, new in pairs
    ]
    if len(before.sensors) != len(now.sensors) or max(differences) > _SAME_MOUNTING:
        problem = "sensors were added, or are mounted or turned differently than at the start"
        raise InputError(path, problem, remedy="start again when all of them are there and the servo turns")
    return replace(
        before,
        sensors=tuple(
            replace(old, resolution=round(gcd(*(round(each.resolution / _UNIT) for each in (old, new))) * _UNIT, 4))
            for old, new in pairs
        ),
    )
