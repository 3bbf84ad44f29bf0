"""One recording of a batch: its fingerprint, its map, and the result that a later batch trusts."""

import json
from collections.abc import Iterable
from dataclasses import dataclass
from hashlib import sha256
from math import isnan
from pathlib import Path
from threading import Lock
from time import perf_counter
from typing import Literal

from pydantic import BaseModel

from echoplan.batch.discovery import Recorded
from echoplan.batch.rows import Row
from echoplan.errors import InputError
from echoplan.io.files import write_text, written_whole
from echoplan.io.scratch import scratch_folder
from echoplan.io.structure import Form, read_json
from echoplan.io.text import format_json
from echoplan.mapping import MapResult, map_source
from echoplan.version import __version__

__all__ = ["Job", "finished_rows", "plan_jobs", "run_job"]

_RESULT, _FORMAT = "result.json", "echoplan-result/1"
# A worker of a cluster may have several threads, but filters of warnings and handlers of logs are those of the process.
_ONE_AT_A_TIME = Lock()


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """A recording to be mapped; it travels between processes and machines.

    Parameters
    ----------
    name : str
        Name of the recording in the table.
    source : str
        What ``open_source`` opens, by its absolute path.
    folder : Path
        Absolute path of the folder for its map.
    method : str
        Name of the method.
    settings : BaseModel
        Settings of the method.
    fingerprint : str
        Of the files of the recording, the method, its settings and the version of echoplan.
    """

    name: str
    source: str
    folder: Path
    method: str
    settings: BaseModel
    fingerprint: str


class _Result(Form):
    """``result.json``: the row of a recording, and what it was made of."""

    format: Literal["echoplan-result/1"]
    fingerprint: str
    row: Row


def plan_jobs(recordings: Iterable[Recorded], *, maps: Path, method: str, settings: BaseModel) -> tuple[Job, ...]:
    """Plan a batch.

    Parameters
    ----------
    recordings : iterable of Recorded
        The recordings as they are now.
    maps : Path
        Folder in which each gets a folder of its name.
    method : str
        Name of the method.
    settings : BaseModel
        Its settings.

    Returns
    -------
    tuple of Job
        One a recording.
    """
    what = [__version__, method, settings.model_dump(mode="json")]
    return tuple(
        Job(
            name=each.name,
            source=str(each.path.absolute()),
            folder=maps.absolute() / each.name,
            method=method,
            settings=settings,
            fingerprint=sha256(json.dumps([*what, *map(_state, each.files)]).encode()).hexdigest(),
        )
        for each in recordings
    )


def _state(file: Path) -> tuple[str, int, int]:
    """Return what distinguishes a file from a changed one; a hash would have to read all of each bag."""
    try:
        status = file.stat()
    except OSError:  # a link to nowhere, a disk that went away: mapping reports it
        return file.name, -1, -1
    return file.name, status.st_size, status.st_mtime_ns


def finished_rows(jobs: Iterable[Job]) -> dict[str, Row]:
    """Return the rows of the recordings that are finished.

    Parameters
    ----------
    jobs : iterable of Job
        The recordings.

    Returns
    -------
    dict of str to Row
        By the names of the recordings; those that have no result, or one of other files, settings or another version,
        are missing.
    """
    rows = ((job.name, _finished_row(job)) for job in jobs)
    return {name: row for name, row in rows if row is not None}


def _finished_row(job: Job) -> Row | None:
    if not (job.folder / "map.json").is_file():
        return None
    try:
        result = read_json(job.folder / _RESULT, _Result)
    except InputError:
        return None
    return result.row if result.fingerprint == job.fingerprint else None


def run_job(job: Job) -> Row:
    """Map a recording and write its folder whole, unless it is finished already.

    Parameters
    ----------
    job : Job
        The recording.

    Returns
    -------
    Row
        Its row.

    Raises
    ------
    EchoplanError
        If it cannot be read or mapped, or its folder cannot be written.
    """
    if (finished := _finished_row(job)) is not None:
        # By a worker that outlived the batch that started it.
        return finished
    if (job.folder / _RESULT).is_file():
        # Of other files or settings: nobody shall trust it if mapping fails now. It goes in one step, and the new one
        # comes in one: files of both never lie together.
        with scratch_folder(job.folder) as scratch:
            job.folder.rename(scratch / job.folder.name)
    with _ONE_AT_A_TIME:
        start = perf_counter()
        result = map_source(job.source, method=job.method, settings=job.settings)
        row = _row(job, result, seconds=perf_counter() - start)
    with written_whole(job.folder) as draft:
        result.save(draft)
        document = {"format": _FORMAT, "fingerprint": job.fingerprint, "row": row.model_dump()}
        write_text(draft / _RESULT, format_json(document))
    return row


def _row(job: Job, result: MapResult, *, seconds: float) -> Row:
    found = result.feature_map
    walls = None if result.plan.truth is None else result.evaluate().matches.walls.tally
    return Row(
        name=job.name,
        status="ok",
        verdict=None if found.quality is None else found.quality.verdict.value,
        walls=len(found.walls),
        corners=len(found.corners),
        cylinders=len(found.cylinders),
        openings=len(found.openings),
        sweeps=len(result.sweeps),
        pings=sum(map(len, result.sweeps)),
        seconds=round(seconds, 3),
        wall_recall=None if walls is None or isnan(walls.recall) else walls.recall,
        wall_precision=None if walls is None or isnan(walls.precision) else walls.precision,
    )
