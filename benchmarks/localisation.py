"""Localisation in a known map: python benchmarks/localisation.py [ROOMS] [--first SEED] [--workers N].

Maps random rooms (100 by default, each from 14 stations with exact poses), and localises a drive of 22 stations through
the same room, by odometry with drift, in that map.  Prints

- the errors of poses from a known start, which is off by 10 cm along both axes and 10 degrees (standard deviations),
  whether their covariances are right, and the share of echoes explained;
- whether the pose is found from an unknown start after five stations, and whether it is called ambiguous;
- whether an empty rectangle, which looks the same after half a turn, is called ambiguous, with the true start among
  those that are listed;
- whether it is noticed, and where, that the robot was carried elsewhere in the middle of the drive;
- how well the echoes agree with the map of another room, beside the right map: the share of them that it explains, and
  their Jaccard index;
- the rooms in which something went wrong.

``--unknown-start`` prints only what concerns unknown starts.

Seeds 1000 to 1041 were used for development.
"""

import argparse
import math
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from itertools import islice
from typing import TypeVar

import numpy as np

from echoplan.arrays import BoolArray, FloatArray
from echoplan.cli.terminal import show, tracked
from echoplan.errors import InvalidValueError
from echoplan.evaluation.consistency import nees
from echoplan.geometry import compose, invert, wrap
from echoplan.joint.localisation import localise
from echoplan.joint.mapper import JointMapper
from echoplan.methods import map_sweeps
from echoplan.model import FeatureMap, Localisation, Polyline, Rig, Route, Sweep, Table, World
from echoplan.simulation import Simulation
from library.rooms import Floor, random_drive, random_simulation

ROOMS, FIRST = 100, 2000
# Number of stations after which the pose is asked for from an unknown start.
STATIONS = 5
# Sides of an empty rectangle, the least difference between them, and distance of stations from walls [m].
SIDES, DIFFERENCE, CLEARANCE = (3.0, 5.0), 0.3, 0.6
# Number of stations from which an empty rectangle is mapped.
MAPPED = 12
# Standard deviations of known starts [m, m, rad].
START_SIGMAS = (0.1, 0.1, math.radians(10.0))
# Station from which the robot is carried before it pings there, and station at which it is put down.
TAKEN, PUT_DOWN = 8, 14
# The map of this many seeds later is a wrong one.
ANOTHER = 500
# A pose is right if it is nearer to the true one than this [m, rad].
POSITION, HEADING = 0.1, math.radians(3.0)
# NEES within which 95 % of errors in three dimensions lie (chi-square).
INSIDE = 7.815


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Case:
    """A localised recording.

    Parameters
    ----------
    found : Localisation, optional
        None if the recording fits the map nowhere.
    truth : ndarray, shape (s, 3)
        True poses of all sweeps [m, m, rad].
    """

    found: Localisation | None
    truth: FloatArray

    @property
    def errors(self) -> FloatArray:
        """Errors of the poses, shape (k, 3) [m, m, rad]; none if there are no poses."""
        return pose_errors(self.found.poses, self.truth[self.found.sweeps]) if self.found else np.zeros((0, 3))

    @property
    def squares(self) -> FloatArray:
        """NEES of each pose."""
        covariances = self.found.covariances if self.found else ()
        return np.array([nees(*each) for each in zip(self.errors, covariances, strict=True)], dtype=np.float64)

    @property
    def mean_square(self) -> float:
        """Mean NEES; nan if there are no poses."""
        return float(np.mean(self.squares)) if self.found else np.nan

    @property
    def is_right(self) -> bool:
        """Whether all poses are."""
        return self.found is not None and bool(are_right(self.errors).all())

    @property
    def is_ambiguous(self) -> bool:
        """Whether it is called ambiguous."""
        return self.found is not None and self.found.is_ambiguous

    @property
    def lists_true_start(self) -> bool:
        """Whether the true first pose is among those that are listed."""
        starts = self.found.segments[0].starts if self.found else ()
        return any(are_right(pose_errors(each.pose[None], self.truth[:1]))[0] for each in starts)

    @property
    def inlier_ratio(self) -> float:
        """Share of the echoes that the map explains; none if the recording fits nowhere."""
        return self.found.inlier_ratio if self.found else 0.0

    @property
    def jaccard_index(self) -> float:
        """Jaccard index of echoes and map; 0 if the recording fits nowhere."""
        return self.found.jaccard_index if self.found else 0.0


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class UnknownStart:
    """The cases of one seed with an unknown start."""

    seed: int
    unknown: Case
    rectangle: Case


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Outcome(UnknownStart):
    """All cases of one seed; without ``carried`` if the drive got stuck early."""

    known: Case
    carried: Case | None
    wrong: Case

    @property
    def is_carrying_found(self) -> bool:
        """Whether the robot counts as carried before the right sweep, and no other."""
        found = self.carried.found if self.carried else None
        return found is not None and found.kidnapped == (TAKEN,)


