"""Several recordings of one place: python benchmarks/several_recordings.py [FLATS] [--first SEED] [--only PART].

1. Cuts a drive through a random flat in two, whose frames are 0.3 m and 20 degrees apart and which share four stations,
   maps both together, and compares the walls with the map of the whole drive and with the truth.
2. Maps a flat on three days, each time on another route, of which the third finds a cupboard moved, and lists what is
   reported as gone and as new.  At least three stations can detect a face of the cupboard at each place.  A day counts
   as exact if nothing else than the cupboard is reported, at its former place as gone and at its present place as new;
   parts of it that the robot did not look at again may be missing.
3. Adds recordings that begin elsewhere than the first one: the second half of a drive backwards, and the second half of
   the drive through the next flat.  They should be refused, or, in the same flat, have the right poses.

PART is halves, days or elsewhere.  Prints all, and the seeds in which something went wrong.  Seeds 0 to 9, 1000 to
1005, 3000 to 3213, 3217, 3225, 3234, 3300, 3408, 3412 and 3437 were used for development.  3429, 3432 and 3446 were
looked at, but nothing was changed for them.
"""

import argparse
import os
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from shapely import LineString, Point, Polygon

from echoplan.arrays import FloatArray
from echoplan.cli.terminal import show, tracked
from echoplan.errors import InputError
from echoplan.evaluation import Evaluation, evaluate
from echoplan.mapping.recordings import Recordings, map_recordings
from echoplan.methods import find_method
from echoplan.model import Changes, FeatureMap, Recording, Rig, Sweep, Table, Truth
from library.days import flat_on_days, in_frame_of_odometry
from library.flats import random_flat

FLATS, FIRST = 20, 3400
# Stations that both halves of a drive have.
SHARED = 4
# Distance from the cupboard within which a change is of the cupboard [m].
AT_CUPBOARD = 0.1
# Median error of poses from which a recording counts as joined in the wrong place [m].
WRONG = 0.2


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Halves:
    """A drive in one recording and in two; ``refused`` says why two could not be mapped."""

    seed: int
    whole: Evaluation
    both: Evaluation | None = None
    between: Evaluation | None = None
    refused: str = ""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Days:
    """What was reported on the second and on the third day."""

    seed: int
    cupboard: tuple[FloatArray, FloatArray]
    changes: tuple[Changes, ...] = ()
    refused: str = ""

    @property
    def is_quiet(self) -> bool:
        """Whether nothing was reported on the second day."""
        return bool(self.changes) and not self.changes[0]

    @property
    def strays(self) -> int:
        """Number of things that were reported on the third day and are not of the cupboard."""
        third, places = self.changes[1], [Polygon(each) for each in self.cupboard]
        walls = zip((third.gone_walls, third.new_walls), places, strict=True)
        cylinders = zip((third.gone_cylinders, third.new_cylinders), places, strict=True)
        away = [place.distance(LineString(ends).centroid) for changed, place in walls for ends in changed]
        away += [place.distance(Point(each.center_xy)) for changed, place in cylinders for each in changed]
        return sum(each > AT_CUPBOARD for each in away)

    @property
    def is_exact(self) -> bool:
        """Whether the third day reports the cupboard as gone and as new, and nothing else."""
        return len(self.changes) > 1 and all(self._walls) and not self.strays

    @property
    def _walls(self) -> tuple[tuple[FloatArray, ...], tuple[FloatArray, ...]]:
        return self.changes[1].gone_walls, self.changes[1].new_walls


class Outcome(StrEnum):
    """What became of a recording."""

    REFUSED = "refused"
    CORRECT = "joined correctly"
    WRONG = "joined wrongly"


@dataclass(frozen=True, slots=True, kw_only=True)
class Elsewhere:
    """What became of recordings that begin elsewhere than the first one."""

    seed: int
    backwards: Outcome
    next_flat: Outcome


