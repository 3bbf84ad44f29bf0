"""Sweeps from messages that keep coming: those of bags, cut as soon as no later message can change them."""

from collections.abc import Iterable, Mapping
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
from echoplan.model import Rig, Sweep

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
    """Take new messages, and cut the sweeps that they finish; in silence, the current one is finished, too.

    Raises ``InputError`` if something is missing for a map, time goes back, or sensors are mounted elsewhere than
    before.
    """
    series = _joined(window.series, as_contents(rows))
    read = contents_of(
        series,
        path=listening.path,
        options=listening.options,
        topics=listening.topics,
        choice=listening.choice,
        is_whole=False,
    )
    recording, trajectory = recording_of(read), trajectory_of(read)
    world = trajectory.world
    rig = _same_rig(window.rig, recording.rig, path=listening.path)
    fresh = [later for sweep in recording.sweeps if len(later := _after(sweep, window.finished_ns))]
    moving = [own for role in _MOVING for own in read.of_role(role).values() if len(own)]
    settled_ns = max(int(own.stamps_ns[-1]) for own in moving) - _LATE_NS
    # The last sweep may go on.
    ended = [sweep for sweep in fresh[:-1] if sweep.stamps_ns[-1] <= settled_ns]
    finished = fresh if is_silent else ended
    last_ns = int(finished[-1].stamps_ns[-1]) if finished else window.finished_ns
    first_ns = last_ns if window.first_ns == _EARLIEST_NS else window.first_ns
    kept = {}
    for key, own in series.items():
        times = times_of(own, has_stamps=key.topic not in read.without_stamps)
        kept[key] = own[_needed(times, role=key.role, first_ns=first_ns, finished_ns=last_ns)]
    rest = fresh[len(finished) :]
    return Advance(
        window=Window(series=kept, first_ns=first_ns, finished_ns=last_ns, rig=rig),
        rig=rig,
        finished=tuple(finished),
        partial=rest[-1] if rest else None,
        notes=recording.notes,
        base=trajectory.base,
        world=world,
        world_parent=next((each.start for each in read.frames.steps if each.is_down and each.end == world), ""),
        clock_offset_ns=max(int((own.stamps_ns - own.log_ns)[-_RECENT:].max()) for own in moving),
    )


def _joined(before: Mapping[SeriesKey, Series], new: Mapping[SeriesKey, Series]) -> dict[SeriesKey, Series]:
    """Append new numbers to those before."""
    joined = dict(before)
    for key, own in new.items():
        parts = (before[key], own) if key in before else (own,)
        names = ("log_ns", "stamps_ns", "values")
        joined[key] = Series(**{name: np.concatenate([getattr(part, name) for part in parts]) for name in names})
    return joined


def _after(sweep: Sweep, time_ns: int) -> Sweep:
    """Drop the pings of a sweep up to a time: they were part of a finished one, or came too late."""
    return sweep[np.flatnonzero(sweep.stamps_ns > time_ns)]


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
