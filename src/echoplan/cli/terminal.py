"""What the commands have in common on the terminal: progress, tables, and where results went."""

import logging
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from rich.console import Console
from rich.control import Control
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.segment import ControlType
from rich.table import Table as RichTable

from echoplan.errors import OutputError
from echoplan.signals import at_signal

if TYPE_CHECKING:
    from rich.console import JustifyMethod, RenderableType

    from echoplan.model import Rig, Source, Sweep, Table


__all__ = ["Progressing", "TerminalProgress", "busy", "logging_to", "put", "report_files", "show", "tracked"]

Item = TypeVar("Item")

_PIPE_WIDTH = 200
# Characters between columns.
_GAP = 2


class _Output(Console):
    """Standard output; work goes on when whoever read it has had enough, as ``head`` has."""

    def on_broken_pipe(self) -> None:
        """Send what is still to come nowhere."""
        with suppress(SystemExit):
            super().on_broken_pipe()


def put(thing: "RenderableType" = "") -> None:
    """Print a text or a table to standard output; plain text where that is no terminal.

    Parameters
    ----------
    thing : RenderableType, optional
        What to print; a text is never folded in a pipe.

    Raises
    ------
    OutputError
        If it goes into a file on a full disk.
    """
    plain = _Output(highlight=False, markup=False)
    # What goes into a pipe or a file must not be folded at the width of a terminal that is not there.
    output = plain if plain.is_terminal else _Output(highlight=False, markup=False, width=_PIPE_WIDTH)
    try:
        output.print(thing, soft_wrap=isinstance(thing, str) and not plain.is_terminal)
    except OSError as error:
        output.on_broken_pipe()
        remedy = "free some space or print to another place"
        raise OutputError("standard output", error.strerror or str(error), remedy=remedy) from error


def show(table: "Table") -> None:
    """Print a table: numbers to the right; columns for which a terminal is too narrow come below the others.

    Parameters
    ----------
    table : Table
        The table.
    """
    # Heads are folded between words, and nothing else is.
    words = [[*head.split(), *(row[place] for row in table.rows)] for place, head in enumerate(table.columns)]
    widths = [max(map(len, own), default=0) for own in words]
    for number, places in enumerate(_side_by_side(widths, _room())):
        drawn = _drawn(table, {place: widths[place] for place in places})
        drawn.title = None if number else table.title
        put(drawn)
        put()


def _drawn(table: "Table", widths: dict[int, int]) -> RichTable:
    """Draw some columns as wide as their heads, or no wider than they must be."""
    drawn = RichTable(title_justify="left", title_style="bold", box=None, pad_edge=False)
    natural = sum(max(width, len(table.columns[place])) + _GAP for place, width in widths.items()) - _GAP
    for place, width in widths.items():
        justify: JustifyMethod = "right" if place else "left"
        drawn.add_column(table.columns[place], justify=justify, width=width if natural > _room() else None)
    for row in table.rows:
        drawn.add_row(*(row[place] for place in widths))
    return drawn


def _room() -> int:
    plain = Console()
    return plain.width if plain.is_terminal else _PIPE_WIDTH


def _side_by_side(widths: list[int], room: int) -> Iterator[list[int]]:
    """Split columns into blocks that fit, each of which repeats the first column, which names the rows."""
    places, taken = [0], widths[0]
    for place, width in enumerate(widths[1:], start=1):
        if taken + _GAP + width > room and len(places) > 1:
            yield places
            places, taken = [0], widths[0]
        places.append(place)
        taken += _GAP + width
    yield places


class Progressing:
    """A source that shows a bar on the terminal while its sweeps are read.

    Parameters
    ----------
    source : Source
        The source.
    task : str
        What is being done.
    """

    def __init__(self, source: "Source", task: str) -> None:
        self.source = source
        self.task = task

    @property
    def name(self) -> str:
        """Name of the source."""
        return self.source.name

    @property
    def rig(self) -> "Rig":
        """Rig of the source."""
        return self.source.rig

    def __len__(self) -> int:
        return len(self.source)

    def __iter__(self) -> Iterator["Sweep"]:
        """Yield the sweeps, and draw the bar."""
        return tracked(self.source, total=len(self.source), task=self.task)


def tracked(items: Iterable[Item], *, total: int, task: str) -> Iterator[Item]:
    """Pass items on, and draw a bar on standard error if that is a terminal.

    Parameters
    ----------
    items : iterable
        The items.
    total : int
        How many there are.
    task : str
        What is being done.

    Yields
    ------
    object
        The same items.
    """
    stderr = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    progress = Progress(*columns, console=stderr, transient=True, disable=not stderr.is_terminal)
    with logging_to(stderr), at_signal(partial(_clear, stderr)), progress:
        yield from progress.track(items, total=total, description=task)


@contextmanager
def busy(task: str) -> Iterator[None]:
    """Show on standard error, if that is a terminal, that something is being done of unknown duration.

    Parameters
    ----------
    task : str
        What is being done.
    """
    stderr = Console(stderr=True)
    with logging_to(stderr), at_signal(partial(_clear, stderr)), stderr.status(task):
        yield


def _clear(console: Console) -> None:
    """Erase the line of a progress bar, and show the cursor that it hides."""
    if console.is_terminal:
        console.control(Control(ControlType.CARRIAGE_RETURN, (ControlType.ERASE_IN_LINE, 2), ControlType.SHOW_CURSOR))


class TerminalProgress:
    """Progress as bars on standard error, if that is a terminal."""

    track = staticmethod(tracked)
    busy = staticmethod(busy)


class _Printer(logging.Handler):
    """Prints above a bar what is logged."""

    def __init__(self, console: Console) -> None:
        super().__init__(logging.INFO)
        self.console = console

    def emit(self, record: logging.LogRecord) -> None:
        """Print a message."""
        self.console.print(record.getMessage(), highlight=False, markup=False)


@contextmanager
def logging_to(console: Console) -> Iterator[None]:
    """Print what is logged meanwhile, if the console is a terminal."""
    logger, printer = logging.getLogger("echoplan"), _Printer(console)
    level = logger.level
    if console.is_terminal:
        logger.setLevel(logging.INFO)
        logger.addHandler(printer)
    try:
        yield
    finally:
        logger.removeHandler(printer)
        logger.setLevel(level)


def report_files(folder: Path, names: Iterable[str]) -> None:
    """Print which files were written.

    Parameters
    ----------
    folder : Path
        Where they are; the current folder is not named.
    names : iterable of str
        What they are called.
    """
    place = "" if folder == Path() else f" to {folder}"
    put(f"Written{place}: {', '.join(names)}")