def main() -> None:
    """Map everything and print the tables."""
    parser = argparse.ArgumentParser(description="Several recordings of one place.")
    parser.add_argument("flats", nargs="?", type=int, default=FLATS, metavar="FLATS")
    parser.add_argument("--first", type=int, default=FIRST, help="seed of the first flat")
    parser.add_argument("--only", choices=("halves", "days", "elsewhere"), help="do one part")
    parser.add_argument("--workers", type=int, default=os.cpu_count())
    arguments = parser.parse_args()
    seeds = range(arguments.first, arguments.first + arguments.flats)
    halves, days, others = list[Halves](), list[Days](), list[Elsewhere]()
    parts = (arguments.only,) if arguments.only else ("halves", "days", "elsewhere")
    with ProcessPoolExecutor(arguments.workers) as pool:
        if "halves" in parts:
            halves += tracked(pool.map(in_halves, seeds), total=len(seeds), task="drives in two recordings")
            show(halves_table(halves))
        if "days" in parts:
            days += tracked(pool.map(on_days, seeds), total=len(seeds), task="three days")
            show(days_table(days))
        if "elsewhere" in parts:
            others += tracked(pool.map(elsewhere, seeds), total=len(seeds), task="recordings that begin elsewhere")
            show(elsewhere_table(others))
    show(failures(halves, days, others))


def in_halves(seed: int) -> Halves:
    """Map a drive as a whole, and in two recordings."""
    simulation = random_flat(seed)
    sweeps, truth = tuple(simulation), replace(simulation.truth, poses=np.zeros((0, 3)), given=np.zeros((0, 3)))
    half = len(sweeps) // 2
    second = in_frame_of_odometry(sweeps[half - SHARED :], day=1)
    whole = mapped([sweeps], simulation.rig)
    evaluated = evaluate(whole, truth)
    try:
        both = mapped([sweeps[:half], second], simulation.rig)
    except InputError as error:
        return Halves(seed=seed, whole=evaluated, refused=str(error))
    return Halves(seed=seed, whole=evaluated, both=evaluate(both, truth), between=evaluate(both, as_truth(whole)))


def on_days(seed: int) -> Days:
    """Map a flat on three days."""
    simulations, cupboard = flat_on_days(seed)
    days = [in_frame_of_odometry(tuple(each), day=day) for day, each in enumerate(simulations)]
    try:
        found = mapped(days, simulations[0].rig)
    except InputError as error:
        return Days(seed=seed, cupboard=cupboard, refused=str(error))
    return Days(seed=seed, cupboard=cupboard, changes=found.changes)


