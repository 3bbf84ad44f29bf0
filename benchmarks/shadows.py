"""How many walls are detected in shadow: python benchmarks/shadows.py [ROOMS].

Maps random rooms (100 by default) from exact poses.  For every wall and every station that detected it, the true ends
of the wall give its echo relative to an infinite wall: all of it before its middle, less near its end, and knife-edge
diffraction past the end.  Prints the share of these pairs that are fainter by given decibels.  Occlusion by other
features is left out.
"""

import argparse
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor

import numpy as np

from echoplan.acoustics.predicted_echo import echo_geometry, shape_of
from echoplan.arrays import FloatArray
from echoplan.cli.terminal import show, tracked
from echoplan.geometry import along, lines_through, signed_distances
from echoplan.joint.initial_estimate import initial_estimate
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.mapper import JointSettings
from echoplan.joint.optimisation.edge_diffraction import diffracted
from echoplan.joint.pose_model_selection import estimate_map
from echoplan.joint.settings import PoseMode
from echoplan.model import Table
from echoplan.preprocessing.measurements import join_measurements, measurements_of
from library.rooms import random_simulation

ROOMS = 100
# A wall is one of the truth that is turned by less than this from it [rad], and no farther beside its middle [m].
TURNED, BESIDE = 0.15, 0.06
SHADOWS = (1.0, 3.0, 6.0, 9.0, 12.0)


def main() -> None:
    """Ask all rooms and print the shares."""
    parser = argparse.ArgumentParser(description="How many walls are detected in shadow.")
    parser.add_argument("rooms", type=int, nargs="?", default=ROOMS)
    rooms = parser.parse_args().rooms
    with ProcessPoolExecutor() as workers:
        runs = list(tracked(workers.map(losses, range(rooms)), total=rooms, task="mapping"))
    lost = np.concatenate(runs)
    rows = tuple((f"{each:.0f}", f"{100 * (lost >= each).mean():.1f}") for each in SHADOWS)
    columns = ("fainter than all of it by (dB) and more", "share (%)")
    show(Table(title=f"{len(lost)} walls detected in {rooms} rooms", columns=columns, rows=rows))


def losses(seed: int) -> FloatArray:
    """Attenuation at each station that detected a wall of a room [dB]."""
    simulation = random_simulation(seed)
    sweeps = tuple(simulation)
    measurements = join_measurements([measurements_of(each, simulation.rig) for each in sweeps])
    measured_poses = np.array([each.station for each in sweeps])
    estimate = estimate_map(
        initial_estimate(simulation.rig, measurements, measured_poses, JointSettings(poses=PoseMode.TRUST))
    )
    walls = simulation.truth.walls_xy.reshape(-1, 2, 2)
    wavelength = estimate.model.tabulated().wavelength
    return np.array([lost for each in estimate.features for lost in lost_of(each, walls, measured_poses, wavelength)])


def lost_of(wall: Hypothesis, walls: FloatArray, stations: FloatArray, wavelength: float) -> Iterator[float]:
    """Attenuation of a wall at each station that detected it [dB]."""
    ends = true_ends(wall, walls) if wall.is_wall else None
    if ends is None:
        return
    low, high = np.sort(along(wall.line, ends))
    for x, y, _ in stations[wall.llr_by_station > 0.0]:
        normal = np.cos(wall.line[0]), np.sin(wall.line[0])
        geometry, foot = echo_geometry(shape_of(wall.reflector), (x, y, *normal)), along(wall.line, [x, y])
        yield geometry[4] - diffracted(geometry, low - foot, foot - high, wavelength)[4]


def true_ends(wall: Hypothesis, walls: FloatArray) -> FloatArray | None:
    """Find the wall of the truth that this one is; none of a ghost."""
    lines, middle = lines_through(walls[:, 0], walls[:, 1]), wall.ends_xy.mean(axis=0)
    alike = (np.abs(np.sin(lines[:, 0] - wall.line[0])) < TURNED) & (np.abs(signed_distances(lines, middle)) < BESIDE)
    # Of two in one line it is the nearer one.
    apart = np.abs(along(lines, middle) - along(lines[:, None], walls).mean(axis=1))
    return walls[np.where(alike, apart, np.inf).argmin()] if alike.any() else None


if __name__ == "__main__":
    main()
