"""The host's end of the protocol: commands until they are answered, and the records of a job in their order."""

from collections.abc import Iterator
from dataclasses import fields
from itertools import count, takewhile
from typing import TypeVar

from echoplan.errors import InputError
from echoplan.hardware.messages import (
    Accepted,
    Ack,
    Config,
    Done,
    Hello,
    Identify,
    Message,
    Ping,
    Pong,
    Record,
    Refused,
    Set,
    Stop,
    Value,
)
from echoplan.hardware.port import Port

_Answer = TypeVar("_Answer", bound=Message)

__all__ = ["ask", "change_setting", "current_job", "end_job", "identify", "records_of", "settings_of"]

# A command is repeated this often [s]; a line and its answer take 8 ms at 115200 baud.
_REPEAT = 0.05
# A device is given up after so long without a line [s]: an Arduino resets when its port is opened, and its bootloader
# waits up to 2 s. While damaged lines arrive, the wait is longer: of those in which 1 % of all bits are wrong, 1 in 30
# is whole.
_PATIENCE, _LONGEST = 10.0, 60.0
# After this silence the device is asked whether it still has the job [s]; the longer one ends it.
_SILENCE, _LOST = 0.5, 10.0
# Records from one acknowledgement to the next.
_ACKNOWLEDGED = 8


def ask(port: Port, command: Message, *, answer: type[_Answer]) -> _Answer | Refused:
    """Repeat a command until its answer arrives, or a refusal.

    Raises ``InputError`` if neither does, ``OSError`` if the connection is lost.
    """
    for message in _answers_to(port, command):
        if isinstance(message, answer | Refused) and _is_answer(message, command):
            # A job ends with its current ping: until then a device is busy.
            if isinstance(message, Refused) and message.reason == "busy":
                continue
            return message
    remedy = "check that it runs the firmware of echoplan, and that no other program has the port open"
    raise InputError(port.name, "no device of echoplan answers", remedy=remedy)


def identify(port: Port) -> Hello:
    """Ask a device what it is.

    Raises as ``ask`` does, and ``InputError`` if the device refuses.
    """
    return _required(port, Identify(), answer=Hello)


def current_job(port: Port) -> int:
    """Return the job of a device; 0 if it was reset since.

    Raises as ``ask`` does, and ``InputError`` if the device refuses.
    """
    return _required(port, Ping(token=0), answer=Pong).job


def end_job(port: Port) -> int:
    """End the current job, since no setting can be changed during one; return its number, 0 if there is none.

    Raises as ``ask`` does.
    """
    job = current_job(port)
    if job:
        ask(port, Stop(job=job), answer=Accepted)
    return job


def change_setting(port: Port, name: str, *, value: int) -> None:
    """Change a setting.

    Raises as ``ask`` does, and ``InputError`` if the device refuses.
    """
    answer = ask(port, Set(name=name, value=value), answer=Value)
    if isinstance(answer, Refused):
        problem = f"the device refuses {name} = {value} ({answer.reason})"
        remedy = "change the servo or the firing of the rig, or the limits in the firmware"
        raise InputError(port.name, problem, remedy=remedy)


def settings_of(port: Port, *names: str) -> dict[str, int]:
    """Return the values of settings.

    Raises as ``ask`` does.
    """
    known: dict[str, int] = {}
    for message in _answers_to(port, Config()):
        if isinstance(message, Value):
            known[message.name] = message.value
        if known.keys() >= set(names):
            return {name: known[name] for name in names}
    problem = f"the device does not report its settings {', '.join(names)}"
    raise InputError(port.name, problem, remedy="update its firmware")


def records_of(port: Port, job: int, *, start: int) -> Iterator[Record]:
    """Yield the records of a job in their order from a number on, each once.

    They end with ``Done``; without it, the device lost the job or fell silent. Raises ``OSError`` if the connection
    is lost.
    """
    early: dict[int, Record] = {}
    expected = acknowledged = start
    for records in _records_from(port, job):
        arrived = len(early) + len(records)
        early |= {each.number: each for each in records if each.number >= expected}
        is_repeated = len(early) < arrived
        ready = [early.pop(number) for number in takewhile(early.__contains__, count(expected))]
        expected += len(ready)
        is_done = Done in map(type, ready)
        if any((is_done, is_repeated, expected - acknowledged >= _ACKNOWLEDGED)):
            port.send(Ack(job=job, next=expected))
            acknowledged = expected
        yield from ready
        if is_done:
            return


def _required(port: Port, command: Message, *, answer: type[_Answer]) -> _Answer:
    """Ask what a device of this protocol does not refuse."""
    given = ask(port, command, answer=answer)
    if isinstance(given, Refused):
        problem = f"the device refuses {command.WORD!r} ({given.reason})"
        raise InputError(port.name, problem, remedy="update its firmware")
    return given


def _answers_to(port: Port, command: Message) -> Iterator[Message]:
    """Repeat a command and yield what arrives, until the device is given up."""
    began = port.clock()
    sent = -_REPEAT
    # The silence before the command does not count.
    while (waited := port.clock() - began) < _LONGEST and min(waited, port.silence) < _PATIENCE:
        if waited - sent >= _REPEAT:
            port.send(command)
            sent = waited
        for message in port.receive():
            if isinstance(message, Record):
                port.early.append(message)
            else:
                yield message


def _records_from(port: Port, job: int) -> Iterator[list[Record]]:
    """Yield what arrives of a job until the device has lost it or is given up; a silent device is asked."""
    began = port.clock()
    while min(port.clock() - began, port.silence) < _LOST:
        messages = [*port.early, *port.receive()]
        port.early.clear()
        # A device that was reset greets, or has job 0.
        if {getattr(each, "job", 0) for each in messages if isinstance(each, Hello | Pong)} - {job}:
            return
        if port.silence > _SILENCE:
            port.send(Ping(token=0))
        yield [each for each in messages if isinstance(each, Record) and each.job == job]


def _is_answer(message: Message, command: Message) -> bool:
    """Whether an answer belongs to a command: it names the command and repeats its fields."""
    names = {each.name for each in fields(message)} & {each.name for each in fields(command)}
    return getattr(message, "command", command.WORD) == command.WORD and all(
        getattr(message, name) == getattr(command, name) for name in names
    )
