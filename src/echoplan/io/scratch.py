"""Scratch folders: on the file system of what is written, locked by their process, removed after it was killed."""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from shutil import rmtree
from tempfile import mkdtemp

from echoplan.signals import at_signal

try:
    import fcntl
except ImportError:  # pragma: no cover - Windows: there scratch folders of killed runs stay
    fcntl = None  # type: ignore[assignment]

__all__ = ["SCRATCH_PREFIX", "locked", "scratch_folder"]

SCRATCH_PREFIX = ".echoplan-"


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Hold the lock of a folder; other processes of ours wait. File systems without locks are used without."""
    descriptor = _lock(folder, wait=True)
    try:
        yield
    finally:
        _release(descriptor)


@contextmanager
def scratch_folder(target: Path) -> Iterator[Path]:
    """Make a scratch folder from which files can be renamed into a target, and remove it in the end.

    It lies beside the target. If the target is a folder on another file system, or the folder above may not be
    written to, it lies in the target. Scratch folders whose process was killed are removed first.
    """
    with locked(target.parent):
        for folder in (target.parent, target):
            _sweep(folder)
        scratch = Path(mkdtemp(prefix=SCRATCH_PREFIX, dir=target if target.is_dir() else target.parent))
        descriptor = _lock(scratch, wait=False)
        with suppress(OSError):
            scratch = scratch.rename(target.parent / scratch.name)
    # What cannot be removed now, the next run tries again.
    remove = partial(rmtree, scratch, ignore_errors=True)
    with at_signal(remove):
        try:
            yield scratch
        finally:
            remove()
            _release(descriptor)


def _sweep(folder: Path) -> None:
    """Remove the scratch folders that no living process has locked."""
    for scratch in folder.glob(f"{SCRATCH_PREFIX}*"):
        descriptor = _lock(scratch, wait=False)
        if descriptor is not None:
            rmtree(scratch, ignore_errors=True)
        _release(descriptor)


def _lock(folder: Path, *, wait: bool) -> int | None:
    """Open and lock a folder; None if another process has it, or there are no locks."""
    if fcntl is None:  # pragma: no cover
        return None
    with suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
        except OSError:
            os.close(descriptor)
            raise
        return descriptor
    return None


def _release(descriptor: int | None) -> None:
    if descriptor is not None:
        os.close(descriptor)
