"""Every measured figure that the documents quote: python benchmarks/run.py [FOLDER...].

Runs each benchmark in turn.  Folders of recordings with truth are scored too; without any, what needs them is left out.
"""

import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent
# What to run, in this order; the last one only where there are recordings.
BENCHMARKS = (
    "simulator.py",
    "reading.py",
    "grids.py",
    "square.py",
    "paper_room.py",
    "joint.py",
    "joint.py --poses trust",
    "pace.py",
    "poses.py",
    "poses.py --noisy",
)
RECORDINGS = "recordings.py"


def main(folders: list[str]) -> None:
    """Run them all and stop at the first that fails."""
    for name in BENCHMARKS:
        run(*name.split())
    if folders:
        run(RECORDINGS, *folders)


def run(name: str, *arguments: str) -> None:
    """Run one benchmark under a head line that says how."""
    print(f"\n$ python benchmarks/{' '.join([name, *arguments])}\n", flush=True)
    subprocess.run([sys.executable, str(HERE / name), *arguments], check=True)


if __name__ == "__main__":
    main(sys.argv[1:])
