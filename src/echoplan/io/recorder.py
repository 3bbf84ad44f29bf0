"""A recording that grows sweep by sweep, and keeps every complete sweep even if the program is killed."""

import os
from collections import Counter
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Self

from echoplan.errors import InputError
from echoplan.io.files import check_folder, readable, writable, write_text
from echoplan.io.pings import MEASURED, REQUIRED
from echoplan.io.recording import PINGS, ROWS, complete_rows, lines_of, measured_columns, read_recording
from echoplan.model import Sweep

__all__ = ["Recorder"]


class Recorder:
    """A recording to which sweeps are appended: a context manager.

    A sweep is on the disk when ``add`` returns. Until the recorder is closed, the file ``pings.rows`` holds the number
    of complete rows, so that an incomplete sweep of a program that was killed is not read.

    Parameters
    ----------
    path : Path
        The folder; it is made if there is none.
    rig : str
        Text of its ``rig.toml``; a recording that is continued keeps its own.
    append : bool, optional
        Whether to continue a recording.

    Raises
    ------
    InputError
        If there is a recording that shall not be continued, or one that cannot be.
    OutputError
        If the folder cannot be written.

    Examples
    --------
    >>> from echoplan.io import builtin_rig, format_rig, read_recording
    >>> sweep = Sweep(
    ...     index=0, stamps_ns=[25_000_000], sensor_ids=[0], servo_angles=[0.0], ranges=[1.5],
    ...     map_from_base=[[0.0, 0.0, 0.0]],
    ... )
    >>> path = getfixture("tmp_path") / "recording"
    >>> with Recorder(path, rig=format_rig(builtin_rig("rotary-array"))) as recorder:
    ...     for _ in range(2):
    ...         recorder.add(sweep)
    >>> [sweep.index for sweep in read_recording(path)]
    [0, 1]
    """

    def __init__(self, path: Path, *, rig: str, append: bool = False) -> None:
        with readable(path / PINGS):
            is_there = (path / PINGS).exists()
        if is_there and not append:
            remedy = "name another folder, or continue it with --append"
            raise InputError(path, "it holds a recording already", remedy=remedy)
        check_folder(path, [PINGS, ROWS, "rig.toml"])
        self.path = path
        self._written = Counter[str]()
        self._header: list[str] = []
        self._rig = rig
        if is_there:
            self._continue()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        with writable(self.path / ROWS):
            (self.path / ROWS).unlink(missing_ok=True)

    @property
    def sweeps(self) -> int:
        """Number of sweeps in the recording."""
        return self._written["sweeps"]

    def add(self, sweep: Sweep) -> None:
        """Append a sweep; it gets the next number.

        Raises
        ------
        OutputError
            If it cannot be written; it is not read later.
        """
        is_first = not self._header
        if is_first:
            self._header += [*REQUIRED, *measured_columns(sweep)]
            write_text(self.path / "rig.toml", self._rig)
            self._commit()
        measured = tuple(name for name in MEASURED if name in self._header)
        numbered = replace(sweep, index=self._written["sweeps"])
        head = [",".join(self._header) + "\n"] if is_first else []
        block = "".join([*head, *lines_of(numbered, measured)])
        with writable(self.path / PINGS), (self.path / PINGS).open("a", encoding="utf-8", newline="\n") as file:
            file.write(block)
            file.flush()
            os.fsync(file.fileno())
        self._written.update(rows=len(sweep), sweeps=1)
        self._commit()

    def _commit(self) -> None:
        """Write how many rows are complete."""
        write_text(self.path / ROWS, f"{self._written['rows']}\n")

    def _continue(self) -> None:
        """Count what a recording holds, and remove what a killed program left behind it."""
        rows = complete_rows(self.path)
        if rows == 0:
            with writable(self.path):
                (self.path / PINGS).unlink()
            return
        recording = read_recording(self.path)
        header = list(recording.table.header)
        if header not in ([*REQUIRED], [*REQUIRED, *MEASURED]):
            remedy = "record into another folder"
            raise InputError(self.path / PINGS, "it has columns that a device does not measure", remedy=remedy)
        lengths, last = zip(*((len(sweep), sweep.index) for sweep in recording), strict=True)
        if rows is not None:
            with (self.path / PINGS).open(encoding="utf-8") as file:
                complete = "".join(islice(file, 1 + rows))
            write_text(self.path / PINGS, complete)
        self._header += header
        self._written.update(rows=sum(lengths), sweeps=last[-1] + 1)
        self._commit()
