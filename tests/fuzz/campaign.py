"""A campaign against the readers and the command line: ``make fuzz SEED=7 SECONDS=120``.

Random cases, each from the seed and its number, run in forked processes in which everything is imported.  A fault is a
foreign exception, a message that is not one line, a word too many, a half-written result, a hang, or more than 1 GB.
"""

import argparse
import contextlib
import io
import os
import re
import resource
import shlex
import shutil
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from random import Random
from unittest.mock import patch

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

# Threads of numerical libraries do not survive a fork, and a process that waits for them hangs.
os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1", MKL_NUM_THREADS="1")
sys.path.insert(0, str(Path(__file__).parents[1]))

from echoplan.cli.main import main as echoplan
from fuzz.cases import Case, draw_case, read_twice
from helpers.killed import die_before

__all__ = ["main"]

_MOST_MEMORY = 1_000_000_000  # bytes
_LONGEST = 30.0  # seconds of processor time, on a machine that may be busy
_FAULTS = Path("out/fuzz")


@dataclass(frozen=True, slots=True, kw_only=True)
class Running:
    """A case in a process of its own."""

    number: int
    case: Case
    folder: Path
    before: dict[str, bytes]


def main() -> int:
    """Run cases until the time is over; print what was found, and return 1 if a fault was."""
    parser = argparse.ArgumentParser(description="Fuzz the readers and the command line.")
    parser.add_argument("--seed", type=int, default=Random().randrange(1000))
    parser.add_argument("--seconds", type=float, default=120.0)
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--only", type=int, help="run this case and no other")
    options = parser.parse_args()
    sys.stdout.write(f"seed {options.seed}: make fuzz SEED={options.seed} SECONDS={options.seconds:g}\n")
    sys.stdout.flush()
    with tempfile.TemporaryDirectory(prefix="echoplan-fuzz-") as work:
        base = _make_base(Path(work) / "base")
        faults, cases, seconds = _campaign(base, Path(work), options)
    sys.stdout.write(f"{cases} cases in {seconds:.0f} s, {faults.total()} with a fault\n")
    for kind, count in faults.most_common():
        sys.stdout.write(f"{count:5} {kind}: {_FAULTS / _slug(kind)}\n")
    return 1 if faults else 0


def _campaign(base: Path, work: Path, options: argparse.Namespace) -> tuple[Counter[str], int, float]:
    faults, running, number, start = Counter[str](), dict[int, Running](), 0, time.monotonic()
    columns = (
        TextColumn("{task.fields[cases]} cases, {task.fields[faults]} faults"),
        BarColumn(),
        TimeRemainingColumn(),
    )
    console = Console(stderr=True)
    with Progress(*columns, console=console, disable=not console.is_terminal, transient=True) as progress:
        task = progress.add_task("", total=options.seconds, cases=0, faults=0)
        while running or _goes_on(number, start, options):
            while len(running) < options.jobs and _goes_on(number, start, options):
                chosen = number if options.only is None else options.only
                pid, started = _start(base, work / str(chosen), chosen, options.seed)
                running[pid] = started
                number += 1
            pid, status, usage = os.wait4(-1, 0)
            ended = running.pop(pid)
            kind = _judge(ended, base, os.waitstatus_to_exitcode(status), usage)
            if kind:
                _keep(ended, kind, options.seed, first=not faults[kind])
                faults[kind] += 1
            shutil.rmtree(ended.folder)
            elapsed = time.monotonic() - start
            progress.update(task, completed=elapsed, cases=number, faults=faults.total())
    return faults, number, time.monotonic() - start


def _goes_on(number: int, start: float, options: argparse.Namespace) -> bool:
    return number == 0 if options.only is not None else time.monotonic() - start < options.seconds


def _make_base(base: Path) -> Path:
    """Make the files that are mutated, by echoplan itself, and so import and compile all that cases need."""
    base.mkdir()
    for words in (
        "simulate square --out rec --seed 1",
        "info rec",
        "map rec --out joint",
        "map rec --out old --method mdp-fuzzy",
        "map rec --out new --method rcd",
        "evaluate old rec",
    ):
        typed = ["echoplan", *words.split()]
        with (
            patch.object(sys, "argv", typed),
            contextlib.chdir(base),
            contextlib.redirect_stdout(io.StringIO()),
            contextlib.suppress(SystemExit),
        ):
            echoplan()
    shutil.rmtree(base / "joint")
    (base / "world.toml").write_text(
        "[[wall]]\npoints = [[0.0, 0.0], [3.0, 0.0], [3.0, 2.5], [0.0, 2.5]]\nclosed = true\n"
        "[[cylinder]]\ncenter = [2.0, 1.5]\nradius = 0.1\n"
    )
    (base / "world.csv").write_text("t,x,y,yaw\n0,1.0,1.0,0.0\n1.5,1.5,1.2,0.4\n")
    return base


