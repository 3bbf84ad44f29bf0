"""Apply small faults to the estimator one by one and run its unit tests: python tests/mutants.py [NAME ...].

Each mutant changes one line in a copy of the tree.  A mutant is caught if one of the named tests fails.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
JOINT = Path("src/echoplan/joint")
TESTS = Path("tests/unit/joint")


@dataclass(frozen=True, slots=True, kw_only=True)
class Mutant:
    """One fault: what it changes, and which tests should fail."""

    file: str
    old: str
    new: str
    tests: tuple[str, ...]


MUTANTS = {
    "marginalised vector has the wrong sign": Mutant(
        file="optimisation/factors.py",
        old="vector=self.vector[columns] - cross @ carried",
        new="vector=self.vector[columns] + cross @ carried",
        tests=("optimisation/test_factors.py",),
    ),
    "Cauchy kernel instead of Geman-McClure": Mutant(
        file="optimisation/optimiser.py",
        old="residuals**2 / (scale**2 * variances)) ** 2",
        new="residuals**2 / (scale**2 * variances))",
        tests=("optimisation/test_robust_kernel.py",),
    ),
    "poses cost 0.5 log n instead of 1.5 log n": Mutant(
        file="pose_correction/consistency.py",
        old="cost += 1.5 *",
        new="cost += 0.5 *",
        tests=("pose_correction/test_consistency.py",),
    ),
    "walls are drawn although half of the pings passed": Mutant(
        file="marginalisation.py",
        old="2 * history.passed >= history.pings",
        new="1 * history.passed >= history.pings",
        tests=("test_marginalisation.py",),
    ),
    "the thermometer is ignored": Mutant(
        file="estimate.py",
        old="is_scale_known = drifting or not math.isnan(self.recorded.temperature)",
        new="is_scale_known = drifting",
        tests=("test_mapper.py",),
    ),
    "noise is not part of the cache key": Mutant(
        file="likelihood_cache.py",
        old="inputs = (measurements, model, noise)",
        new="inputs = (measurements, model, 0.0)",
        tests=("test_likelihood_cache.py",),
    ),
    "the effective sample size is never estimated": Mutant(
        file="pose_correction/annealing.py",
        old="    estimate = replace(estimate, effective_sample_ratio=estimate.estimate_effective_sample_ratio())\n",
        new="",
        tests=("pose_correction/test_annealing.py",),
    ),
    "two stations suffice": Mutant(
        file="search/acceptance.py",
        old="hypothesis.supporting(self.settings.min_second_station_llr) > 2",
        new="hypothesis.supporting(self.settings.min_second_station_llr) > 1",
        tests=("search/test_search.py",),
    ),
    "the scan matcher searches 1.0 sigma instead of 1.3": Mutant(
        file="pose_correction/pose_tracking.py",
        old="known, guess, 1.3 * sigmas",
        new="known, guess, 1.0 * sigmas",
        tests=("pose_correction/test_registration_order.py", "pose_correction/test_pose_tracking.py"),
    ),
    "the initial search is never repeated": Mutant(
        file="estimate.py",
        old="for _ in range(_MAX_REPEATS):\n            scale",
        new="for _ in range(1):\n            scale",
        tests=("test_estimate.py",),
    ),
    "the last optimisation of `explain` is left out": Mutant(
        file="estimate.py",
        old="return now.optimise(now.noise).rescore(now.noise)\n\n    def alternate",
        new="return now.rescore(now.noise)\n\n    def alternate",
        tests=("test_estimate.py",),
    ),
    "a station never misses a landmark": Mutant(
        file="pose_correction/relocalisation.py",
        old="each.llr_by_station[station] < _MISSED",
        new="each.llr_by_station[station] < -1e9",
        tests=("pose_correction/test_relocalisation.py",),
    ),
    "heading factors are never added": Mutant(
        file="pose_correction/annealing.py",
        old="    estimate = replace(estimate, has_heading_factors=True)\n    if priors",
        new="    if priors",
        tests=("pose_correction/test_annealing.py",),
    ),
}


def main() -> int:
    """Print for each mutant whether the tests catch it; return 1 if one survives."""
    parser = argparse.ArgumentParser(description="Mutation tests of the estimator.")
    parser.add_argument("names", nargs="*", help="parts of the names of mutants; all by default")
    names = parser.parse_args().names
    chosen = {name: each for name, each in MUTANTS.items() if not names or any(part in name for part in names)}
    survivors = 0
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "tree"
        ignored = shutil.ignore_patterns(".git", ".venv", "out", ".mypy_cache", ".ruff_cache")
        shutil.copytree(ROOT, copy, ignore=ignored)
        for name, mutant in chosen.items():
            verdict = verdict_on(mutant, copy)
            survivors += verdict != "caught"
            print(f"{verdict:<10}{name}", flush=True)  # noqa: T201 - a script prints
    return int(survivors > 0)


def verdict_on(mutant: Mutant, tree: Path) -> str:
    """Apply a mutant in a tree, run its tests, and undo it."""
    file = tree / JOINT / mutant.file
    text = file.read_text(encoding="utf-8")
    if text.count(mutant.old) != 1:
        return "not found"
    file.write_text(text.replace(mutant.old, mutant.new), encoding="utf-8")
    tests = [str(TESTS / each) for each in mutant.tests]
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:randomly", *tests]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(tree / "src"), str(tree / "benchmarks")])}
    run = subprocess.run(command, cwd=tree, env=environment, capture_output=True, check=False)
    file.write_text(text, encoding="utf-8")
    return {0: "survived", 1: "caught"}.get(run.returncode, "error")


if __name__ == "__main__":
    sys.exit(main())
