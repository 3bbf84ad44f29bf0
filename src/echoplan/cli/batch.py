"""``echoplan batch``: every recording below a folder, one row each."""

import os
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from echoplan.cli.configuration import method_and_settings
from echoplan.cli.terminal import put, report_files, tracked
from echoplan.errors import MissingExtraError
from echoplan.signals import raised_signals

if TYPE_CHECKING:
    from collections.abc import Sequence

    from echoplan.batch import Row

__all__ = ["run"]

_MAPS, _CSV, _PARQUET = "maps", "batch.csv", "batch.parquet"
# Some recordings could not be mapped; a command that is refused has 2.
_SOME_FAILED = 1


def run(
    folder: Annotated[Path, typer.Argument(help="Folder below which all recordings are mapped.")],
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the table and the maps.")],
    method: Annotated[
        str | None,
        typer.Option(help="Mapping method: joint, or another one that echoplan compare lists.", show_default="joint"),
    ] = None,
    config: Annotated[Path | None, typer.Option(help="Settings of the method, in a [method] table.")] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(help="Address of a dask scheduler whose workers see the same files.", metavar="tcp://HOST:PORT"),
    ] = None,
    jobs: Annotated[int, typer.Option(min=1, help="Processes, without --scheduler.")] = os.cpu_count() or 1,
    retries: Annotated[int, typer.Option(min=0, help="How often a recording that failed is tried again.")] = 1,
) -> None:
    """Map every recording below a folder: batch.csv with a row each, batch.parquet, and maps/.

    Run it again to go on after an interruption: what is finished, and has not changed, is not mapped again. Exit
    status 1 if some recordings could not be mapped.

    Example: echoplan batch recordings/ --out fleet/ --method rcd
    """
    from echoplan.batch import (  # noqa: PLC0415 - --help must not wait for NumPy
        LocalProcesses,
        cluster_executor,
        find_recordings,
        finished_rows,
        plan_jobs,
        rows_csv,
        run_jobs,
    )
    from echoplan.io import check_folder, write_text  # noqa: PLC0415

    name, settings = method_and_settings(config, method)
    check_folder(out, (_CSV, _PARQUET))
    recordings = find_recordings(folder, without=out / _MAPS)
    planned = plan_jobs(recordings, maps=out / _MAPS, method=name, settings=settings)
    rows = finished_rows(planned)
    waiting, before = [job for job in planned if job.name not in rows], len(rows)
    if waiting:
        # What was finished before an interruption is in the table even if this run is interrupted, too.
        write_text(out / _CSV, rows_csv([*rows.values()]))
        workers = cluster_executor(scheduler, shared=(folder, out)) if scheduler else LocalProcesses(jobs)
        with raised_signals(), workers as executor:
            done = run_jobs(waiting, executor, retries=retries)
            rows |= {row.name: row for row in tracked(done, total=len(waiting), task="mapping")}
    _finish(out, [rows[job.name] for job in planned], before=before)


def _finish(out: Path, rows: "Sequence[Row]", *, before: int) -> None:
    """Write the tables and print the outcome; exit with status 1 if a recording could not be mapped."""
    files = _write_tables(out, rows)
    failed = [row for row in rows if row.status == "failed"]
    verdicts = Counter(row.verdict for row in rows if row.status == "ok")
    maps = ", ".join(f"{verdicts[verdict]} {verdict}" for verdict in ("good", "doubtful", "failed"))
    put(f"Recordings: {len(rows)}, of which {before} were mapped before and {len(failed)} could not be mapped")
    put(f"Maps by verdict: {maps}")
    for row in failed:
        put(f"{row.name}: {row.error}")
    report_files(out, [*files, f"{_MAPS}/"])
    if failed:
        raise typer.Exit(_SOME_FAILED)


def _write_tables(out: Path, rows: "Sequence[Row]") -> list[str]:
    """Write the tables; return the names of the files."""
    from echoplan.batch import rows_csv, rows_parquet  # noqa: PLC0415
    from echoplan.io import write_bytes, write_text  # noqa: PLC0415

    write_text(out / _CSV, rows_csv(rows))
    try:
        write_bytes(out / _PARQUET, rows_parquet(rows))
    except MissingExtraError as error:
        (out / _PARQUET).unlink(missing_ok=True)  # it would be the table of an earlier run
        put(f"{_PARQUET} is not written: {error}")
        return [_CSV]
    return [_CSV, _PARQUET]
