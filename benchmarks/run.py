"""Every measured figure that the documents quote: python benchmarks/run.py [FOLDER...].

Runs each benchmark in turn.  Folders of recordings with truth are scored too; a recording without truth is mapped as a
corridor.  Without folders, what needs them is left out.
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
    "joint.py",
    "joint.py --poses trust",
    "pace.py",
    "pace.py 50 100 --poses correct",
    "poses.py",
    "poses.py --noisy",
    "poses.py --air 2",
    "poses.py --air 2 --thermometer 0.5",
    "poses.py --lag 0.01",
    "poses.py --slip 0.01",
    "poses.py --slip 0.003 --air 2",
    "joint.py --misset",
    "joint.py --recess",
    "joint.py 24 --stations 100",
    "joint.py 24 --by-hand 0.003",
    "joint.py 24 --by-hand 0.005",
    "joint.py 24 --by-hand 0.01",
    "joint.py 24 --by-hand 0.02",
    "rays.py",
    "rays.py --as-sound",
    "rays.py 8 --noise 0.01",
    "referee.py",
    "referee.py --burst smooth",
)
RECORDINGS, CORRIDOR = "recordings.py", "corridor.py"


def main(folders: list[str]) -> None:
    """Run them all and stop at the first that fails."""
    for name in BENCHMARKS:
        run(*name.split())
    unsurveyed = [folder for folder in folders if is_unsurveyed(Path(folder))]
    if surveyed := [folder for folder in folders if folder not in unsurveyed]:
        run(RECORDINGS, *surveyed)
    for folder in unsurveyed:
        run(CORRIDOR, folder)


def is_unsurveyed(folder: Path) -> bool:
    """Tell whether a folder is a recording without truth."""
    return (folder / "pings.csv").exists() and not (folder / "truth.json").exists()


def run(name: str, *arguments: str) -> None:
    """Run one benchmark under a head line that says how."""
    print(f"\n$ python benchmarks/{' '.join([name, *arguments])}\n", flush=True)
    subprocess.run([sys.executable, str(HERE / name), *arguments], check=True)


if __name__ == "__main__":
    main(sys.argv[1:])
