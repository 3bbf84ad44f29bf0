"""Topics and sensors of a bag, and what is missing for a map."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from echoplan.errors import InputError
from echoplan.io.files import by_name
from echoplan.io.ros.bag import Topic, open_bag
from echoplan.io.ros.candidates import range_candidates
from echoplan.io.ros.contents import BagContents, read_contents
from echoplan.io.ros.mounting import Mounting, mountings_of
from echoplan.io.ros.options import BagOptions
from echoplan.io.ros.readings import sonar_readings
from echoplan.io.ros.recording import recording_of
from echoplan.io.ros.series import Role, Series, SeriesKey
from echoplan.io.ros.trajectory import base_frame_of, trajectory_of
from echoplan.model import Recording

__all__ = ["BagSensor", "BagSummary", "BagTopic", "summarise_bag"]

Result = TypeVar("Result")

# Number of frames that are named per topic: /tf has dozens.
_SHOWN = 4


@dataclass(frozen=True, slots=True, kw_only=True)
class BagTopic:
    """A topic of a bag.

    Parameters
    ----------
    name, type : str
        Its name and the type of its messages.
    messages : int
        How many there are.
    rate : float
        Messages per second over the whole bag [1/s]; nan if the bag has no duration.
    frames : str
        Frames that its messages name; empty for topics that are not read.
    """

    name: str
    type: str
    messages: int
    rate: float
    frames: str


@dataclass(frozen=True, slots=True, kw_only=True)
class BagSensor:
    """A sensor found in a bag.

    Parameters
    ----------
    topic, frame : str
        Its topic (with the field if the user names one for the range), and the frame that its messages name.
    readings : int
        How many there are.
    field_of_view, min_range, max_range : float
        As stated by the user or its first message [rad, m, m]; nan where both lack it.
    x, y, yaw : float
        Its pose in the base, at servo angle 0 on the turret [m, m, rad]; nan where it is not known.
    joint : str
        Frame of the servo that turns it; empty if it is fixed.
    """

    topic: str
    frame: str
    readings: int
    field_of_view: float
    min_range: float
    max_range: float
    x: float = math.nan
    y: float = math.nan
    yaw: float = math.nan
    joint: str = ""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class BagSummary:
    """What is in a bag.

    Parameters
    ----------
    topics : tuple of BagTopic
        All topics.
    sensors : tuple of BagSensor
        The sensors, in the order of their numbers in the recording.
    poses : str
        Where the poses of the robot come from; empty if there are none.
    missing : tuple of str
        What is missing for a map, each with its remedy; empty if nothing is.
    candidates : tuple of str
        Fields that may hold ranges, as ``--field range=`` takes them; empty if there are readings.
    recording : Recording, optional
        The sweeps; None if something is missing.
    """

    topics: tuple[BagTopic, ...]
    sensors: tuple[BagSensor, ...] = ()
    poses: str = ""
    missing: tuple[str, ...] = ()
    candidates: tuple[str, ...] = ()
    recording: Recording | None = None


@by_name
def summarise_bag(path: Path, options: BagOptions | None = None) -> BagSummary:
    """Summarise a bag, even if it does not suffice for a map.

    Parameters
    ----------
    path : Path or str
        The bag.
    options : BagOptions, optional
        Which topics and fields to read.

    Returns
    -------
    BagSummary
        Its topics, sensors and sweeps, and what is missing.

    Raises
    ------
    InputError
        If it cannot be read, or an option names something that does not exist.
    MissingExtraError
        If rosbags is not installed.
    """
    with open_bag(path) as bag:
        topics, duration, candidates = bag.topics, (bag.end_ns - bag.start_ns) * 1e-9, range_candidates(bag)
    read, problem = _attempt(lambda: read_contents(path, options or BagOptions()), path=path)
    if read is None:
        return BagSummary(topics=_topics(topics, {}, duration=duration), missing=(problem,))
    found, no_ranges = _attempt(lambda: sonar_readings(read), path=path)
    readings = found or {}
    mounted, no_mounting = _attempt(lambda: mountings_of(read, readings, base=base_frame_of(read)), path=path)
    mountings = mounted or {}
    trajectory, no_poses = _attempt(lambda: trajectory_of(read), path=path)
    recording, other = _attempt(lambda: recording_of(read), path=path)
    return BagSummary(
        topics=_topics(topics, _frames_by_topic(read), duration=duration),
        sensors=tuple(
            _sensor(read, key, series=series, mounting=mountings.get(key)) for key, series in readings.items()
        ),
        poses=trajectory.origin if trajectory else "",
        missing=tuple(dict.fromkeys(filter(None, (no_ranges, no_mounting, no_poses, other)))),
        candidates=() if readings else candidates,
        recording=recording,
    )


def _attempt(step: Callable[[], Result], *, path: Path) -> tuple[Result | None, str]:
    """Return the result of a step, or what the bag lacks for it; errors in options are raised."""
    try:
        return step(), ""
    except InputError as error:
        if error.source != str(path):
            raise
        return None, f"{error.place + ': ' if error.place else ''}{error.problem}; {error.remedy}"


def _topics(topics: Iterable[Topic], frames: Mapping[str, str], *, duration: float) -> tuple[BagTopic, ...]:
    return tuple(
        BagTopic(
            name=topic.name,
            type=topic.type,
            messages=topic.count,
            rate=topic.count / duration if duration else math.nan,
            frames=frames.get(topic.name, ""),
        )
        for topic in topics
    )


def _frames_by_topic(read: BagContents) -> dict[str, str]:
    """Name the frames of each topic that was read: those of poses and transforms as parent > child."""
    named: dict[str, list[str]] = {}
    for key in read.series:
        is_pair = key.child and key.role is not Role.READING
        if key.role is not Role.FIELD and key.frame:
            named.setdefault(key.topic, []).append(f"{key.frame} > {key.child}" if is_pair else key.frame)
    return {
        topic: ", ".join(names[:_SHOWN]) + (f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else "")
        for topic, names in named.items()
    }


def _sensor(read: BagContents, key: SeriesKey, *, series: Series, mounting: Mounting | None) -> BagSensor:
    x, y, yaw = (math.nan,) * 3 if mounting is None else mounting.turret_from_sensor.tolist()
    stated = {name: read.options.constant(name) for name in ("field_of_view", "min_range", "max_range")}
    view, least, most = (float(series.column(name)[0]) if value is None else value for name, value in stated.items())
    return BagSensor(
        topic=f"/{key.child}" if key.child else key.topic,
        frame=key.frame,
        readings=len(series),
        field_of_view=view,
        min_range=least,
        max_range=most,
        x=x,
        y=y,
        yaw=yaw,
        joint=mounting.joint if mounting else "",
    )
