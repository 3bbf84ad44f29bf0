"""Which topics of a bag are read: found by their types, or named by the user."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

from echoplan.errors import InputError, UnknownNameError
from echoplan.io.ros.bag import Topic
from echoplan.io.ros.messages import LASER_SCAN, ODOMETRY, POSES, RANGE, TRANSFORMS
from echoplan.io.ros.options import BagOptions

__all__ = ["Choice", "choose_topics", "first_names", "named_topics"]

# Number of topics or frames that an error names: a robot may have hundreds.
_SHOWN = 8


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Choice:
    """The topics to read.

    Parameters
    ----------
    readings : tuple of Topic
        Topics with readings of sensors, by type or by a field.
    odometry : tuple of Topic
        The topic with poses; empty if there is none.
    transforms : tuple of Topic
        Topics with transforms.
    fields : tuple of Topic
        Topics with fields that the user names.
    """

    readings: tuple[Topic, ...]
    odometry: tuple[Topic, ...]
    transforms: tuple[Topic, ...]
    fields: tuple[Topic, ...]

    @property
    def topics(self) -> tuple[Topic, ...]:
        """All of them, each once."""
        return tuple(dict.fromkeys((*self.readings, *self.odometry, *self.transforms, *self.fields)))


def choose_topics(topics: Sequence[Topic], options: BagOptions, *, path: Path) -> Choice:
    """Choose the topics to read; what is found by its type must be unambiguous.

    Raises ``InputError`` if several topics have odometry, or a named topic has no readings or poses, and
    ``UnknownNameError`` if it does not exist.
    """
    ours = [topic for topic in topics if topic.count]
    fields = tuple(_find(field.topic, topics) for field in options.fields if field.topic)
    return Choice(
        readings=_readings(ours, options),
        odometry=_odometry(ours, options, path=path),
        transforms=tuple(topic for topic in ours if topic.type in TRANSFORMS),
        fields=tuple(dict.fromkeys(fields)),
    )


def named_topics(topics: Iterable[Topic]) -> str:
    """List topics and their types for an error."""
    return first_names([f"{topic.name} ({topic.type})" for topic in topics])


def first_names(names: Sequence[str]) -> str:
    """Join names for an error, at most a few of them."""
    more = f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else ""
    return ", ".join(names[:_SHOWN]) + more


def _find(name: str, topics: Iterable[Topic]) -> Topic:
    by_name = {topic.name: topic for topic in topics}
    if name not in by_name:
        raise UnknownNameError("topic", name, known=by_name)
    return by_name[name]


def _readings(topics: Sequence[Topic], options: BagOptions) -> tuple[Topic, ...]:
    if not options.topics:
        by_field = tuple(_find(field.topic, topics) for field in options.ranges)
        return by_field or tuple(topic for topic in topics if topic.type == RANGE)
    found: dict[Topic, None] = {}
    for pattern in options.topics:
        found |= dict.fromkeys(_matching(pattern, topics))
    return tuple(found)


def _matching(pattern: str, topics: Sequence[Topic]) -> list[Topic]:
    """Return the topics with ranges that match a pattern; a scan counts as a laser's unless it is named in full."""
    matching = [topic for topic in topics if fnmatchcase(topic.name, pattern)]
    if not matching:
        raise UnknownNameError("topic", pattern, known=[topic.name for topic in topics])
    found = [topic for topic in matching if topic.type == RANGE or (topic.type, topic.name) == (LASER_SCAN, pattern)]
    if not found:
        problem = f"it has no sensor_msgs/Range: {named_topics(matching)}"
        remedy = "name a sonar's LaserScan in full, or the field with the range: --field range=/TOPIC.FIELD"
        raise InputError("--topic", problem, place=pattern, remedy=remedy)
    return found


def _odometry(topics: Sequence[Topic], options: BagOptions, *, path: Path) -> tuple[Topic, ...]:
    if options.odometry is not None:
        named = _find(options.odometry, topics)
        if named.type not in POSES:
            remedy = "name a topic of nav_msgs/Odometry or geometry_msgs/PoseStamped"
            raise InputError("--odom", f"{named.name} has no poses; its type is {named.type}", remedy=remedy)
        return (named,)
    if all(options.field(key) for key in ("x", "y", "yaw")):
        return ()
    found = tuple(topic for topic in topics if topic.type == ODOMETRY)
    if len(found) > 1:
        problem = f"{len(found)} topics have odometry"
        remedy = f"name one: --odom {' or --odom '.join(topic.name for topic in found)}"
        raise InputError(path, problem, remedy=remedy)
    return found
