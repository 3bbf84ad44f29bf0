"""How commands write a folder of results."""

import signal
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import NoReturn

__all__ = ["output_folder"]


@contextmanager
def output_folder(folder: Path, *, stale: Iterable[str] = ()) -> Iterator[Path]:
    """Write a folder as ``written_whole`` does, and leave no scratch folder when the process is terminated.

    Parameters
    ----------
    folder : Path
        The folder; it is made if it is not there.
    stale : iterable of str, optional
        Files of an earlier run, relative to the folder: they go unless the block writes them.

    Yields
    ------
    Path
        Where to write, instead of the folder.

    Raises
    ------
    OutputError
        If the operating system refuses; the folder is as it was before.
    """
    from echoplan.io import written_whole  # noqa: PLC0415 - --help must not wait for NumPy

    before = signal.signal(signal.SIGTERM, _exit)
    try:
        with written_whole(folder, stale=stale) as draft:
            yield draft
    finally:
        signal.signal(signal.SIGTERM, before)


def _exit(number: int, _: FrameType | None) -> NoReturn:
    # The status that shells report for a signal.
    sys.exit(128 + number)
