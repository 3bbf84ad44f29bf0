"""How close a batch is to its workers at work all the time: python benchmarks/batch.py [--recordings 1000] [--jobs 2].

Ideal is what plain loops over the same recordings take in warm processes, each of which maps its share with nothing
between: as many loops at a time as the batch has workers, before and after the batch, so that other programs slow down
both alike.  On a machine that is idle a single loop, divided by the number of workers, is the same; it is measured too.
Loops map every k-th recording (--every); what they take is scaled up.  The batch counts with its start and its end.
"""

import argparse
import os
import resource
import subprocess
import sys
import time
from collections.abc import Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from dataclasses import dataclass, replace
from multiprocessing import get_context
from pathlib import Path
from statistics import fmean
from tempfile import TemporaryDirectory

from echoplan.batch import Job, find_recordings, plan_jobs, run_job
from echoplan.cli.terminal import show
from echoplan.methods import find_method
from echoplan.model import Table
from library.fleet import METHOD, write_fleet


@dataclass(frozen=True, slots=True, kw_only=True)
class Spent:
    """Time on the clock, and of the processors [s]."""

    wall: float
    processor: float


def main() -> None:
    """Write a fleet, map it by loops and by the command, and print the times."""
    arguments = parse()
    with TemporaryDirectory() as name:
        folder = Path(name)
        write_fleet(folder / "fleet", arguments.recordings)
        settings = find_method(METHOD).settings_type()
        jobs = plan_jobs(find_recordings(folder / "fleet"), maps=folder / "loops", method=METHOD, settings=settings)
        sample = jobs[:: arguments.every]
        scale = len(jobs) / len(sample)
        load = os.getloadavg()[0]
        with ProcessPoolExecutor(arguments.jobs, mp_context=get_context("spawn")) as pool:
            single = loops(pool, sample, count=1, label="single")
            before = loops(pool, sample, count=arguments.jobs, label="before")
            batch = command(folder, arguments.jobs)
            after = loops(pool, sample, count=arguments.jobs, label="after")
    scale = len(jobs) / len(sample)
    ideals = {
        "one loop, divided by the workers": scale / arguments.jobs * single.wall,
        f"{arguments.jobs} loops at a time, before and after": scale * fmean((before.wall, after.wall)),
    }
    used = scale * arguments.jobs * fmean((before.processor, after.processor))
    rows = (
        *((name, f"{ideal:.1f}", f"{100 * ideal / batch.wall:.0f}") for name, ideal in ideals.items()),
        ("echoplan batch", f"{batch.wall:.1f}", ""),
        (f"{arguments.jobs} loops, processor time", f"{used:.1f}", f"{100 * used / batch.processor:.0f}"),
        ("echoplan batch, processor time", f"{batch.processor:.1f}", ""),
    )
    title = f"{len(jobs)} recordings, {len(sample)} of them for the loops, load of the machine {load:.1f}"
    show(Table(title=title, columns=("what", "time (s)", "ideal / batch (%)"), rows=rows))


def parse() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--recordings", type=int, default=1000)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--every", type=int, default=5, help="loops map every k-th recording")
    return parser.parse_args()


def loops(pool: Executor, jobs: Sequence[Job], *, count: int, label: str) -> Spent:
    """Let loops share jobs among them and run at a time; return their mean."""
    elsewhere = [replace(job, folder=job.folder.parent / f"{label}-{job.folder.name}") for job in jobs]
    spent = list(pool.map(loop, [elsewhere[place::count] for place in range(count)]))
    return Spent(wall=fmean(each.wall for each in spent), processor=fmean(each.processor for each in spent))


def loop(jobs: Sequence[Job]) -> Spent:
    """Map recordings one after another; the first one, which loads code, counts as the mean of the others."""
    first, *others = jobs
    run_job(first)
    wall, processor, scale = time.perf_counter(), time.process_time(), len(jobs) / len(others)
    for job in others:
        run_job(job)
    return Spent(wall=scale * (time.perf_counter() - wall), processor=scale * (time.process_time() - processor))


def command(folder: Path, jobs: int) -> Spent:
    """Run the command; the processor time is that of all its processes."""
    words = ["batch", str(folder / "fleet"), "--out", str(folder / "out"), "--method", METHOD, "--jobs", str(jobs)]
    wall, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-m", "echoplan", *words], check=True, stdout=subprocess.DEVNULL)
    wall, after = time.perf_counter() - wall, resource.getrusage(resource.RUSAGE_CHILDREN)
    return Spent(wall=wall, processor=after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)


if __name__ == "__main__":
    main()