Start = TypeVar("Start", bound=UnknownStart)


def main() -> None:
    """Localise in all rooms and print tables."""
    parser = argparse.ArgumentParser(description="Localisation in a known map.")
    parser.add_argument("rooms", type=int, nargs="?", default=ROOMS)
    parser.add_argument("--first", type=int, default=FIRST, metavar="SEED", help="seed of the first room")
    parser.add_argument("--unknown-start", action="store_true", help="only from unknown starts, which is faster")
    parser.add_argument("--workers", type=int)
    arguments = parser.parse_args()
    seeds = range(arguments.first, arguments.first + arguments.rooms)
    with ProcessPoolExecutor(arguments.workers) as workers:
        if arguments.unknown_start:
            starts = list(tracked(workers.map(run_unknown, seeds), total=len(seeds), task="localising"))
            shown = [start_table(starts), fault_table(starts, START_FAULTS)]
        else:
            shown = tables(list(tracked(workers.map(run, seeds), total=len(seeds), task="localising")))
    for table in shown:
        show(table)


def run_unknown(seed: int) -> UnknownStart:
    """Map the rooms of one seed and localise in them from unknown starts."""
    drive = random_drive(seed)
    sweeps, feature_map = tuple(drive)[:STATIONS], mapped(random_simulation(seed))
    unknown = localised(sweeps, feature_map, truth=drive.truth.poses, rig=drive.rig)
    return UnknownStart(seed=seed, unknown=unknown, rectangle=in_rectangle(seed))


def run(seed: int) -> Outcome:
    """Map the rooms of one seed and localise in them."""
    drive = random_drive(seed)
    sweeps, truth, rig = tuple(drive), drive.truth.poses, drive.rig
    feature_map, another = (mapped(random_simulation(each)) for each in (seed, seed + ANOTHER))
    start, carried = truth[0] + np.random.default_rng([seed, 1]).normal(0.0, START_SIGMAS), None
    if len(sweeps) > PUT_DOWN:
        there = np.concatenate([truth[:TAKEN], truth[PUT_DOWN:]])
        carried = localised(carried_elsewhere(sweeps), feature_map, truth=there, rig=rig, start=start)
    return Outcome(
        seed=seed,
        known=localised(sweeps, feature_map, truth=truth, rig=rig, start=start),
        unknown=localised(sweeps[:STATIONS], feature_map, truth=truth, rig=rig),
        rectangle=in_rectangle(seed),
        carried=carried,
        wrong=localised(sweeps, another, truth=truth, rig=rig),
    )


def mapped(simulation: Simulation) -> FeatureMap:
    """Map a simulated recording."""
    return map_sweeps(JointMapper(simulation.rig), tuple(simulation))


def localised(
    sweeps: Sequence[Sweep], feature_map: FeatureMap, *, truth: FloatArray, rig: Rig, start: FloatArray | None = None
) -> Case:
    """Localise sweeps in a map, beside their true poses."""
    try:
        found = localise(sweeps, feature_map, rig=rig, start=start)
    except InvalidValueError:
        return Case(found=None, truth=truth)
    return Case(found=found, truth=truth)


def carried_elsewhere(sweeps: Sequence[Sweep]) -> list[Sweep]:
    """Return a drive without some stations, between which odometry counted nothing."""
    moved = compose(sweeps[TAKEN].station, invert(sweeps[PUT_DOWN].station))
    after = [replace(each, map_from_base=compose(moved, each.map_from_base)) for each in sweeps[PUT_DOWN:]]
    return [replace(each, index=index) for index, each in enumerate([*sweeps[:TAKEN], *after])]


