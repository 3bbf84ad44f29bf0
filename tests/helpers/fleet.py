"""Small recordings that map in a third of a second, for tests and benchmarks of batches."""

from pathlib import Path

import numpy as np

from echoplan.io import builtin_rig, builtin_world, write_recording, write_truth
from echoplan.model import Route
from echoplan.simulation import Simulation, SimulationSettings

# The fastest method that finds the walls of the square room from three stations of a ring of 16 sensors.
METHOD = "hough"
_STATIONS = np.array([[-0.4, 0.2, 0.3], [0.9, 0.1, 1.2], [1.5, 1.1, 2.4]])


def write_fleet(folder: Path, count: int) -> None:
    """Write recordings of the square room with their truth, in folders of ten."""
    for seed in range(count):
        simulation = Simulation(
            world=builtin_world("square"),
            rig=builtin_rig("ring-16"),
            route=Route(map_from_base=_STATIONS),
            settings=SimulationSettings(),
            seed=seed,
        )
        recording = folder / f"site-{seed // 10:03}" / f"rec-{seed % 10}"
        write_recording(recording, simulation)
        write_truth(recording / "truth.json", simulation.truth)
