"""Verdicts on maps: python benchmarks/verdicts.py [RECORDINGS] [--first SEED].

Simulates recordings (300 by default) of random rooms and arenas, by sensors on servos and by rings, from marks, exact
stations and drives, half of them with one mistake in their format; maps each by joint and assesses the map.  Prints how
many correct and faulty recordings are called good, doubtful or failed, the faulty ones by their mistake, how often the
proposed remedy is right, and the CPU time of the assessment beside that of the mapping.
"""

import argparse
import time
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass

from echoplan.cli.terminal import show, tracked
from echoplan.diagnosis import assess
from echoplan.joint.mapper import JointMapper
from echoplan.methods import map_sweeps
from echoplan.model import Quality, Table, Verdict
from library.faulty import Faulty, draw, remedy_for

RECORDINGS, FIRST = 300, 7000


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """One recording and the assessment of its map."""

    seed: int
    name: str
    fault: str
    quality: Quality
    is_named: bool
    mapping: float
    assessing: float


def main() -> None:
    """Map and assess all, and print tables."""
    parser = argparse.ArgumentParser(description="Verdicts on maps.")
    parser.add_argument("recordings", type=int, nargs="?", default=RECORDINGS)
    parser.add_argument("--first", type=int, default=FIRST)
    parser.add_argument("--workers", type=int)
    arguments = parser.parse_args()
    seeds = range(arguments.first, arguments.first + arguments.recordings)
    with ProcessPoolExecutor(arguments.workers) as workers:
        outcomes = []
        for outcome in tracked(workers.map(run, seeds), total=len(seeds), task="mapping"):
            outcomes.append(outcome)
            report_error(outcome)
    show(table("Recordings by what made them", outcomes, lambda each: f"{each.name}{', faulty' * bool(each.fault)}"))
    show(table("Recordings by their mistake", outcomes, lambda each: each.fault or "none"))
    mapping, assessing = (sum(getattr(each, name) for each in outcomes) for name in ("mapping", "assessing"))
    print(f"{mapping / len(outcomes):.1f} s of mapping and {assessing / len(outcomes):.1f} s of assessing a recording")


def report_error(outcome: Outcome) -> None:
    """Print at once which faulty recording is called good, and which correct one failed."""
    verdict = outcome.quality.verdict
    if verdict is (Verdict.GOOD if outcome.fault else Verdict.FAILED):
        name = f"seed {outcome.seed}, {outcome.name}, {outcome.fault or 'correct'}"
        print(f"{name}: {verdict}", *outcome.quality.reasons, flush=True)


def run(seed: int) -> Outcome:
    """Map one recording and assess the map."""
    faulty: Faulty = draw(seed)
    begun = time.process_time()
    found = map_sweeps(JointMapper(faulty.rig), faulty.sweeps)
    mapped = time.process_time()
    quality = assess(found, faulty.rig, faulty.sweeps)
    return Outcome(
        seed=seed,
        name=faulty.name,
        fault=faulty.fault,
        quality=quality,
        is_named=bool(faulty.fault) and remedy_for(faulty) in quality.next_step,
        mapping=mapped - begun,
        assessing=time.process_time() - mapped,
    )


def table(title: str, outcomes: list[Outcome], group: Callable[[Outcome], str]) -> Table:
    """Count verdicts by group."""
    groups = sorted({group(each) for each in outcomes})
    rows = [row(name, [each for each in outcomes if group(each) == name]) for name in groups]
    return Table(title=title, columns=("recordings", "number", *Verdict, "right remedy"), rows=tuple(rows))


def row(name: str, outcomes: Iterable[Outcome]) -> tuple[str, ...]:
    """Count verdicts."""
    members = list(outcomes)
    verdicts = [sum(each.quality.verdict is verdict for each in members) for verdict in Verdict]
    named = str(sum(each.is_named for each in members)) if any(each.fault for each in members) else "-"
    return (name, str(len(members)), *map(str, verdicts), named)


if __name__ == "__main__":
    main()
