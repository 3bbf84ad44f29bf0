"""A recording that grows sweep by sweep, and keeps every complete sweep even if the program is killed."""

import os
from collections import Counter
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Self

from echoplan.errors import InputError
from echoplan.io.files import check_folder, read_text, readable, writable, write_text
from echoplan.io.pings import MEASURED, REQUIRED
from echoplan.io.recording import PINGS, ROWS, complete_rows, lines_of, measured_columns, read_recording
from echoplan.model import Sweep

__all__ = ["Recorder"]


class Recorder:
    """A recording to which sweeps are appended: a context manager.

    A sweep is on the disk when ``add`` returns. Until the recorder is closed, the file ``pings.rows`` holds the number
    of complete rows, so that an incomplete sweep of a program that was killed is not read. Stamps that would go back,
    because the clock of the computer did, are moved behind those before them.

    Parameters
    ----------
    path : Path
        The folder; it is made if there is none.
    rig : str
        Text of its ``rig.toml``; that of a recording that is continued must be the same.
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
        # How many bytes, rows and sweeps are complete, and the last stamp.
        self._written = Counter[str]()
        self._header: list[str] = []
        self._rig = rig
        if is_there:
            self._continue()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        with writable(self.path / PINGS):
            if self._written["rows"]:
                # A sweep may have been interrupted, or the disk full.
                os.truncate(self.path / PINGS, self._written["bytes"])
            else:
                (self.path / PINGS).unlink(missing_ok=True)
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
        done = self._written
        if not done["rows"]:
            self._header[:] = [*REQUIRED, *measured_columns(sweep)]
            write_text(self.path / "rig.toml", self._rig)
            self._commit()
        measured = tuple(name for name in MEASURED if name in self._header)
        delay_ns = max(done["last_ns"] - int(sweep.stamps_ns[0]), 0)
        numbered = replace(sweep, index=done["sweeps"], stamps_ns=sweep.stamps_ns + delay_ns)
        head = [] if done["rows"] else [",".join(self._header) + "\n"]
        block = "".join([*head, *lines_of(numbered, measured)]).encode()
        with writable(self.path / PINGS), (self.path / PINGS).open("ab") as file:
            # An earlier sweep may not have been written whole.
            file.truncate(done["bytes"])
            file.write(block)
            file.flush()
            os.fsync(file.fileno())
        done.update(bytes=len(block), rows=len(sweep), sweeps=1)
        done["last_ns"] = int(numbered.stamps_ns[-1])
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
        if read_text(self.path / "rig.toml") != self._rig:
            remedy = "leave out --rig, or record into another folder"
            raise InputError(self.path / "rig.toml", "the recording was made with another rig", remedy=remedy)
        header = list(recording.table.header)
        if header not in ([*REQUIRED], [*REQUIRED, *MEASURED]):
            remedy = "record into another folder"
            raise InputError(self.path / PINGS, "it has columns that a device does not measure", remedy=remedy)
        for sweep in recording:
            self._written["rows"] += len(sweep)
            self._written["sweeps"] = sweep.index + 1
            self._written["last_ns"] = int(sweep.stamps_ns[-1])
        with (self.path / PINGS).open("rb") as file:
            file.seek(-1, os.SEEK_END)
            is_whole = rows is None and file.read() == b"\n"
        if not is_whole:
            with (self.path / PINGS).open(encoding="utf-8") as file:
                complete = "".join(islice(file, None if rows is None else 1 + rows))
            write_text(self.path / PINGS, complete.rstrip("\n") + "\n")
        self._header += header
        self._written["bytes"] = (self.path / PINGS).stat().st_size
        self._commit()
