"""The messages of the device protocol (docs/protocol.md)."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import Any, ClassVar

from echoplan.errors import InvalidValueError

__all__ = [
    "BOUNDS",
    "COMMANDS",
    "REPLIES",
    "Accepted",
    "Ack",
    "Air",
    "Begin",
    "Config",
    "Done",
    "Echo",
    "End",
    "Hello",
    "Identify",
    "Message",
    "Move",
    "Ping",
    "Pong",
    "Record",
    "Refused",
    "Set",
    "Stop",
    "Sweeps",
    "Value",
    "Wheels",
    "items",
]

_NAME = re.compile(r"[A-Za-z0-9._-]{1,32}")
_WORD, _SIGNED = (0, 2**32 - 1), (-(2**31), 2**31 - 1)
# A field means the same in every message that has it.
BOUNDS: Mapping[str, tuple[int, int]] = MappingProxyType(
    {
        "angle": (-9000, 9000),
        "clock": _WORD,
        "count": (0, 65535),
        "flight": (-1, 65535),
        "job": (0, 65535),
        "left": _SIGNED,
        "next": _WORD,
        "number": _WORD,
        "protocol": (1, 99),
        "pulse": (0, 2500),
        "right": _SIGNED,
        "sensor": (0, 7),
        "sensors": (1, 8),
        "sweep": (0, 65535),
        "temperature": (-5500, 12500),
        "token": (0, 65535),
        "value": (-9000, 9000),
        "window": (1, 255),
    }
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Message:
    """A line of the protocol; its fields are those of the line, in their order.

    Raises
    ------
    InvalidValueError
        If a field is out of its bounds.
    """

    WORD: ClassVar[str]

    def __post_init__(self) -> None:
        for name, value in items(self):
            if name in BOUNDS:
                low, high = BOUNDS[name]
                if not isinstance(value, int) or not low <= value <= high:
                    raise InvalidValueError(f"{name} must be a number from {low} to {high}, not {value!r}")
            elif not _NAME.fullmatch(value):
                raise InvalidValueError(f"{name} must be letters, digits, '.', '_' and '-', not {value!r}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Identify(Message):
    """Ask the device to identify itself."""

    WORD: ClassVar[str] = "hello"


@dataclass(frozen=True, slots=True, kw_only=True)
class Config(Message):
    """Ask for all settings."""

    WORD: ClassVar[str] = "config"


@dataclass(frozen=True, slots=True, kw_only=True)
class Set(Message):
    """Change a setting."""

    WORD: ClassVar[str] = "set"

    name: str
    value: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Ping(Message):
    """Check the connection."""

    WORD: ClassVar[str] = "ping"

    token: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Sweeps(Message):
    """Make sweeps; 0 until stopped."""

    WORD: ClassVar[str] = "sweep"

    job: int
    count: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Stop(Message):
    """End a job."""

    WORD: ClassVar[str] = "stop"

    job: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Move(Message):
    """Report the wheels; with the capability ``drive``, drive to the next station."""

    WORD: ClassVar[str] = "move"

    job: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Ack(Message):
    """All records before a number have arrived."""

    WORD: ClassVar[str] = "ack"

    job: int
    next: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Hello(Message):
    """What a device is."""

    WORD: ClassVar[str] = "hello"

    protocol: int
    firmware: str
    board: str
    sensors: int
    window: int
    capabilities: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Value(Message):
    """A setting."""

    WORD: ClassVar[str] = "value"

    name: str
    value: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Pong(Message):
    """Answer to a ping, with the current job; 0: none."""

    WORD: ClassVar[str] = "pong"

    token: int
    job: int
    clock: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Accepted(Message):
    """A command was received."""

    WORD: ClassVar[str] = "accepted"

    command: str
    job: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Refused(Message):
    """A command cannot be obeyed."""

    WORD: ClassVar[str] = "refused"

    command: str
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Begin(Message):
    """A sweep begins."""

    WORD: ClassVar[str] = "begin"

    job: int
    number: int
    clock: int
    sweep: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Echo(Message):
    """A ping.

    Parameters
    ----------
    job, number : int
        Its job, and its number in the job.
    clock : int
        Time of the trigger by the clock of the device [us].
    sensor : int
        Which sensor.
    pulse : int
        Pulse of the servo [us].
    angle : int
        Angle of the servo [0.01 degrees], counter-clockwise.
    flight : int
        Time of flight [us]; 0: no echo, -1: faulty.
    """

    WORD: ClassVar[str] = "echo"

    job: int
    number: int
    clock: int
    sensor: int
    pulse: int
    angle: int
    flight: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Air(Message):
    """Temperature of the air [0.01 deg C]."""

    WORD: ClassVar[str] = "air"

    job: int
    number: int
    clock: int
    temperature: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Wheels(Message):
    """Counts of the wheel encoders."""

    WORD: ClassVar[str] = "wheels"

    job: int
    number: int
    clock: int
    left: int
    right: int


@dataclass(frozen=True, slots=True, kw_only=True)
class End(Message):
    """A sweep is complete."""

    WORD: ClassVar[str] = "end"

    job: int
    number: int
    clock: int
    sweep: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Done(Message):
    """A job is complete."""

    WORD: ClassVar[str] = "done"

    job: int
    number: int
    clock: int


# A numbered line: its job, its number in the job, and the time of the device [us].
Record = Begin | Echo | Air | Wheels | End | Done


def _by_word(*kinds: type[Message]) -> Mapping[str, type[Message]]:
    return MappingProxyType({kind.WORD: kind for kind in kinds})


COMMANDS = _by_word(Identify, Config, Set, Ping, Sweeps, Stop, Move, Ack)
REPLIES = _by_word(Hello, Value, Pong, Accepted, Refused, Begin, Echo, Air, Wheels, End, Done)


def items(message: Message) -> list[tuple[str, Any]]:
    """Return the fields of a message in their order."""
    return [(each.name, getattr(message, each.name)) for each in fields(message)]
