"""Every measured figure that the documents quote: python benchmarks/run.py [FOLDER...].

Runs each benchmark in turn.  Folders of recordings with truth are scored too, and so are single recordings, which are
those of arenas; a recording without truth is mapped as a corridor.  Without folders, what needs them is left out.  The
tables of all methods in docs/methods.md are those of ``echoplan compare``, by the commands that stand beside them.
"""

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
    "pace.py",
    "pace.py 50 100 --poses correct",
    "poses.py",
    "poses.py 150",
    "poses.py --stations 6",
    "poses.py --noisy",
    "poses.py --told 0.1",
    "poses.py --told 1",
    "poses.py --air 2",
    "poses.py --air 2 --thermometer 0.5",
    "poses.py 150 --air 2 --slip 0.001",
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
    "rays.py --as-sound",
    "rays.py 8 --noise 0.01",
    "referee.py",
    "referee.py --burst smooth",
    "arenas.py",
    "arenas.py --coarse",
    "arenas.py --off 0.025 --turn 3",
    "arenas.py --off 0.025 --turn 3 --coarse",
    "heads.py",
    "heads.py --gain 0 --offset 0",
)
RECORDINGS, CORRIDOR = "recordings.py", "corridor.py"
# How often noise is added to real recordings, to tell luck from skill.
ARENA_COPIES, CORRIDOR_COPIES = "12", "24"
# How far way-points of arenas are put elsewhere [m].
ASTRAY = ("0.02", "0.05")


def main(folders: list[str]) -> None:
    """Run them all and stop at the first that fails."""
    for name in BENCHMARKS:
        run(*name.split())
    rooms = [folder for folder in folders if not is_recording(Path(folder))]
    arenas = [folder for folder in folders if folder not in rooms and is_surveyed(Path(folder))]
    if rooms:
        run(RECORDINGS, *rooms)
    if arenas:
        run(RECORDINGS, *arenas, "--min-heard", "1")
        run(RECORDINGS, *arenas, "--min-heard", "1", "--methods", "joint", "--shaken", ARENA_COPIES)
        run("waypoints.py", *arenas, "--off", "0", "--copies", "1")
        run("waypoints.py", *arenas, "--off", "0", "--copies", "1", "--poses", "correct")
        for off in ASTRAY:
            run("waypoints.py", *arenas, "--off", off)
            run("waypoints.py", *arenas, "--off", off, "--told")
        for told in ([], ["--told"]):
            run("waypoints.py", *arenas, "--off", ASTRAY[-1], "--copies", "24", *told)
    for folder in folders:
        if folder not in (*rooms, *arenas):
            run(CORRIDOR, folder, "--shaken", CORRIDOR_COPIES)


def is_recording(folder: Path) -> bool:
    """Tell whether a folder is a recording, and not one of recordings."""
    return (folder / "pings.csv").exists()


def is_surveyed(recording: Path) -> bool:
    """Tell whether the truth is known."""
    return (recording / "truth.json").exists()


def run(name: str, *arguments: str) -> None:
    """Run one benchmark under a head line that says how."""
    print(f"\n$ python benchmarks/{' '.join([name, *arguments])}\n", flush=True)
    subprocess.run([sys.executable, str(HERE / name), *arguments], check=True)


if __name__ == "__main__":
    main(sys.argv[1:])
