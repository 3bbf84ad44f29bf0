"""The sweeps of a run on the disk until they are saved, so that a program that is killed loses none."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from shutil import rmtree

from echoplan.errors import InputError
from echoplan.io import Recorder, format_rig
from echoplan.live.feed import Control, Feed
from echoplan.model import Sweep

__all__ = ["UNSAVED", "keep_sweeps"]

UNSAVED = "unsaved"


@contextmanager
def keep_sweeps(feed: Feed, *, out: Path | None) -> Iterator[Callable[[Sweep], None]]:
    """Yield what appends a sweep to ``out/unsaved``; the folder goes when the block ends without an error.

    Sweeps of a recording are on the disk already: nothing is written of them.
    """
    if out is None or Control.SWEEP not in feed.controls:
        yield lambda _: None
        return
    folder = out / UNSAVED
    if folder.exists():
        remedy = "move this folder to a place of your own, or delete it"
        raise InputError(folder, "it holds the sweeps of a run that was killed, or has not ended", remedy=remedy)
    with Recorder(folder, rig=format_rig(feed.rig)) as recorder:
        yield recorder.add
    rmtree(folder, ignore_errors=True)
