"""Whether joint keeps up with a robot: python benchmarks/timing.py [STATIONS ...] [--poses trust] [--online | --live].

Simulates one random room from many stations, adds the sweeps to the mapper one by one, and prints at given numbers of
stations (50, 100, 200, 500 and 1000 by default) the CPU time of ``add`` and of ``result``, the memory of the mapper,
and the scores of the map.  The poses are exact.

``--online`` prints instead how long the calls of ``OnlineMapper`` take by the clock while a robot drives: the rotary
array and a ring of 16 sensors, 100 stations with odometry that drifts, one every second; and how many sweeps the newest
map lacks.

``--live`` prints the CPU time of the process beside the page of ``echoplan live``: on a drive of the rotary array with
odometry that drifts, after 60 and 100 stations, to add a sweep to the map and draw it (each of the last four sweeps),
to check the map, and to map the whole recording as for saving it.
"""

import argparse
import pickle
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

import numpy as np

from echoplan.cli.terminal import show, tracked
from echoplan.evaluation import Evaluation, evaluate
from echoplan.joint.mapper import JointMapper, JointSettings
from echoplan.joint.settings import PoseMode
from echoplan.live.mapping import check_map, draw_map
from echoplan.live.survey import Survey
from echoplan.mapping import map_source
from echoplan.model import Table
from echoplan.online import OnlineMapper
from echoplan.simulation import Simulation
from library.rooms import ARRAY, Drive, random_drive, random_simulation

Result = TypeVar("Result")

STATIONS = (50, 100, 200, 500, 1000)
SEED = 0
# With --live: stations after which it is measured, and sweeps over which.
LIVE, RECENT = (60, 100), 4
# With --online: arrays, stations of a drive, and time from one to the next [s].
ARRAYS, DRIVEN, PERIOD = (ARRAY, "ring-16"), 100, 1.0


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Mark:
    """Measurements after a number of sweeps.

    Parameters
    ----------
    stations, pings : int
        How many.
    adding : tuple of float
        What each of these sweeps took [s].
    result : float
        What the map took [s].
    memory : int
        Of the mapper, pickled [bytes].
    evaluation : Evaluation
        The map against the truth.
    """

    stations: int
    pings: int
    adding: tuple[float, ...]
    result: float
    memory: int
    evaluation: Evaluation


def main() -> None:
    """Map one room from ever more stations and print what it took."""
    arguments = parse()
    if arguments.online:
        show(online_table([drive_online(array) for array in ARRAYS]))
        return
    if arguments.live:
        show(live_table(list(drive_live())))
        return
    marks = list(measure(sorted(arguments.stations), arguments.poses))
    show(table(marks))


def parse() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="Whether joint keeps up with a robot.")
    parser.add_argument("stations", type=int, nargs="*", default=list(STATIONS))
    parser.add_argument("--poses", type=PoseMode, choices=list(PoseMode), default=PoseMode.AUTO)
    parser.add_argument("--online", action="store_true", help="calls of OnlineMapper while a robot drives")
    parser.add_argument("--live", action="store_true", help="maps and verdicts of the page while a robot drives")
    return parser.parse_args()


def measure(stations: Sequence[int], poses: PoseMode) -> Iterator[Mark]:
    """Add sweep after sweep, and look at the map at each number of stations."""
    simulation: Simulation = random_simulation(SEED, stations=stations[-1])
    settings = JointSettings(poses=poses)
    mapper, adding, pings = JointMapper(simulation.rig, settings), list[float](), 0
    sweeps = list(tracked(simulation, total=stations[-1], task="simulating"))
    for sweep in sweeps[:3]:
        # The first map of a process also loads compiled code.
        mapper.add(sweep)
        mapper.result()
    mapper = JointMapper(simulation.rig, settings)
    for number, sweep in enumerate(tracked(sweeps, total=len(sweeps), task="mapping"), start=1):
        adding.append(timed(partial(mapper.add, sweep))[1])
        pings += len(sweep)
        if number in stations:
            drawn, spent = timed(mapper.result)
            yield Mark(
                stations=number,
                pings=pings,
                adding=tuple(adding),
                result=spent,
                memory=len(pickle.dumps(mapper)),
                evaluation=evaluate(drawn, simulation.truth),
            )


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class OnlineDrive:
    """What the calls of ``OnlineMapper`` took during a drive, by the clock [s], and the sweeps that the map lacked."""

    array: str
    adding: tuple[float, ...]
    reading: tuple[float, ...]
    behind: tuple[int, ...]
    evaluation: Evaluation


