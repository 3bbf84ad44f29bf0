"""Whether joint keeps up with a robot: python benchmarks/timing.py [STATIONS ...] [--poses trust].

Simulates one random room from many stations, adds the sweeps to the mapper one by one, and prints at given numbers of
stations (50, 100, 200, 500 and 1000 by default) the CPU time of ``add`` and of ``result``, the memory of the mapper,
and the scores of the map.  The poses are exact.
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
from echoplan.model import Table
from echoplan.simulation import Simulation
from library.rooms import random_simulation

Result = TypeVar("Result")

STATIONS = (50, 100, 200, 500, 1000)
SEED = 0


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
    marks = list(measure(sorted(arguments.stations), arguments.poses))
    show(table(marks))


def parse() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="Whether joint keeps up with a robot.")
    parser.add_argument("stations", type=int, nargs="*", default=list(STATIONS))
    parser.add_argument("--poses", type=PoseMode, choices=list(PoseMode), default=PoseMode.AUTO)
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
