"""The device protocol (docs/protocol.md): bytes to messages and back, without any input or output."""

import re
import zlib
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import fields
from typing import Any

from echoplan.errors import InvalidValueError
from echoplan.hardware.messages import BOUNDS, COMMANDS, REPLIES, Message, items

__all__ = ["Decoder", "decode", "encode"]

_LINE = re.compile(rb"\$([ -#%-)+-~]{1,80})\*([0-9A-F]{8})\r?")
# The longest line: "$", a payload, "*", the checksum, carriage return.
_LONGEST = 91
_NUMBER = re.compile(r"0|-?[1-9][0-9]{0,9}")


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
    >>> from echoplan.hardware.messages import Ping
    >>> encode(Ping(token=7))
    b'$ping,7*392F2A6A\n'
    """
    payload = ",".join([message.WORD, *(str(value) for _, value in items(message))]).encode("ascii")
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
    kind = (COMMANDS if is_command else REPLIES).get(word)
    return None if kind is None else _parsed(kind, texts)


def _parsed(kind: type[Message], texts: Sequence[str]) -> Message | None:
    """Make a message of its fields; None if there are more or fewer, or one is out of its bounds."""
    names = [each.name for each in fields(kind)]
    values: dict[str, Any] = dict(zip(names, texts, strict=False))
    for name in BOUNDS.keys() & values.keys():
        # A number has no leading zeros and no plus sign.
        values[name] = int(values[name]) if _NUMBER.fullmatch(values[name]) else values[name]
    try:
        return kind(**values) if len(names) == len(texts) else None
    except InvalidValueError:
        return None


class Decoder:
    """Bytes in pieces of any size, to messages; what is damaged is counted and dropped.

    Examples
    --------
    >>> from echoplan.hardware.messages import Pong
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
