"""The host's end of the protocol: commands until they are answered, and the records of a job in their order."""

from collections.abc import Iterator
from dataclasses import fields

from echoplan.errors import InputError
from echoplan.hardware.port import Port
from echoplan.hardware.protocol import (
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

__all__ = ["ask", "change_setting", "end_job", "identify", "records_of", "settings_of"]

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


def ask(port: Port, command: Message, *answers: type[Message]) -> Message:
    """Repeat a command until one of its answers arrives, or a refusal.

    Raises ``InputError`` if none does, ``OSError`` if the connection is lost.
    """
    began = arrived = port.clock()
    sent, lines = began - _REPEAT, port.lines
    while (now := port.clock()) - arrived < _PATIENCE and now - began < _LONGEST:
        if now - sent >= _REPEAT:
            port.send(command)
            sent = now
        messages = list(port.receive())
        if port.lines > lines:
            arrived, lines = now, port.lines
        for message in messages:
            is_busy = isinstance(message, Refused) and message.reason == "busy"
            if isinstance(message, (*answers, Refused)) and _is_answer(message, command) and not is_busy:
                return message
    remedy = "check that it runs the firmware of echoplan, and that no other program has the port open"
    raise InputError(port.name, "no device of echoplan answers", remedy=remedy)


def identify(port: Port) -> Hello:
    """Ask a device what it is.

    Raises as ``ask`` does.
    """
    answer = ask(port, Identify(), Hello)
    assert isinstance(answer, Hello)
    return answer


def end_job(port: Port) -> None:
    """End the job of an earlier host or connection; settings cannot be changed while it goes on.

    Raises as ``ask`` does.
    """
    answer = ask(port, Ping(token=0), Pong)
    if isinstance(answer, Pong) and answer.job:
        ask(port, Stop(job=answer.job), Accepted)


def change_setting(port: Port, name: str, *, value: int) -> None:
    """Change a setting.

    Raises as ``ask`` does, and ``InputError`` if the device refuses.
    """
    answer = ask(port, Set(name=name, value=value), Value)
    if isinstance(answer, Refused):
        problem = f"the device refuses {name} = {value} ({answer.reason})"
        remedy = "change the servo or the firing of the rig, or the limits in the firmware"
        raise InputError(port.name, problem, remedy=remedy)


def settings_of(port: Port, *names: str) -> dict[str, int]:
    """Return the values of settings.

    Raises as ``ask`` does.
    """
    began, asked = port.clock(), -_SILENCE
    known: dict[str, int] = {}
    while not known.keys() >= set(names):
        if (now := port.clock()) - began > _PATIENCE:
            remedy = "update its firmware"
            raise InputError(port.name, f"the device does not report its settings {', '.join(names)}", remedy=remedy)
        if now - asked >= _SILENCE:
            port.send(Config())
            asked = now
        known |= {each.name: each.value for each in port.receive() if isinstance(each, Value)}
    return {name: known[name] for name in names}


def records_of(port: Port, job: int) -> Iterator[Record]:
    """Yield the records of a job in their order, each once.

    They end with ``Done``; without it, the device lost the job or fell silent. Raises ``OSError`` if the connection
    is lost.
    """
    early: dict[int, Record] = {}
    expected, acknowledged = 0, 0
    received = asked = port.clock()
    while (now := port.clock()) - received < _LOST:
        is_repeated = False
        for message in port.receive():
            received = now
            if isinstance(message, Hello) or (isinstance(message, Pong) and message.job != job):
                return
            if isinstance(message, Record) and message.job == job:
                is_repeated |= message.number < expected or message.number in early
                early[message.number] = message
        while expected in early:
            record = early.pop(expected)
            expected += 1
            if isinstance(record, Done):
                port.send(Ack(job=job, next=expected))
                yield record
                return
            yield record
        early = {number: record for number, record in early.items() if number > expected}
        if is_repeated or expected - acknowledged >= _ACKNOWLEDGED:
            port.send(Ack(job=job, next=expected))
            acknowledged = expected
        if now - max(received, asked) > _SILENCE:
            port.send(Ping(token=job))
            asked = now


def _is_answer(message: Message, command: Message) -> bool:
    """Whether an answer belongs to a command: it names the command and repeats its fields."""
    names = {each.name for each in fields(message)} & {each.name for each in fields(command)}
    return getattr(message, "command", command.WORD) == command.WORD and all(
        getattr(message, name) == getattr(command, name) for name in names
    )