def in_rectangle(seed: int) -> Case:
    """Map an empty rectangle, and localise in it from other stations and an unknown start."""
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(*SIDES, 2)
    while abs(x - y) < DIFFERENCE:
        x, y = rng.uniform(*SIDES, 2)
    outline_xy = np.array([[0.0, 0.0], [x, 0.0], [x, y], [0.0, y]])
    world = World(name=f"rectangle {seed}", polylines=(Polyline(points_xy=outline_xy, closed=True),))
    floor = Floor(outline_xy=outline_xy)
    places = np.array(list(islice(floor.places(rng, clearance=CLEARANCE, tries=1000), MAPPED + STATIONS)))
    poses = np.column_stack([places, rng.uniform(-np.pi, np.pi, len(places))])
    whole = replace(random_simulation(seed), world=world)
    feature_map = mapped(replace(whole, route=Route(map_from_base=poses[:MAPPED])))
    # Another seed: the noise must not be that of the map.
    again = replace(whole, route=Route(map_from_base=poses[MAPPED:]), seed=seed + ANOTHER)
    return localised(tuple(again), feature_map, truth=again.truth.poses, rig=again.rig)


def pose_errors(found: FloatArray, true: FloatArray) -> FloatArray:
    """Estimated less true poses, both of shape (n, 3) [m, m, rad]."""
    errors = found - true
    return np.column_stack([errors[:, :2], wrap(errors[:, 2])])


def are_right(errors: FloatArray) -> BoolArray:
    """Return for each pose whether its error is small; shape (n, 3) [m, m, rad]."""
    small: BoolArray = (np.hypot(errors[:, 0], errors[:, 1]) < POSITION) & (np.abs(errors[:, 2]) < HEADING)
    return small


def tables(outcomes: Sequence[Outcome]) -> list[Table]:
    """Lay out what was found from a known start, from an unknown one, and where the map is wrong."""
    return [
        error_table(outcomes),
        consistency_table(outcomes),
        start_table(outcomes),
        special_table(outcomes),
        agreement_table(outcomes, "Share of the echoes that the map explains", lambda each: each.inlier_ratio),
        agreement_table(outcomes, "Jaccard index of echoes and map", lambda each: each.jaccard_index),
        fault_table(outcomes, {**KNOWN_FAULTS, **START_FAULTS, **CARRIED_FAULTS}),
    ]


def error_table(outcomes: Sequence[Outcome]) -> Table:
    """Errors of position and heading from a known start."""
    errors = np.concatenate([each.known.errors for each in outcomes])
    measured = {
        "position (mm)": 1000.0 * np.hypot(errors[:, 0], errors[:, 1]),
        "heading (°)": np.degrees(np.abs(errors[:, 2])),
    }
    rows = [
        (name, *(f"{each:.2f}" for each in (np.mean(values), np.percentile(values, 95), np.max(values))))
        for name, values in measured.items()
        if len(values)
    ]
    title = f"Known start: errors of {len(errors)} poses in {len(outcomes)} rooms"
    return Table(title=title, columns=("error", "mean", "95th percentile", "greatest"), rows=tuple(rows))


def consistency_table(outcomes: Sequence[Outcome]) -> Table:
    """Lay out whether the covariances of poses from a known start are right, in rooms of either kind and in all."""
    groups = {
        "right-angled": [each for each in outcomes if each.seed % 2 == 0],
        "oblique": [each for each in outcomes if each.seed % 2 == 1],
        "all": outcomes,
    }
    rows = [(name, *consistency_row(members)) for name, members in groups.items() if members]
    columns = ("rooms", "fits nowhere", "poses", "inside 95 % (%)", "mean NEES (ideal 3)", "echoes explained (%)")
    return Table(title="Known start: are poses as certain as they say?", columns=columns, rows=tuple(rows))


def consistency_row(outcomes: Sequence[Outcome]) -> tuple[str, ...]:
    """Pool the poses of some rooms."""
    squares = np.concatenate([each.known.squares for each in outcomes])
    inside, mean = (np.mean(squares < INSIDE), np.mean(squares)) if len(squares) else (np.nan, np.nan)
    nowhere = sum(each.known.found is None for each in outcomes)
    explained = np.mean([each.known.inlier_ratio for each in outcomes])
    return f"{nowhere}", f"{len(squares)}", f"{100 * inside:.1f}", f"{mean:.2f}", f"{100 * explained:.1f}"


