"""The device protocol (docs/protocol.md): bytes to messages and back, without any input or output."""

import re
import zlib
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import Any, ClassVar

from echoplan.errors import InvalidValueError

__all__ = [
    "Accepted",
    "Ack",
    "Air",
    "Begin",
    "Config",
    "Decoder",
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
    "decode",
    "encode",
]

_LINE = re.compile(rb"\$([ -#%-)+-~]{1,80})\*([0-9A-F]{8})\r?")
# The longest line: "$", a payload, "*", the checksum, carriage return.
_LONGEST = 91
_NUMBER = re.compile(r"0|-?[1-9][0-9]{0,9}")
_NAME = re.compile(r"[A-Za-z0-9._-]{1,32}")
_WORD, _SIGNED = (0, 2**32 - 1), (-(2**31), 2**31 - 1)
# A field means the same in every message that has it.
_BOUNDS: Mapping[str, tuple[int, int]] = MappingProxyType(
    {
        "angle": (-9000, 9000),
        "clock": _WORD,
        "count": (0, 65535),
        "flight": (-1, 65535),
        "left": _SIGNED,
        "next": _WORD,
        "number": _WORD,
        "protocol": (1, 99),
        "pulse": (0, 2500),
        "right": _SIGNED,
        "sensor": (0, 7),
        "sensors": (1, 8),
        "job": (0, 65535),
        "sweep": (0, 65535),
        "temperature": (-5500, 12500),
        "token": (0, 65535),
        "value": (-9000, 9000),
        "window": (0, 255),
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
        for name, value in _items(self):
            if isinstance(value, int):
                low, high = _BOUNDS[name]
                if not low <= value <= high:
                    raise InvalidValueError(f"{name} must be from {low} to {high}, not {value}")
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
class Record(Message):
    """A numbered line: its job, its number in the job, and the time of the device [us]."""

    job: int
    number: int
    clock: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Begin(Record):
    """A sweep begins."""

    WORD: ClassVar[str] = "begin"

    sweep: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Echo(Record):
    """A ping: pulse [us] and angle [0.01 deg] of the servo, time of flight [us]; 0: no echo, -1: faulty."""

    WORD: ClassVar[str] = "echo"

    sensor: int
    pulse: int
    angle: int
    flight: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Air(Record):
    """Temperature of the air [0.01 deg C]."""

    WORD: ClassVar[str] = "air"

    temperature: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Wheels(Record):
    """Counts of the wheel encoders."""

    WORD: ClassVar[str] = "wheels"

    left: int
    right: int


@dataclass(frozen=True, slots=True, kw_only=True)
class End(Record):
    """A sweep is complete."""

    WORD: ClassVar[str] = "end"

    sweep: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Done(Record):
    """A job is complete."""

    WORD: ClassVar[str] = "done"


def _by_word(*kinds: type[Message]) -> Mapping[str, type[Message]]:
    return MappingProxyType({kind.WORD: kind for kind in kinds})


_COMMANDS = _by_word(Identify, Config, Set, Ping, Sweeps, Stop, Move, Ack)
_REPLIES = _by_word(Hello, Value, Pong, Accepted, Refused, Begin, Echo, Air, Wheels, End, Done)


def encode(message: Message) -> bytes:
    r"""Write a message as a line.

    Parameters
    ----------
    message : Message
        The message.

    Returns
    -------
    bytes
        The line with its line feed.

    Examples
    --------
    >>> encode(Ping(token=7))
    b'$ping,7*392F2A6A\n'
    """
    payload = ",".join([message.WORD, *(str(value) for _, value in _items(message))]).encode("ascii")
    return b"$%b*%08X\n" % (payload, zlib.crc32(payload))


def decode(line: bytes, *, is_command: bool = False) -> Message | None:
    """Read a line without its line feed; None if it is damaged or no line of the protocol.

    Parameters
    ----------
    line : bytes
        The line; what stands before the last ``$`` is ignored.
    is_command : bool, optional
        Whether it was sent by the host.

    Returns
    -------
    Message or None
        The message.

    Examples
    --------
    >>> decode(b"noise $pong,7,0,5*DF0B9839")
    Pong(token=7, job=0, clock=5)
    >>> decode(b"$pong,8,0,5*DF0B9839") is None
    True
    """
    found = _LINE.fullmatch(line, max(line.rfind(b"$"), 0))
    if found is None or zlib.crc32(found[1]) != int(found[2], 16):
        return None
    word, *texts = found[1].decode("ascii").split(",")
    kind = (_COMMANDS if is_command else _REPLIES).get(word)
    names = [] if kind is None else [each.name for each in fields(kind)]
    if kind is None or len(names) != len(texts):
        return None
    values: dict[str, Any] = {}
    for name, text in zip(names, texts, strict=True):
        if name in _BOUNDS and not _NUMBER.fullmatch(text):
            return None
        values[name] = int(text) if name in _BOUNDS else text
    try:
        return kind(**values)
    except InvalidValueError:
        return None


class Decoder:
    """Bytes in pieces of any size, to messages; what is damaged is counted and dropped.

    Examples
    --------
    >>> decoder = Decoder()
    >>> [list(decoder.feed(piece)) for piece in (b"?!$po", encode(Pong(token=7, job=0, clock=5))[3:])]
    [[], [Pong(token=7, job=0, clock=5)]]
    """

    def __init__(self, *, is_host: bool = True) -> None:
        self._is_host = is_host
        self._pending = bytearray()
        self._counts = Counter[str]()

    @property
    def damaged(self) -> int:
        """Number of lines that were dropped."""
        return self._counts["damaged"]

    @property
    def lines(self) -> int:
        """Number of lines."""
        return self._counts["lines"]

    def feed(self, data: bytes) -> Iterator[Message]:
        """Yield the messages that these bytes complete."""
        self._pending += data
        while (end := self._pending.find(b"\n")) >= 0:
            line = bytes(self._pending[:end])
            del self._pending[: end + 1]
            self._counts["lines"] += 1
            message = decode(line, is_command=not self._is_host)
            if message is not None:
                yield message
            elif line.strip():
                self._counts["damaged"] += 1
        # Only the last bytes of endless noise can belong to a message.
        del self._pending[:-_LONGEST]


def _items(message: Message) -> list[tuple[str, Any]]:
    return [(each.name, getattr(message, each.name)) for each in fields(message)]
