"""Show that a change of the code makes no map worse: python benchmarks/gate.py BASELINE [--statistical] [--only NAME].

BASELINE is a commit, for example ``main`` or ``HEAD~3``.  Simulates 30 recordings of every kind (rooms, drives, places
measured by hand, heads with faulty servos, ray cones, flats with doors, classical methods; real recordings where they
are present), maps each with the code of the baseline and with the code of this working tree, by the command line, and
compares the maps to the last bit.  Renamed keys (``RENAMED``) do not count, neither do the settings of the run nor the
wording of the verdict.  Prints the first difference of each map, and exits with status 1 if there is one.

``--statistical`` is for changes that may change maps.  It maps 306 recordings of nine kinds (``library.populations``)
with both versions and compares, kind by kind: recall and precision of walls, corners and cylinders (at most one object
in 200 may be lost), the median and the 95th percentile of their errors (at most 5 % greater), the share of true objects
within 95 % ellipses (at most 1.5 % lower), and CPU time (at most 20 % more).  ``--hold-out`` takes other recordings, at
which nobody looks while a rule or a number is chosen.  ``--share`` takes a part of the recordings.

The maps of a baseline are kept in ``out/gate/``, so that a second run maps each recording only once.
"""

import argparse
import json
import math
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from echoplan.cli.terminal import show, tracked
from echoplan.evaluation import evaluate
from echoplan.io import read_map, read_truth, write_recording, write_truth
from echoplan.model import Source
from library.flats import random_flat
from library.paired import Scores
from library.paired import compare as compare_two
from library.populations import POPULATIONS, Population, by_hand, rays
from library.rooms import random_drive, random_simulation

ROOT = Path(__file__).resolve().parents[1]
KEPT = ROOT / "out" / "gate"
# Real recordings, where this machine has them.
REAL = ROOT.parent / "shared" / "data"
# Keys of map.json that were renamed since the baseline: old to new.
RENAMED: Mapping[str, str] = {}
# Parts of map.json that a refactoring may change: settings are renamed, sentences are rewritten.
IGNORED = ("parameters", "reasons", "next_step", "version")


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """One map: what is mapped (None: the folder exists already), by which method, and how poses are treated."""

    name: str
    make: Callable[[], Source] | None = None
    folder: Path | None = None
    options: tuple[str, ...] = ()


def cases() -> list[Case]:
    """List the maps that are compared."""
    found = [Case(name=f"room-{seed}", make=partial(random_simulation, seed)) for seed in range(500, 507)]
    found.append(Case(name="ring-507", make=partial(random_simulation, 507, array="ring-16")))
    found += [
        Case(name=f"drive-{seed}", make=partial(random_drive, seed), options=("--poses", "correct"))
        for seed in range(500, 504)
    ]
    found += [Case(name=f"hand-{seed}", make=partial(by_hand, seed)) for seed in range(500, 504)]
    found += [Case(name=f"rays-{seed}", make=partial(rays, seed)) for seed in range(500, 503)]
    found += [Case(name=f"flat-{seed}", make=partial(random_flat, seed)) for seed in range(500, 503)]
    found += [Case(name="long-504", make=partial(random_simulation, 504, stations=40))]
    found += [
        Case(name=f"{method}-505", make=partial(random_simulation, 505), options=("--method", method))
        for method in ("mdp-fuzzy", "rcd", "hough", "salient-ekf", "iepf-kalman", "grid-bayes")
    ]
    real = [REAL / "arena-b", REAL / "rooms" / "few00"]
    return found + [Case(name=each.name, folder=each) for each in real if each.is_dir()]


def main() -> int:
    """Map everything with both versions of the code and compare."""
    arguments = parse()
    commit = git("rev-parse", "--short", arguments.baseline)
    shutil.rmtree(KEPT / "now", ignore_errors=True)
    with baseline_code(commit) as before:
        versions = ((before, KEPT / commit), (ROOT, KEPT / "now"))
        return (compare_scores if arguments.statistical else compare_maps)(versions, arguments)


def parse() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="Show that a change of the code makes no map worse.")
    parser.add_argument("baseline", help="commit to compare with")
    parser.add_argument("--only", default="", help="only the maps or kinds of recordings whose name contains this")
    parser.add_argument("--workers", type=int, default=os.cpu_count())
    parser.add_argument("--statistical", action="store_true", help="compare scores instead of bits")
    parser.add_argument("--hold-out", action="store_true", help="with --statistical: other recordings")
    parser.add_argument("--share", type=float, default=1.0, help="with --statistical: share of the recordings")
    return parser.parse_args()


def compare_maps(versions: Sequence[tuple[Path, Path]], arguments: argparse.Namespace) -> int:
    """Compare the maps of two versions to the last bit; return 1 if there is a difference."""
    chosen = [each for each in cases() if arguments.only in each.name]
    with ThreadPoolExecutor(arguments.workers) as workers:
        jobs = [(case, code, maps) for case in chosen for code, maps in versions]
        # The first map compiles the code; two at once would both do it.
        for job in jobs[:2]:
            map_case(*job)
        list(tracked(workers.map(lambda job: map_case(*job), jobs[2:]), total=len(jobs) - 2, task="mapping"))
    before, now = (maps for _, maps in versions)
    differences = {case.name: compare(before / case.name, now / case.name) for case in chosen}
    for name, difference in differences.items():
        print(f"{name:<18}{difference or 'equal'}")
    equal = sum(not difference for difference in differences.values())
    print(f"{equal} of {len(chosen)} maps are equal to the bit with those of {before.name}.")
    return int(equal < len(chosen))