def start_table(outcomes: Sequence[UnknownStart]) -> Table:
    """Count what is found from an unknown start, in rooms and in empty rectangles."""
    kinds = {f"{STATIONS} stations of a drive": "unknown", f"{STATIONS} in an empty rectangle": "rectangle"}
    rows = []
    for name, kind in kinds.items():
        cases: list[Case] = [getattr(each, kind) for each in outcomes]
        unsure = [each for each in cases if each.is_ambiguous]
        sure = [each for each in cases if each.found and not each.is_ambiguous]
        counts = [sum(each.is_right is right for each in some) for some in (sure, unsure) for right in (True, False)]
        counts += [sum(each.found is None for each in cases), sum(each.lists_true_start for each in cases)]
        rows.append((name, *map(str, counts)))
    columns = (
        "recordings",
        "certain: right",
        "certain: wrong",
        "ambiguous: right",
        "ambiguous: wrong",
        "fits nowhere",
        "true start listed",
    )
    return Table(title=f"Unknown start: {len(outcomes)} of each", columns=columns, rows=tuple(rows))


def special_table(outcomes: Sequence[Outcome]) -> Table:
    """Count what is found of robots that were carried elsewhere."""
    members = [(each, each.carried) for each in outcomes if each.carried]
    found = [outcome for outcome, _ in members if outcome.is_carrying_found]
    unnoticed = [case for _, case in members if case.found and not case.found.kidnapped]
    nowhere = [case for _, case in members if case.found is None]
    counts = (len(found), len(unnoticed), len(nowhere), len(members) - len(found) - len(unnoticed) - len(nowhere))
    right = sum(case.is_right for _, case in members)
    columns = ("drives", "found where it was", "not noticed", "fits nowhere", "found elsewhere", "all poses right")
    rows = ((str(len(members)), *map(str, counts), str(right)),)
    return Table(title=f"Carried from station {TAKEN} to {PUT_DOWN}", columns=columns, rows=rows)


def agreement_table(outcomes: Sequence[Outcome], title: str, measure: Callable[[Case], float]) -> Table:
    """Lay out how well recordings agree with right and wrong maps."""
    cases = {
        "right, known start": [each.known for each in outcomes],
        f"right, unknown start, {STATIONS} stations": [each.unknown for each in outcomes],
        "of another room, unknown start": [each.wrong for each in outcomes],
    }
    rows = []
    for name, members in cases.items():
        values = np.quantile([measure(each) for each in members], (0.0, 0.05, 0.5, 0.95, 1.0))
        rows.append((name, *(f"{each:.2f}" for each in values), str(sum(each.found is None for each in members))))
    columns = ("map", "least", "5 %", "median", "95 %", "greatest", "fits nowhere")
    return Table(title=title, columns=columns, rows=tuple(rows))


KNOWN_FAULTS: dict[str, Callable[[Outcome], bool]] = {
    "known start: fits nowhere": lambda each: each.known.found is None,
    "known start: wrong": lambda each: each.known.found is not None and not each.known.is_right,
    f"known start: mean NEES above {INSIDE}": lambda each: each.known.mean_square > INSIDE,
}
START_FAULTS: dict[str, Callable[[UnknownStart], bool]] = {
    "unknown start: fits nowhere": lambda each: each.unknown.found is None,
    "unknown start: wrong": lambda each: each.unknown.found is not None and not each.unknown.is_right,
    "unknown start: ambiguous": lambda each: each.unknown.is_ambiguous,
    "rectangle: not ambiguous": lambda each: not each.rectangle.is_ambiguous,
    "rectangle: true start not listed": lambda each: not each.rectangle.lists_true_start,
}
CARRIED_FAULTS: dict[str, Callable[[Outcome], bool]] = {
    "carried: not found, or elsewhere": lambda each: each.carried is not None and not each.is_carrying_found,
    "carried: a pose is wrong": lambda each: each.carried is not None and not each.carried.is_right,
}


def fault_table(outcomes: Sequence[Start], faults: Mapping[str, Callable[[Start], bool]]) -> Table:
    """List the seeds of which something went wrong."""
    rows = [
        (name, str(len(seeds)), ", ".join(map(str, seeds)) or "-")
        for name, is_so in faults.items()
        for seeds in ([each.seed for each in outcomes if is_so(each)],)
    ]
    return Table(title="What went wrong", columns=("what", "number", "seeds"), rows=tuple(rows))


if __name__ == "__main__":
    main()
