"""Small recordings that map in half a second, for tests and benchmarks of batches."""

from pathlib import Path

from echoplan.io import builtin_rig, builtin_route, builtin_world, write_recording, write_truth
from echoplan.simulation import Simulation, SimulationSettings

__all__ = ["METHOD", "write_fleet"]

# The fastest method that finds the four walls of the square room by the 80 pings of a recording.
METHOD = "hough"


def write_fleet(folder: Path, count: int) -> None:
    """Write recordings of the square room by a ring of 16 sensors with their truth, in folders of ten."""
    for seed in range(count):
        simulation = Simulation(
            world=builtin_world("square"),
            rig=builtin_rig("ring-16"),
            route=builtin_route("square"),
            settings=SimulationSettings(),
            seed=seed,
        )
        recording = folder / f"site-{seed // 10:03}" / f"rec-{seed % 10}"
        write_recording(recording, simulation)
        write_truth(recording / "truth.json", simulation.truth)
