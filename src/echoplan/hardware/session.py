"""The host's end of the protocol: commands until they are answered, and the records of a session in their order."""

from collections.abc import Iterator
from dataclasses import fields
from typing import TypeVar

from echoplan.errors import InputError
from echoplan.hardware.port import Port
from echoplan.hardware.protocol import (
    Accepted,
    Ack,
    Done,
    Hello,
    Identify,
    Message,
    Move,
    Ping,
    Pong,
    Record,
    Refused,
    Set,
    Stop,
    Sweeps,
    Value,
)

__all__ = ["change_setting", "identify", "records_of", "stop_session"]

Answer = TypeVar("Answer", bound=Message)

# A command is repeated this often [s]: a line takes 8 ms at 115200 baud.
_REPEAT = 0.1
# An Arduino resets when its port is opened, and its bootloader waits 1 to 2 s; a line with 1 % wrong bits needs about 30 attempts.
_PATIENCE = 10.0
# A device is asked whether it still has the session after this silence [s]; it is lost after the longer one.
_SILENCE, _LOST = 0.5, 10.0
# Records from one acknowledgement to the next.
_ACKNOWLEDGED = 8


def identify(port: Port) -> Hello:
    """Ask a device what it is.

    Raises ``InputError`` if it does not answer, ``OSError`` if the connection is lost.
    """
    return _ask(port, Identify(), Hello)


def change_setting(port: Port, name: str, *, value: int) -> None:
    """Change a setting.

    Raises ``InputError`` if it is refused or not answered, ``OSError`` if the connection is lost.
    """
    _ask(port, Set(name=name, value=value), Value)


def stop_session(port: Port, session: int) -> None:
    """End a session.

    Raises ``InputError`` if it is not answered, ``OSError`` if the connection is lost.
    """
    _ask(port, Stop(session=session), Accepted)


def records_of(port: Port, command: Sweeps | Move) -> Iterator[Record | None]:
    """Yield the records of a session in their order, each once, and None while none arrive.

    They end with ``Done``; without it, the device was reset or the connection was lost.

    Raises ``InputError`` if the command is refused.
    """
    early: dict[int, Record] = {}
    expected, acknowledged = 0, 0
    is_accepted = False
    heard = asked = port.clock()
    port.send(command)
    while port.clock() - heard < _LOST:
        is_repeated = False
        for message in port.receive():
            heard = port.clock()
            if isinstance(message, Refused) and message.command == command.WORD and not is_accepted:
                raise InputError(port.name, f"the device refuses to {command.WORD}: {message.reason}", remedy=_REFUSAL)
            if _is_lost(message, command.session, is_accepted=is_accepted):
                return
            is_accepted |= getattr(message, "session", 0) == command.session
            if isinstance(message, Record) and message.session == command.session:
                is_repeated |= message.number < expected or message.number in early
                if message.number >= expected:
                    early[message.number] = message
            while expected in early:
                record = early.pop(expected)
                expected += 1
                if isinstance(record, Done):
                    port.send(Ack(session=command.session, next=expected))
                    yield record
                    return
                yield record
        if is_repeated or expected - acknowledged >= _ACKNOWLEDGED:
            port.send(Ack(session=command.session, next=expected))
            acknowledged = expected
        now = port.clock()
        if now - max(heard, asked) > (_SILENCE if is_accepted else _REPEAT):
            port.send(Ping(token=0) if is_accepted else command)
            asked = now
        yield None


_REFUSAL = "wait until the device is idle, or reset it"


def _answers(message: Message, command: Message) -> bool:
    """Whether an answer belongs to a command: it names the command and repeats its fields."""
    names = {each.name for each in fields(message)} & {each.name for each in fields(command)}
    return getattr(message, "command", command.WORD) == command.WORD and all(
        getattr(message, name) == getattr(command, name) for name in names
    )


def _is_lost(message: Message, session: int, *, is_accepted: bool) -> bool:
    """Whether a message shows that the device does not have the session any more."""
    if isinstance(message, Pong):
        return is_accepted and message.session != session
    return is_accepted and isinstance(message, Hello)


def _ask(port: Port, command: Message, kind: type[Answer]) -> Answer:
    """Repeat a command until it is answered."""
    began = sent = port.clock()
    port.send(command)
    while port.clock() - began < _PATIENCE:
        for message in port.receive():
            if isinstance(message, Refused) and message.command == command.WORD:
                problem = f"the device refuses {command}: {message.reason}"
                raise InputError(port.name, problem, remedy=_REFUSAL)
            if isinstance(message, kind) and _answers(message, command):
                return message
        if port.clock() - sent > _REPEAT:
            port.send(command)
            sent = port.clock()
    remedy = "check that the firmware of echoplan runs on it, and that no other program has the port open"
    raise InputError(port.name, f"no device answers within {_PATIENCE:.0f} s", remedy=remedy)
