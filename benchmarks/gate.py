"""Show that a refactoring changes no map: python benchmarks/gate.py BASELINE [--only NAME].

BASELINE is a commit, for example ``main`` or ``HEAD~3``.  Simulates 30 recordings of every kind (rooms, drives, places
measured by hand, heads with faulty servos, ray cones, flats with doors, classical methods; real recordings where they
are present), maps each with the code of the baseline and with the code of this working tree, by the command line, and
compares the maps to the last bit.  Renamed keys (``RENAMED``) do not count, neither do the settings of the run nor the
wording of the verdict.  Prints the first difference of each map, and exits with status 1 if there is one.

The maps of a baseline are kept in ``out/gate/``, so that a second run maps each recording only once.
"""

import argparse
import json
import math
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from echoplan.cli.terminal import tracked
from echoplan.io import write_recording
from echoplan.model import Rig, Source, Sweep
from echoplan.simulation import Simulation
from library.flats import random_flat
from library.heads import measured_by_hand, simulate_head
from library.ray_cones import cast, with_cones
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
class Recording:
    """Sweeps with the rig that made them: what ``write_recording`` writes."""

    name: str
    rig: Rig
    sweeps: tuple[Sweep, ...]

    def __len__(self) -> int:
        """Count the sweeps."""
        return len(self.sweeps)

    def __iter__(self) -> Iterator[Sweep]:
        """Yield the sweeps."""
        return iter(self.sweeps)


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


def by_hand(seed: int) -> Source:
    """Measure places with tape and eye, with a head whose servo is off."""
    _, simulation = simulate_head(seed, gain=0.1, offset=10.0)
    return Recording(name=simulation.name, rig=simulation.rig, sweeps=tuple(measured_by_hand(list(simulation), seed)))


def rays(seed: int) -> Source:
    """Cast fans of rays instead of sound."""
    simulation: Simulation = random_simulation(seed)
    rig = with_cones(simulation.rig, math.radians(15.0))
    sweeps = cast(tuple(simulation), simulation.world, rig, rays=31, noise=0.002, rng=np.random.default_rng(seed))
    return Recording(name=simulation.name, rig=rig, sweeps=tuple(sweeps))


def main() -> int:
    """Map everything with both versions of the code and compare."""
    parser = argparse.ArgumentParser(description="Show that a refactoring changes no map.")
    parser.add_argument("baseline", help="commit to compare with")
    parser.add_argument("--only", default="", help="only the maps whose name contains this")
    parser.add_argument("--workers", type=int, default=os.cpu_count())
    arguments = parser.parse_args()
    commit = git("rev-parse", "--short", arguments.baseline)
    chosen = [each for each in cases() if arguments.only in each.name]
    now = KEPT / "now"
    shutil.rmtree(now, ignore_errors=True)
    with baseline_code(commit) as before, ThreadPoolExecutor(arguments.workers) as workers:
        jobs = [(case, code, maps) for case in chosen for code, maps in ((before, KEPT / commit), (ROOT, now))]
        # The first map compiles the code; two at once would both do it.
        for job in jobs[:2]:
            map_case(*job)
        list(tracked(workers.map(lambda job: map_case(*job), jobs[2:]), total=len(jobs) - 2, task="mapping"))
    differences = {case.name: compare(KEPT / commit / case.name, now / case.name) for case in chosen}
    for name, difference in differences.items():
        print(f"{name:<18}{difference or 'equal'}")
    equal = sum(not difference for difference in differences.values())
    print(f"{equal} of {len(chosen)} maps are equal to the bit with those of {commit}.")
    return int(equal < len(chosen))


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