def elsewhere(seed: int) -> Elsewhere:
    """Add recordings that begin elsewhere to the first half of a drive."""
    simulation, other = random_flat(seed), tuple(random_flat(seed + 1))
    sweeps, rig = tuple(simulation), simulation.rig
    half = len(sweeps) // 2
    return Elsewhere(
        seed=seed,
        backwards=outcome(
            [sweeps[:half], backwards(sweeps[half - SHARED :])],
            rig,
            true=simulation.truth.poses[half - SHARED :][::-1],
        ),
        next_flat=outcome([sweeps[:half], other[len(other) // 2 :]], rig),
    )


def backwards(sweeps: Sequence[Sweep]) -> tuple[Sweep, ...]:
    """Return sweeps in the opposite order, at the times of the original order."""
    return tuple(
        replace(sweep, index=at.index, stamps_ns=sweep.stamps_ns - sweep.stamps_ns[0] + at.stamps_ns[0])
        for sweep, at in zip(reversed(sweeps), sweeps, strict=True)
    )


def outcome(recordings: Sequence[Sequence[Sweep]], rig: Rig, true: FloatArray | None = None) -> Outcome:
    """Map two recordings, and say whether the second one was refused or joined; ``true`` are its poses in the map."""
    first, second = recordings
    try:
        found = mapped([first, in_frame_of_odometry(tuple(second), day=1)], rig)
    except InputError:
        return Outcome.REFUSED
    if true is None:
        return Outcome.WRONG
    off = np.hypot(*(found.poses[-len(true) :] - true)[:, :2].T)
    return Outcome.CORRECT if np.median(off) < WRONG else Outcome.WRONG


def mapped(recordings: Sequence[Sequence[Sweep]], rig: Rig) -> FeatureMap:
    """Map recordings together, as ``echoplan map`` does."""
    sources = tuple(
        Recording(name=f"recording {number}", rig=rig, sweeps=tuple(sweeps)) for number, sweeps in enumerate(recordings)
    )
    read = Recordings(
        names=tuple(each.name for each in sources), sources=sources, sweeps=tuple(tuple(each) for each in sources)
    )
    found, _ = map_recordings(find_method("joint").build(rig), read)
    return found


def as_truth(feature_map: FeatureMap) -> Truth:
    """Take the walls of a map for the truth."""
    walls_xy = np.array([wall.endpoints_xy for wall in feature_map.walls]).reshape(-1, 2, 2)
    return Truth(walls_xy=walls_xy, walls_detected_by=np.full(len(walls_xy), 99))


def distances(evaluations: Sequence[Evaluation]) -> FloatArray:
    """Return the distances of all walls that were found right [m]."""
    return np.array([each.distance for evaluation in evaluations for each in evaluation.matches.walls.right])


def halves_table(halves: Sequence[Halves]) -> Table:
    """Compare drives in two recordings with the same drives in one."""
    done = [each for each in halves if each.both and each.between]
    groups = {
        "one recording, truth": [each.whole for each in done],
        "two recordings, truth": [each.both for each in done if each.both],
        "two recordings, one recording": [each.between for each in done if each.between],
    }
    rows = [row(name, evaluations) for name, evaluations in groups.items()]
    return Table(
        title=f"{len(done)} of {len(halves)} drives in two recordings whose frames are 0.3 m and 20° apart",
        columns=(
            "maps compared",
            "walls found (%)",
            "walls right (%)",
            "mean (mm)",
            "95th percentile (mm)",
            "greatest (mm)",
        ),
        rows=tuple(rows),
    )


def row(name: str, evaluations: Sequence[Evaluation]) -> tuple[str, ...]:
    """Return recall, precision and errors of walls."""
    tallies = [each.matches.walls.tally for each in evaluations]
    found, wanted = (sum(getattr(each, key) for each in tallies) for key in ("found", "wanted"))
    right, estimates = (sum(getattr(each, key) for each in tallies) for key in ("right", "estimates"))
    off = 1000.0 * distances(evaluations) if evaluations else np.array([np.nan])
    shares = (f"{100.0 * part / max(whole, 1):.1f}" for part, whole in ((found, wanted), (right, estimates)))
    return name, *shares, f"{off.mean():.2f}", f"{np.quantile(off, 0.95):.2f}", f"{off.max():.1f}"


def days_table(days: Sequence[Days]) -> Table:
    """Count what was reported."""
    done = [each for each in days if not each.refused]
    counts = {
        "second day: nothing reported": sum(each.is_quiet for each in done),
        "third day: the cupboard as gone and as new, nothing else": sum(each.is_exact for each in done),
        "third day: something else than the cupboard": sum(each.strays > 0 for each in done),
        "third day: the cupboard not as gone": sum(not each.changes[1].gone_walls for each in done),
        "third day: the cupboard not as new": sum(not each.changes[1].new_walls for each in done),
        "a day refused": len(days) - len(done),
    }
    return Table(
        title=f"A flat on three days, {len(days)} flats",
        columns=("report", "flats"),
        rows=tuple((name, str(count)) for name, count in counts.items()),
    )


def elsewhere_table(others: Sequence[Elsewhere]) -> Table:
    """Count what became of recordings that begin elsewhere than the first one."""
    outcomes = {
        "the second half backwards": [each.backwards for each in others],
        "the second half of another drive": [each.next_flat for each in others],
    }
    return Table(
        title=f"Recordings that begin elsewhere, {len(others)} flats",
        columns=("recording", *Outcome),
        rows=tuple((what, *(str(found.count(each)) for each in Outcome)) for what, found in outcomes.items()),
    )


def failures(halves: Sequence[Halves], days: Sequence[Days], others: Sequence[Elsewhere]) -> Table:
    """List the seeds in which something went wrong, and why."""
    refused = [(f"two recordings, {each.seed}", each.refused) for each in halves if each.refused]
    refused += [(f"three days, {each.seed}", each.refused) for each in days if each.refused]
    mapped_days = [each for each in days if not each.refused]
    loud = [(f"second day, {each.seed}", "something reported") for each in mapped_days if not each.is_quiet]
    inexact = [(f"third day, {each.seed}", "not exact") for each in mapped_days if not each.is_exact]
    wrong = [
        (f"{what}, {each.seed}", Outcome.WRONG)
        for each in others
        for what, found in (("backwards", each.backwards), ("of the next flat", each.next_flat))
        if found is Outcome.WRONG
    ]
    return Table(title="What went wrong", columns=("where", "what"), rows=(*refused, *loud, *inexact, *wrong))


if __name__ == "__main__":
    main()