def _start(base: Path, folder: Path, number: int, seed: int) -> tuple[int, Running]:
    case = draw_case(base, folder, Random(f"{seed}:{number}"))
    running = Running(number=number, case=case, folder=folder, before=_files(folder / case.out) if case.out else {})
    pid = os.fork()
    if not pid:
        _become(folder, case)
    return pid, running


def _become(folder: Path, case: Case) -> None:
    """Run a case in this process, which ends with it."""
    status = 1
    try:
        os.chdir(folder)
        for name, number in (("stdout", 1), ("stderr", 2)):
            os.dup2(os.open(name, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), number)
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        resource.setrlimit(resource.RLIMIT_CPU, (int(_LONGEST), int(_LONGEST) + 1))
        resource.setrlimit(resource.RLIMIT_AS, (6 * _MOST_MEMORY, 6 * _MOST_MEMORY))
        signal.alarm(int(6 * _LONGEST))
        die_before(case.kill_step)
        if case.kill_time:
            # Nothing handles the signal of this timer: it ends the process as SIGKILL does.
            signal.setitimer(signal.ITIMER_REAL, case.kill_time)
        if case.words[0] == "read twice":
            read_twice(Path(case.words[1]))
        else:
            sys.argv = ["echoplan", *case.words]
            echoplan()
        status = 0
    except SystemExit as ended:
        status = int(ended.code or 0)
    except BaseException:  # noqa: BLE001 - what a case raises is what the campaign looks for
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)


def _judge(ended: Running, base: Path, status: int, usage: resource.struct_rusage) -> str:
    """Name the fault of a case; nothing if there is none."""
    said = (ended.folder / "stderr").read_text(errors="replace")
    if "Traceback" in said:
        frames = re.findall(r'echoplan/([\w/]+\.py)", line \d+, in (\w+)', said)
        where = " in {} {}".format(*frames[-1]) if frames else ""
        return f"{said.strip().splitlines()[-1].partition(':')[0]}{where}"
    if usage.ru_maxrss * 1024 > _MOST_MEMORY:
        return f"memory of {ended.case.name}"
    if ended.case.is_killed:
        return _judge_killed(ended, base)
    return _judge_words(ended, status, said) or _judge_out(ended, status)


def _judge_words(ended: Running, status: int, said: str) -> str:
    if status not in (0, 2):
        return f"status {status} of {ended.case.name}"
    if status == 2 and (len(said.splitlines()) != 1 or not said.startswith("echoplan: ")):
        return f"not one line from {ended.case.name}"
    warned = len(said.splitlines()) == 1 and said.startswith("echoplan: the map failed: ")
    if status == 0 and said and not warned:
        return f"noise from {ended.case.name}: {re.sub(r'[^A-Za-z]+', ' ', said.splitlines()[0])[-40:]}"
    return ""


def _judge_out(ended: Running, status: int) -> str:
    after = _files(ended.folder / ended.case.out) if ended.case.out else {}
    if status == 2 and after != ended.before:
        return f"refused but changed by {ended.case.name}"
    scratch = any(".echoplan-" in name for name in [*after, *map(str, ended.folder.iterdir())])
    return f"scratch left by {ended.case.name}" if scratch else ""


def _judge_killed(ended: Running, base: Path) -> str:
    after, old, new = (_files(folder) for folder in (ended.folder / "out", base / "old", base / "new"))
    kept = {name: data for name, data in after.items() if name in old or name in new}
    return "" if kept in (old, new) else "mixed after a kill"


def _files(folder: Path) -> dict[str, bytes]:
    """What a folder holds, scratch folders apart."""
    if not os.path.isdir(folder):  # noqa: PTH112 - pathlib raises for a name that is too long
        return {}
    files = (path for path in folder.rglob("*") if path.is_file() and ".echoplan-" not in str(path.parent))
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


def _slug(kind: str) -> str:
    return re.sub(r"\W+", "-", kind).strip("-").lower()


def _keep(ended: Running, kind: str, seed: int, *, first: bool) -> None:
    """Keep the input of the first fault of its kind, with the commands that repeat it."""
    if not first:
        return
    place = _FAULTS / _slug(kind)
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir(parents=True)
    # Pipes cannot be copied.
    shutil.copytree(
        ended.folder, place / "input", symlinks=True, ignore=lambda at, names: [n for n in names if _is_pipe(at, n)]
    )
    command = shlex.join(("echoplan", *ended.case.words))
    again = f"python tests/fuzz/campaign.py --seed {seed} --only {ended.number}"
    (place / "cmd.sh").write_text(f"cd input && {command}\n# {ended.case}\n# {again}\n", errors="replace")


def _is_pipe(folder: str, name: str) -> bool:
    path = Path(folder) / name
    return path.is_fifo()


if __name__ == "__main__":
    sys.exit(main())