def drive_online(array: str) -> OnlineDrive:
    """Add a sweep every second, and read the newest map and the frame of odometry each time."""
    simulation = random_drive(SEED, Drive(stations=DRIVEN, array=array))
    adding, reading, behind = list[float](), list[float](), list[int]()
    with OnlineMapper(simulation.rig, JointSettings(poses=PoseMode.CORRECT)) as mapper:
        for sweep in tracked(list(simulation), total=len(simulation), task=f"driving with {array}"):
            begun = time.perf_counter()
            mapper.add(sweep)
            added = time.perf_counter()
            mapper.result()
            _ = mapper.map_from_odom
            reading.append(time.perf_counter() - added)
            adding.append(added - begun)
            behind.append(mapper.behind)
            time.sleep(max(0.0, PERIOD - (time.perf_counter() - begun)))
        evaluation = evaluate(mapper.finish(), simulation.truth)
    return OnlineDrive(
        array=array, adding=tuple(adding), reading=tuple(reading), behind=tuple(behind), evaluation=evaluation
    )


def online_table(drives: Sequence[OnlineDrive]) -> Table:
    """Lay out the times of the calls of drives."""
    columns = (
        "array",
        "add: 95 % (ms)",
        "longest",
        "result: 95 % (ms)",
        "longest",
        "behind: median",
        "most",
        "walls (%)",
    )
    rows = []
    for each in drives:
        walls, times = (
            each.evaluation.matches.walls.tally,
            [1000.0 * np.array(part) for part in (each.adding, each.reading)],
        )
        rows.append(
            (
                each.array,
                *(f"{value:.1f}" for part in times for value in (np.quantile(part, 0.95), part.max())),
                f"{np.median(each.behind):.0f}",
                str(max(each.behind)),
                f"{100 * walls.recall:.0f} / {100 * walls.precision:.0f}",
            )
        )
    return Table(title=f"Drives of {DRIVEN} stations, one every {PERIOD:g} s", columns=columns, rows=tuple(rows))


@dataclass(frozen=True, slots=True, kw_only=True)
class LiveMark:
    """What the last sweeps, the check of the map and the map of the whole recording took after a drive [s]."""

    stations: int
    drawing: tuple[float, ...]
    checking: float
    mapping: float


def drive_live() -> Iterator[LiveMark]:
    """Map the sweeps before the last ones of each mark at once, and the others one by one as the page does."""
    simulation = random_drive(SEED, Drive(stations=DRIVEN, array=ARRAY))
    survey = Survey(name=simulation.name, rig=simulation.rig)
    drawing, begins = list[float](), [mark - RECENT for mark in LIVE]
    for number, sweep in enumerate(tracked(list(simulation), total=len(simulation), task="driving"), start=1):
        survey = survey.with_sweep(sweep)
        if number in begins:
            draw_map(survey)
            drawing.clear()
        elif any(mark - RECENT < number <= mark for mark in LIVE):
            drawing.append(timed(partial(draw_map, survey))[1])
        if number in LIVE:
            yield LiveMark(
                stations=number,
                drawing=tuple(drawing),
                checking=timed(partial(check_map, survey))[1],
                mapping=timed(partial(map_source, survey.recording))[1],
            )


def live_table(marks: Sequence[LiveMark]) -> Table:
    """Lay out what the process beside the page takes against the number of stations."""
    rows = tuple(
        (
            str(mark.stations),
            *(f"{value:.1f}" for value in (np.median(mark.drawing), max(mark.drawing), mark.checking, mark.mapping)),
        )
        for mark in marks
    )
    columns = ("stations", "add a sweep: median (s)", "longest", "check (s)", "map all (s)")
    return Table(title=f"Page of a drive of {DRIVEN} stations", columns=columns, rows=rows)


def timed(work: Callable[[], Result]) -> tuple[Result, float]:
    """Do some work, and count the seconds of the processor that it takes."""
    begun = time.process_time()
    result = work()
    return result, time.process_time() - begun


def table(marks: Sequence[Mark]) -> Table:
    """Lay out time, memory and quality against the number of stations."""
    columns = (
        "stations", "pings", "seconds in all", "add: median (ms)", "95 %", "longest", "result (s)", "memory (MB)",
        "walls (%)",
    )  # fmt: skip
    return Table(title=f"Room {SEED} from ever more stations", columns=columns, rows=tuple(map(row, marks)))


def row(mark: Mark) -> tuple[str, ...]:
    """One number of stations."""
    walls, adding = mark.evaluation.matches.walls.tally, 1000 * np.array(mark.adding)
    return (
        str(mark.stations),
        str(mark.pings),
        f"{sum(mark.adding) + mark.result:.1f}",
        *(f"{value:.1f}" for value in (np.median(adding), np.quantile(adding, 0.95), adding.max())),
        f"{mark.result:.2f}",
        f"{mark.memory / 1e6:.1f}",
        f"{100 * walls.recall:.0f} / {100 * walls.precision:.0f}",
    )


if __name__ == "__main__":
    main()
