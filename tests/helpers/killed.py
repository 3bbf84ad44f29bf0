"""A run that is killed while it writes a folder: ``python killed.py FOLDER N`` ends with SIGKILL before its Nth step.

A step is a change of the file system: whatever Python reports of it to audit hooks.
"""

import os
import signal
import sys
from pathlib import Path

from echoplan.io import write_text, written_whole

STEPS = ("os.rename", "os.link", "os.remove", "os.rmdir", "os.mkdir", "os.chmod", "os.chown", "ctypes.dlsym")


def write_new(folder: Path) -> None:
    """Replace two files and remove a third."""
    with written_whole(folder, stale=("map.pgm",)) as draft:
        for name in ("map.json", "run.toml", "pictures/map.png"):
            write_text(draft / name, "new")


def die_before(last: int) -> None:
    """Let this process kill itself before a step."""
    left = last

    def count(event: str, _: tuple[object, ...]) -> None:
        nonlocal left
        left -= event in STEPS
        if event in STEPS and left == 0:
            os.kill(os.getpid(), signal.SIGKILL)

    sys.addaudithook(count)


if __name__ == "__main__":
    die_before(int(sys.argv[2]))
    write_new(Path(sys.argv[1]))
