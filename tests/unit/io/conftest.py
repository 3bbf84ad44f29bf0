"""What the tests of the formats share: a folder with a recording, ready to be spoilt."""

from collections.abc import Callable
from pathlib import Path

import pytest

from echoplan.io import builtin_rig, write_rig

HEADER = "t,sweep,sensor,servo,range,x,y,yaw"
Folder = Callable[..., Path]


@pytest.fixture
def folder(tmp_path: Path) -> Folder:
    """Write a recording of the rotary array from the rows of its pings."""

    def write(*rows: str, header: str = HEADER) -> Path:
        path = tmp_path / "recording"
        path.mkdir(exist_ok=True)
        write_rig(path / "rig.toml", builtin_rig("rotary-array"))
        (path / "pings.csv").write_text("".join(f"{line}\n" for line in (header, *rows)), encoding="utf-8")
        return path

    return write
