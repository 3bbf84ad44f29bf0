"""Options for reading a bag: topics, fields of messages, and mountings of sensors."""

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from echoplan.errors import InputError, UnknownNameError
from echoplan.geometry import wrap

__all__ = ["FIELD_KEYS", "BagOptions", "Field", "Mount", "parse_bag_options"]

# Quantities of a field: True if it must be a field of messages, False if it must be a number, None if either will do.
FIELD_KEYS: Mapping[str, bool | None] = {
    "range": True,
    "servo": True,
    "stamp": True,
    "x": None,
    "y": None,
    "yaw": None,
    "field_of_view": False,
    "min_range": False,
    "max_range": False,
}
_EXAMPLE = "write for example --field range=/echo.distance*0.01 or --field x=0"
_FIELD = re.compile(
    r"(?P<key>\w+)=(?:(?P<topic>/[^.\s*]+)(?P<path>(?:\.[a-zA-Z]\w*(?:\[\w+\])*)+)(?:\*(?P<factor>\S+))?"
    r"|(?P<number>[^/\s]\S*))"
)
# Fields, and in brackets the indices of an array.
_STEP = re.compile(r"\w+|\[\w+\]")


@dataclass(frozen=True, slots=True, kw_only=True)
class Field:
    """Where a quantity comes from: a field of the messages of a topic, or a constant.

    Parameters
    ----------
    key : str
        The quantity: one of ``FIELD_KEYS``.
    topic : str
        The topic; empty for a constant.
    path : tuple of str
        Names of fields from the outermost to the innermost; in brackets an index (``"[2]"``) or the name
        of a joint in a JointState (``"[pan]"``).
    factor : float
        Factor that converts the field to metres, radians or seconds; the value of a constant.
    """

    key: str
    topic: str = ""
    path: tuple[str, ...] = ()
    factor: float = 1.0

    def __str__(self) -> str:
        """Write the field as on the command line."""
        return f"{self.topic}.{'.'.join(self.path).replace('.[', '[')}" if self.topic else f"{self.factor:g}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Mount:
    """Where a sensor is mounted, as stated by the user.

    Parameters
    ----------
    frame : str
        Frame of the sensor, or another name of it.
    x, y, yaw : float
        Its pose in the frame of the base [m, m, rad].
    """

    frame: str
    x: float
    y: float
    yaw: float


@dataclass(frozen=True, slots=True, kw_only=True)
class BagOptions:
    """What to read from a bag; by default, the types of the topics decide.

    Parameters
    ----------
    topics : tuple of str, optional
        Names or patterns (``/sonar_*``) of topics with readings.
    odometry : str, optional
        Topic with the poses of the robot.
    fields : tuple of Field, optional
        Quantities that come from fields of messages of any type, or are constant.
    mounts : tuple of Mount, optional
        Mounting of sensors, instead of the transforms in the bag; a sensor is named by its frame, its topic or, if
        its range is a field, by topic and field.
    """

    topics: tuple[str, ...] = ()
    odometry: str | None = None
    fields: tuple[Field, ...] = ()
    mounts: tuple[Mount, ...] = ()

    def field(self, key: str) -> Field | None:
        """Return the field of a quantity if the user names one."""
        return next((field for field in self.fields if field.key == key), None)

    @property
    def ranges(self) -> tuple[Field, ...]:
        """The fields with ranges: one for each sensor."""
        return tuple(field for field in self.fields if field.key == "range")

    def constant(self, key: str) -> float | None:
        """Return the value of a quantity if the user states a constant."""
        field = self.field(key)
        return field.factor if field is not None and not field.topic else None


def parse_bag_options(
    *,
    topics: Iterable[str] = (),
    odometry: str | None = None,
    fields: Iterable[str] = (),
    mounts: Iterable[str] = (),
) -> BagOptions:
    """Read options as they are written on the command line.

    Parameters
    ----------
    topics : iterable of str, optional
        ``"/sonar_left"`` or ``"/sonar_*"``.
    odometry : str, optional
        ``"/odom"``.
    fields : iterable of str, optional
        ``"range=/echo.distance*0.01"``: a quantity, a topic, the field in its messages and what it is multiplied by;
        or ``"x=0"``.
    mounts : iterable of str, optional
        ``"sonar_left=0.1,0.05,1.57"``: a frame and its pose in the base [m, m, rad].

    Returns
    -------
    BagOptions
        The options.

    Raises
    ------
    InputError
        If one cannot be understood.
    UnknownNameError
        If a quantity is unknown.

    Examples
    --------
    >>> parse_bag_options(fields=["servo=/joint_states.position[pan]"]).fields[0].path
    ('position', '[pan]')
    """
    parsed = tuple(map(_parse_field, fields))
    keys = [field.key for field in parsed]
    for key in keys:
        # Each range belongs to another sensor.
        if keys.count(key) > 1 and (key != "range" or len(set(parsed)) < len(parsed)):
            raise InputError("--field", f"{key} is given {keys.count(key)} times", remedy="give it once")
    return BagOptions(
        topics=tuple(topics),
        odometry=odometry,
        fields=parsed,
        mounts=tuple(map(_parse_mount, mounts)),
    )


def _parse_field(text: str) -> Field:
    found = _FIELD.fullmatch(text)
    if found is None:
        raise InputError("--field", f"{text!r} is not KEY=/TOPIC.FIELD or KEY=NUMBER", remedy=_EXAMPLE)
    parts = found.groupdict(default="")
    key, topic = parts["key"], parts["topic"]
    if key not in FIELD_KEYS:
        raise UnknownNameError("quantity of --field", key, known=FIELD_KEYS)
    changes = FIELD_KEYS[key]
    if changes is not None and changes != bool(topic):
        kind, example = ("field", "/TOPIC.FIELD") if changes else ("number", "0.5")
        raise InputError("--field", f"{key} must be a {kind}", remedy=f"write for example --field {key}={example}")
    factor = _number(parts["number"] or parts["factor"] or "1", option=f"--field {key}")
    return Field(key=key, topic=topic, path=tuple(_STEP.findall(parts["path"])), factor=factor)


def _parse_mount(text: str) -> Mount:
    frame, _, pose = text.partition("=")
    numbers = pose.split(",")
    if not frame or len(numbers) != 3:
        remedy = "write for example --mount sonar_left=0.1,0.05,1.57 [m, m, rad]"
        raise InputError("--mount", f"{text!r} is not FRAME=X,Y,YAW", remedy=remedy)
    x, y, yaw = (_number(number, option="--mount") for number in numbers)
    if abs(yaw) > 2 * math.pi:
        remedy = f"write radians: {math.radians(yaw):.4f} if it is in degrees"
        raise InputError("--mount", f"the yaw of {frame}, {yaw:g}, is more than a full turn", remedy=remedy)
    return Mount(frame=frame.strip("/"), x=x, y=y, yaw=float(wrap(yaw)))


def _number(text: str, *, option: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise InputError(option, f"{text!r} is not a finite number", remedy="write digits with a decimal point")
    return number
