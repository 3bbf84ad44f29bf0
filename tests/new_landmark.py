"""Add a type of landmark, a thin pole, to a copy of the tree and map a room with it: python tests/new_landmark.py.

``thin_pole.patch`` is what it takes: the echo in ``acoustics.predicted_echo``, a row in ``joint.landmarks``, and how it
is drawn.  A pole is known to have a radius of 1 cm; without the patch it is a cylinder of some small radius.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from echoplan.io import builtin_rig
from echoplan.joint.mapper import JointMapper
from echoplan.methods import map_sweeps
from echoplan.model import Pillar, Polyline, Route, World
from echoplan.simulation import Simulation

ROOT = Path(__file__).resolve().parents[1]
PATCH = ROOT / "tests" / "thin_pole.patch"
ROOM = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]])
POLES = np.array([[1.2, 2.1], [2.9, 1.0]])
STATIONS = [(0.6, 0.6), (1.5, 0.8), (2.3, 0.6), (3.4, 0.7), (3.3, 2.2), (1.9, 1.6), (0.7, 1.6), (0.6, 2.5)]
# Radius of a pole, and how far from its place it may be drawn [m].
RADIUS, NEAR = 0.01, 0.005
PATCHED = "ECHOPLAN_THIN_POLE"


def main() -> None:
    """Patch a copy and run this file with it; there, map the room."""
    if PATCHED in os.environ:
        check()
        return
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(ROOT / "src", Path(folder) / "src", ignore=shutil.ignore_patterns("__pycache__"))
        command = ["git", "apply", "--verbose", str(PATCH)]
        subprocess.run(command, cwd=folder, check=True, env=os.environ | {"GIT_CEILING_DIRECTORIES": folder})
        environment = os.environ | {"PYTHONPATH": str(Path(folder) / "src"), PATCHED: "1"}
        raise SystemExit(subprocess.run([sys.executable, __file__], env=environment, check=False).returncode)


def check() -> None:
    """Map a room with two poles and a pillar, and check that the poles are drawn as poles."""
    discs = [(POLES[0], RADIUS), (POLES[1], RADIUS), (np.array([2.2, 2.3]), 0.1)]
    pillars = tuple(Pillar(center_xy=place, radius=radius) for place, radius in discs)
    world = World(name="poles", polylines=(Polyline(points_xy=ROOM, closed=True),), pillars=pillars)
    poses = np.column_stack([STATIONS, np.linspace(0.0, 6.0, len(STATIONS))])
    room = Simulation(world=world, rig=builtin_rig("rotary-array"), route=Route(map_from_base=poses), seed=1)
    found = map_sweeps(JointMapper(room.rig), tuple(room))
    poles = [each for each in found.cylinders if each.radius == RADIUS]
    for each in found.cylinders:
        name = "pole" if each.radius == RADIUS else "cylinder"
        x, y = each.center_xy
        sys.stdout.write(f"{name} at ({x:.3f}, {y:.3f}) m, radius {each.radius:.3f} m, {each.stations} stations\n")
    near = [min(float(np.hypot(*(each.center_xy - place))) for each in poles) < NEAR for place in POLES]
    if len(poles) != len(POLES) or not all(near):
        raise SystemExit("The poles were not found.")
    lines = len(PATCH.read_text(encoding="utf-8").splitlines())
    sys.stdout.write(f"{len(poles)} poles found, with a patch of {lines} lines.\n")


if __name__ == "__main__":
    main()
