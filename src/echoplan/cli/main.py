"""The one place where errors become messages.

Whatever takes time to import is imported inside ``main``, where signals end the program silently.
"""

import atexit
import io
import os
import signal
import sys
from typing import TextIO

from echoplan.signals import ended_by_signals

__all__ = ["main"]

# Status of a refusal, as of argparse and click.
_REFUSED = 2
# As much of an error as is read: an argument may have a hundred thousand characters.
_LONGEST_MESSAGE = 1000


def main() -> None:
    """Run the command line.

    Bad words, bad input, and whatever the system or the memory refuses become one line on standard error and exit
    status 2; an interrupt is 130, a request to terminate 143.
    """
    with ended_by_signals():
        _prepare_streams()
        status = _run(sys.argv[1:] or ["--help"])
        status = _flush(sys.stdout, is_refused=status == _REFUSED) or status
    # When all is done and Python closes, there is nothing to interrupt any more.
    atexit.register(signal.signal, signal.SIGINT, signal.SIG_IGN)
    sys.exit(status)


def _run(words: list[str]) -> int:
    from typer.exceptions import TyperException  # noqa: PLC0415 - see above

    from echoplan.cli.app import app, as_clause, help_for  # noqa: PLC0415
    from echoplan.errors import EchoplanError  # noqa: PLC0415

    try:
        status = app(words, prog_name="echoplan", standalone_mode=False)
    except EchoplanError as error:
        return _refuse(str(error))
    except TyperException as error:
        return _refuse(f"{as_clause(error.format_message())}; see {help_for(words)}")
    except OSError as error:
        return _refuse(f"{_place_of(error)}: {error.strerror or error}; check the name, the permissions and the disk")
    except MemoryError:
        return _refuse("the memory is not enough; try a shorter recording, or coarser settings")
    except RecursionError:
        return _refuse("the input is nested too deeply; take out a level")
    return int(status or 0)


def _place_of(error: OSError) -> str:
    return os.fsdecode(error.filename) if isinstance(error.filename, str | bytes) else "the system says"


def _refuse(message: str) -> int:
    if len(message) > _LONGEST_MESSAGE:
        half = _LONGEST_MESSAGE // 2
        message = f"{message[:half]} ... {message[-half:]}"
    # A name may hold line ends, commands to a terminal, and bytes that are no text.
    line = "".join(each if each.isprintable() else repr(each)[1:-1] for each in message)
    try:
        sys.stderr.write(f"echoplan: {line}\n")
    except OSError:
        _discard(sys.stderr)
    _flush(sys.stderr)
    return _REFUSED


def _flush(stream: TextIO, *, is_refused: bool = False) -> int:
    """Write what a stream still holds; one refusal is enough."""
    try:
        stream.flush()
    except BrokenPipeError:
        # Who reads has had enough, as head has.
        _discard(stream)
    except OSError as error:
        _discard(stream)
        if stream is sys.stdout and not is_refused:
            return _refuse(f"standard output: {error.strerror}; free some space or print to another place")
    return 0


def _discard(stream: TextIO) -> None:
    """Send nowhere what a stream still holds, so that Python does not complain when it closes."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _prepare_streams() -> None:
    """Open the streams that are closed, so that no file gets their numbers, and let them show and read any text."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, os.fdopen(os.open(os.devnull, os.O_RDWR), mode, encoding="utf-8"))
        elif isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")
