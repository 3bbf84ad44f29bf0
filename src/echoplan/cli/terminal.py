"""What the commands have in common on the terminal: progress, tables, and where results went."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table as RichTable

if TYPE_CHECKING:
    from echoplan.model import Rig, Source, Sweep, Table


__all__ = ["Progressing", "console", "report_files", "show", "tracked"]

Item = TypeVar("Item")

_PIPE_WIDTH = 200


def console() -> Console:
    """Return the console that commands print to.

    Returns
    -------
    Console
        Of standard output; plain text where that is no terminal.
    """
    # What goes into a pipe or a file must not be folded at the width of a terminal that is not there.
    plain = Console(highlight=False, markup=False)
    return plain if plain.is_terminal else Console(highlight=False, markup=False, width=_PIPE_WIDTH)


def show(table: "Table") -> None:
    """Print a table: numbers to the right.

    Parameters
    ----------
    table : Table
        The table.
    """
    drawn = RichTable(title=table.title, title_justify="left", title_style="bold", box=None, pad_edge=False)
    for number, head in enumerate(table.columns):
        drawn.add_column(head, justify="right" if number else "left")
    for row in table.rows:
        drawn.add_row(*row)
    console().print(drawn)
    console().print()


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
    with Progress(*columns, console=stderr, transient=True, disable=not stderr.is_terminal) as progress:
        yield from progress.track(items, total=total, description=task)


def report_files(folder: Path, names: list[str]) -> None:
    """Say which files were written.

    Parameters
    ----------
    folder : Path
        Where they are.
    names : list of str
        What they are called.
    """
    console().print(f"Written to {folder}: {', '.join(names)}")
