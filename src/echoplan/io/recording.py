"""Recordings: a folder with ``pings.csv`` and ``rig.toml``, read sweep by sweep however long it is."""

import math
import re
import reprlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from echoplan.arrays import known_median
from echoplan.errors import InputError, InvalidValueError
from echoplan.io.files import by_name, readable, written_whole
from echoplan.io.pings import MEASURED, PING_COLUMNS, REQUIRED, checked_pings
from echoplan.io.rig import read_conventions, read_rig, write_rig
from echoplan.io.table import Rows, Table
from echoplan.io.text import format_seconds
from echoplan.io.truth import read_truth
from echoplan.model import Conventions, Rig, Source, Sweep, Truth

__all__ = [
    "PINGS",
    "ROWS",
    "RecordingFolder",
    "complete_rows",
    "lines_of",
    "measured_columns",
    "read_recording",
    "write_recording",
]

# The table of the pings; beside it, while a recording is being made, how many of its rows are complete.
PINGS, ROWS = "pings.csv", "pings.rows"


@dataclass(frozen=True, eq=False, kw_only=True)
class RecordingFolder:
    """A recording on the disk: a source that holds no more than one sweep and one chunk of rows.

    Parameters
    ----------
    name : str
        Name of the folder.
    rig : Rig
        What made the sweeps.
    table : Table
        The pings.
    folder : Path
        Where it lies.
    conventions : Conventions, optional
        How the table is written; sweeps are in SI and REP 103.
    """

    name: str
    rig: Rig
    table: Table
    folder: Path
    conventions: Conventions = field(default_factory=Conventions)

    @property
    def truth(self) -> Truth | None:
        """The truth that lies beside the pings in ``truth.json``, if there is one."""
        beside = self.folder / "truth.json"
        with readable(beside):
            known = beside.exists()
        return read_truth(beside) if known else None

    def __iter__(self) -> Iterator[Sweep]:
        """Yield the sweeps in the order of time.

        Raises
        ------
        InputError
            Where the file has a fault; the sweeps before it were yielded.
        """
        return _sweeps(checked_pings(self.table, self.rig, self.conventions))

    def __len__(self) -> int:
        return self._count

    @cached_property
    def _count(self) -> int:
        count, last = 0, -1
        for rows in self.table.only("sweep"):
            numbers = rows.data["sweep"]
            count += int(np.count_nonzero(np.diff(numbers, prepend=last)))
            last = numbers[-1]
        return count


@by_name
def read_recording(path: Path) -> RecordingFolder:
    """Open a recording.

    Parameters
    ----------
    path : Path or str
        The folder with ``pings.csv`` and ``rig.toml``.

    Returns
    -------
    RecordingFolder
        A source; its rows are read, and checked, while its sweeps are iterated over.

    Raises
    ------
    InputError
        If the folder, its rig or the header of its pings cannot be used.
    """
    with readable(path):
        if not path.is_dir():
            problem = "it is a file" if path.exists() else "there is no such folder"
            remedy = "name a folder with pings.csv and rig.toml (echoplan convert LOG --to rec/ makes one)"
            raise InputError(path, problem, remedy=remedy)
    with readable(path):
        is_map = (path / "map.json").exists() and not (path / "pings.csv").exists()
    if is_map:
        remedy = "name the folder with pings.csv; echoplan convert MAP --to plan.pdf makes a drawing of a map"
        raise InputError(path, "it holds a map, not a recording", remedy=remedy)
    rig = read_rig(path / "rig.toml")
    table = Table.open(path / "pings.csv", PING_COLUMNS, optional=MEASURED, count=complete_rows(path))
    # Python decodes names that are not UTF-8 to lone surrogates, which cannot be encoded in any file.
    name = path.resolve().name.encode(errors="replace").decode()
    conventions = read_conventions(path / "rig.toml")
    return RecordingFolder(name=name, rig=rig, table=table, folder=path, conventions=conventions)