def compare_scores(versions: Sequence[tuple[Path, Path]], arguments: argparse.Namespace) -> int:
    """Compare the scores of two versions kind by kind; return 1 if one became worse."""
    worse = []
    for name, population in POPULATIONS.items():
        if arguments.only not in name:
            continue
        seeds = population.seeds(hold_out=arguments.hold_out)[: math.ceil(arguments.share * population.size)]
        folder = KEPT / "populations" / f"{name}-{seeds.start}-{len(seeds)}"
        with ProcessPoolExecutor(arguments.workers) as workers:
            made = workers.map(partial(write_population_recording, folder, name), seeds)
            list(tracked(made, total=len(seeds), task=f"simulating {name}"))
        scores = [map_population(folder, *version, population, arguments.workers) for version in versions]
        title = f"{len(seeds)} {name}"
        table, found = compare_two(title, *scores)
        show(table)
        worse += [f"{title}, {each}" for each in found]
    print("\n".join(["Worse:", *worse]) if worse else "Nothing is worse beyond its tolerance.")
    return int(bool(worse))


def write_population_recording(folder: Path, name: str, seed: int) -> None:
    """Write a recording with its truth, unless it is there already."""
    place = folder / f"{seed:04d}"
    if not (place / "truth.json").exists():
        recording = POPULATIONS[name].make(seed)
        write_recording(place, recording)
        write_truth(place / "truth.json", recording.truth)


def map_population(folder: Path, code: Path, kept: Path, population: Population, workers: int) -> Scores:
    """Map all recordings of a folder by a version of the code, unless that was done before, and evaluate the maps."""
    maps = kept / folder.name
    measured = maps / "seconds.txt"
    if not measured.exists():
        maps.mkdir(parents=True, exist_ok=True)
        settings = maps / "settings.toml"
        settings.write_text(f'[method]\nposes = "{population.poses}"\n', encoding="utf-8")
        environment = os.environ | {"PYTHONPATH": str(code / "src")}
        first = min(folder.iterdir())
        # Compiling is no part of the time: the first map does that.
        for command in (
            ["map", str(first), "--out", str(maps / "first")],
            ["batch", str(folder), "--out", str(maps), "--jobs", str(workers)],
        ):
            begun = os.times()
            program = [sys.executable, "-m", "echoplan", *command, "--config", str(settings)]
            subprocess.run(program, env=environment, cwd=code, stdout=subprocess.DEVNULL, check=True)
        ended = os.times()
        seconds = ended.children_user + ended.children_system - begun.children_user - begun.children_system
        measured.write_text(f"{seconds:.2f}\n", encoding="utf-8")
    places = sorted(each.parent for each in folder.glob("*/truth.json"))
    return Scores(
        evaluations=[evaluate(read_map(maps / "maps" / each.name), read_truth(each)) for each in places],
        seconds=float(measured.read_text(encoding="utf-8")),
    )


def git(*arguments: str) -> str:
    """Run git in this repository and return what it prints."""
    run = subprocess.run(["git", *arguments], cwd=ROOT, check=True, capture_output=True, text=True)  # noqa: S607
    return run.stdout.strip()


@contextmanager
def baseline_code(commit: str) -> Iterator[Path]:
    """Check out a commit beside the kept maps, and remove it afterwards."""
    folder = KEPT / f"code-{commit}"
    if not folder.exists():
        git("worktree", "add", "--quiet", "--detach", str(folder), commit)
    try:
        yield folder
    finally:
        git("worktree", "remove", "--force", str(folder))


def map_case(case: Case, code: Path, maps: Path) -> None:
    """Map one recording by the command line of a version of the code, unless the map is there already."""
    out = maps / case.name
    if (out / "map.json").exists():
        return
    source = case.folder or write_case(case)
    command = [sys.executable, "-m", "echoplan", "map", str(source), "--out", str(out), *case.options]
    environment = os.environ | {"PYTHONPATH": str(code / "src")}
    run = subprocess.run(command, env=environment, cwd=code, capture_output=True, text=True, check=False)
    if run.returncode:
        raise SystemExit(f"{case.name} with {code}: {run.stderr.strip()}")


def write_case(case: Case) -> Path:
    """Write a simulated recording, unless it is there already."""
    folder = KEPT / "recordings" / case.name
    if not (folder / "rig.toml").exists():
        assert case.make is not None
        write_recording(folder, case.make())
    return folder


def compare(before: Path, after: Path) -> str:
    """Return the first difference between two results, empty if there is none."""
    old, new = (json.loads((folder / "map.json").read_text(encoding="utf-8")) for folder in (before, after))
    difference = first_difference(old, new, "map.json")
    for name in ("trajectory.tum", "grid.pgm"):
        files = [folder / name for folder in (before, after)]
        if not difference and len({each.exists() and each.read_bytes() for each in files}) > 1:
            difference = f"{name} differs"
    return difference


def first_difference(old: Any, new: Any, place: str) -> str:
    """Compare two JSON values, the keys of the old one renamed."""
    if isinstance(old, dict) and isinstance(new, dict):
        old = {RENAMED.get(key, key): value for key, value in old.items()}
        keys = [key for key in (old | new) if key not in IGNORED]
        pairs = [(old.get(key), new.get(key), f"{place}.{key}") for key in keys]
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        pairs = [(*both, f"{place}[{index}]") for index, both in enumerate(zip(old, new, strict=True))]
    else:
        return "" if old == new else f"{place}: {str(old)[:60]} became {str(new)[:60]}"
    return next(filter(None, (first_difference(*pair) for pair in pairs)), "")


if __name__ == "__main__":
    sys.exit(main())
