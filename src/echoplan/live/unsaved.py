"""The sweeps of a run on the disk until they are saved, so that a program that is killed loses none."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from shutil import rmtree

from echoplan.errors import InputError
from echoplan.io import Recorder, format_rig
from echoplan.live.feed import Control, Feed
from echoplan.model import Sweep

__all__ = ["RECORDING", "UNSAVED", "keep_sweeps"]

RECORDING, UNSAVED = "recording", "unsaved"


@contextmanager
def keep_sweeps(feed: Feed, *, out: Path | None) -> Iterator[Callable[[Sweep], None]]:
    """Yield what appends a sweep to ``out/unsaved``; the folder goes when the block ends without an error.

    Sweeps of a recording are on the disk already: nothing is written of them.
    """
    if out is None or feed.controls == {Control.PAUSE}:
        yield lambda _: None
        return
    for name, problem in (
        (UNSAVED, "it holds the sweeps of a run that was killed, or has not ended"),
        (RECORDING, "it holds the sweeps of an earlier run, which this one would replace"),
    ):
        if (out / name).exists():
            raise InputError(out / name, problem, remedy="choose another folder for --out, or move or delete this one")
    folder = out / UNSAVED
    with Recorder(folder, rig=format_rig(feed.rig)) as recorder:
        yield recorder.add
    rmtree(folder, ignore_errors=True)