@by_name
def write_recording(path: Path, source: Source) -> None:
    """Write all sweeps of a source as they come, in SI and REP 103.

    Parameters
    ----------
    path : Path or str
        The folder; made if there is none, else its ``pings.csv`` and ``rig.toml`` are replaced.
    source : Source
        Where the sweeps come from.

    Raises
    ------
    InvalidValueError
        If no ping comes.
    OutputError
        If the folder cannot be written; in both cases nothing in it has changed.

    Examples
    --------
    >>> from echoplan.model import Recording
    >>> from echoplan.io import builtin_rig
    >>> sweep = Sweep(
    ...     index=0, stamps_ns=[25_000_000], sensor_ids=[0], servo_angles=[0.0], ranges=[1.5],
    ...     map_from_base=[[0.0, 0.0, 0.0]],
    ... )
    >>> path = getfixture("tmp_path") / "recording"
    >>> write_recording(path, Recording(name="one", rig=builtin_rig("rotary-array"), sweeps=(sweep,)))
    >>> print((path / "pings.csv").read_text())
    t,sweep,sensor,servo,range,x,y,yaw
    0.025,0,0,0.0,1.5,0.0,0.0,0.0
    <BLANKLINE>
    >>> len(read_recording(path))
    1
    """
    # A count of rows that a killed ``Recorder`` left is of other pings.
    with written_whole(path, stale=[ROWS]) as draft:
        draft.mkdir()
        write_rig(draft / "rig.toml", source.rig)
        with (draft / "pings.csv").open("w", encoding="utf-8", newline="\n") as file:
            pings, measured = 0, tuple[str, ...]()
            for number, sweep in enumerate(source):
                if not number:
                    measured = measured_columns(sweep)
                    file.write(",".join((*REQUIRED, *measured)) + "\n")
                file.writelines(lines_of(sweep, measured))
                pings += len(sweep)
        if not pings:
            raise InvalidValueError(f"{source.name} has no pings to write")


def complete_rows(path: Path) -> int | None:
    """Return how many rows of a recording are complete; None if all are.

    Raises ``InputError`` if the file that says so was changed.
    """
    with readable(path / ROWS):
        if not (path / ROWS).exists():
            return None
        text = (path / ROWS).read_text(encoding="ascii", errors="replace").strip()
    if not re.fullmatch("[0-9]{1,12}", text):
        remedy = "delete it, and the last sweep of pings.csv if it is not complete"
        raise InputError(path / ROWS, f"{reprlib.repr(text)} is not a number of rows", remedy=remedy)
    return int(text)


def measured_columns(first: Sweep) -> tuple[str, ...]:
    """Name what else was measured, by the first sweep."""
    return tuple(name for name in MEASURED if not math.isnan(getattr(first, name)))


def lines_of(sweep: Sweep, measured: tuple[str, ...]) -> Iterator[str]:
    """Yield the rows of a sweep as lines of ``pings.csv``."""
    columns = (sweep.sensor_ids, sweep.servo_angles, sweep.ranges, *sweep.map_from_base.T)
    times = map(format_seconds, sweep.stamps_ns.tolist())
    last = "".join(f",{getattr(sweep, name)!r}" for name in measured)
    for time, *fields in zip(times, *(column.tolist() for column in columns), strict=True):
        yield f"{time},{sweep.index},{','.join(map(repr, fields))}{last}\n"


def _sweeps(chunks: Iterable[Rows]) -> Iterator[Sweep]:
    pending: list[NDArray[np.void]] = []
    for rows in chunks:
        numbers = rows.data["sweep"]
        for piece in np.split(rows.data, np.flatnonzero(np.diff(numbers)) + 1):
            if pending and pending[0]["sweep"][0] != piece["sweep"][0]:
                yield _sweep(pending)
                pending = []
            pending.append(piece)
    yield _sweep(pending)


def _sweep(pieces: list[NDArray[np.void]]) -> Sweep:
    data = np.concatenate(pieces)
    pieces.clear()
    return Sweep(
        index=int(data["sweep"][0]),
        stamps_ns=data["t"],
        sensor_ids=data["sensor"],
        servo_angles=data["servo"],
        ranges=data["range"],
        map_from_base=np.stack([data["x"], data["y"], data["yaw"]], axis=1),
        temperature=known_median(data["temperature"]) if "temperature" in (data.dtype.names or ()) else math.nan,
    )
