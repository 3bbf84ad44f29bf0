"""Every measured figure that the documents quote: python benchmarks/run.py [FOLDER...].

Runs each benchmark in turn.  Folders of recordings with truth are scored too, and so are single recordings, which are
those of arenas; a recording without truth is mapped as a corridor.  Without folders, what needs them is left out.  The
tables of all methods in docs/methods.md are those of ``echoplan compare``, by the commands that stand beside them.
"""

import shlex
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent
# What to run, in this order; the others only where there are recordings.
BENCHMARKS = (
    "simulator.py",
    "reading.py",
    "grids.py",
    "square.py",
    "paper_room.py",
    "paper_room.py --variants --methods mdp-fuzzy,rcd",
    "paper_array.py",
    "flats.py",
    "joint.py",
    "joint.py --poses trust",
    "timing.py",
    "timing.py 50 100 --poses correct",
    "timing.py --live",
    "poses.py",
    "poses.py 150",
    "poses.py --stations 6",
    "poses.py --noisy",
    "poses.py --specified 0.1",
    "poses.py --specified 1",
    "poses.py --air 2",
    "poses.py --air 2 --thermometer 0.5",
    "poses.py 150 --air 2 --slip 0.001",
    "moving_head.py 5 --first 4 --stations 12 --speed 0.3",
    "moving_head.py 3 --first 4 --stations 12 --speed 0.3 --wait",
    "joint.py 30",
    "joint.py 30 --misset",
    "joint.py 30 --array hc-sr04-servo",
    "joint.py 30 --array ring-16",
    "joint.py --misset",
    "joint.py --recess",
    "shadows.py",
    "joint.py 24 --stations 100",
    "joint.py 24 --by-hand 0.003",
    "joint.py 24 --by-hand 0.005",
    "joint.py 24 --by-hand 0.01",
    "joint.py 24 --by-hand 0.02",
    "joint.py 60 --by-hand 0.01",
    "joint.py 48 --by-hand 0.02",
    "rays.py",
    "rays.py 8 --as-sound",
    "rays.py 8 --noise 0.01",
    "third_party_simulator.py",
    "third_party_simulator.py --burst smooth",
    "arenas.py",
    "arenas.py --coarse",
    "arenas.py --off 0.025 --turn 3",
    "arenas.py --off 0.025 --turn 3 --coarse",
    "heads.py",
    "heads.py --gain 0 --offset 0",
    "heads.py 8 --poses exact",
    "heads.py 8 --poses 'by hand'",
    "lone_corners.py",
    "localisation.py",
    "verdicts.py 40",
)
RECORDINGS, CORRIDOR = "recordings.py", "corridor.py"
# Number of noisy copies of real recordings, which show how much of a result is luck.
ARENA_COPIES, CORRIDOR_COPIES = "12", "24"
# Displacements of the waypoints of arenas [m].
DISPLACEMENTS = ("0.02", "0.05")


def main(folders: list[str]) -> None:
    """Run them all and stop at the first that fails."""
    for name in BENCHMARKS:
        run(*shlex.split(name))
    rooms = [folder for folder in folders if not is_recording(Path(folder))]
    arenas = [folder for folder in folders if folder not in rooms and is_surveyed(Path(folder))]
    if rooms:
        run(RECORDINGS, *rooms)
    if arenas:
        run(RECORDINGS, *arenas, "--min-stations", "1")
        run(RECORDINGS, *arenas, "--min-stations", "1", "--methods", "joint", "--noisy-copies", ARENA_COPIES)
        run("waypoints.py", *arenas, "--off", "0", "--copies", "1")
        run("waypoints.py", *arenas, "--off", "0", "--copies", "1", "--poses", "correct")
        for off in DISPLACEMENTS:
            run("waypoints.py", *arenas, "--off", off)
            run("waypoints.py", *arenas, "--off", off, "--known-associations")
        for option in ([], ["--known-associations"]):
            run("waypoints.py", *arenas, "--off", DISPLACEMENTS[-1], "--copies", "24", *option)
    for folder in folders:
        if folder not in (*rooms, *arenas):
            run(CORRIDOR, folder, "--noisy-copies", CORRIDOR_COPIES)


def is_recording(folder: Path) -> bool:
    """Return True if a folder is a recording, and not a folder of recordings."""
    return (folder / "pings.csv").exists()


def is_surveyed(recording: Path) -> bool:
    """Return True if the truth is known."""
    return (recording / "truth.json").exists()


def run(name: str, *arguments: str) -> None:
    """Run one benchmark under a head line that says how."""
    print(f"\n$ python benchmarks/{' '.join([name, *arguments])}\n", flush=True)
    subprocess.run([sys.executable, str(HERE / name), *arguments], check=True)


if __name__ == "__main__":
    main(sys.argv[1:])
