"""Change several files of a folder at once, as far as readers and the signal KILL are concerned.

A folder cannot change several files in one step, but two folders can swap their names in one (``renameat2`` of
Linux). So a copy of the folder is made of hard links, with the new files instead of the old ones. The copy takes the
name of the folder while the files of the folder itself are moved, and gives it back: readers find all old files or
all new ones, whenever the process is killed, and the folder remains the same for whoever works in it. Where the
system refuses (another system, a mount point, links not possible) files are moved without the copy.
"""

import ctypes
import errno
import logging
import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from itertools import islice
from pathlib import Path
from shutil import copystat, copytree, ignore_patterns

from echoplan.io.scratch import SCRATCH_PREFIX, locked

__all__ = ["replace_files"]

# From linux/fs.h and fcntl.h.
_RENAME_EXCHANGE, _AT_FDCWD = 2, -100
# A hard link takes some 20 microseconds: a folder of more entries (a home, a disk) is not copied.
_LINKS_AT_MOST = 10_000

_logger = logging.getLogger(__name__)


def replace_files(draft: Path, target: Path, *, stale: Iterable[str], scratch: Path) -> None:
    """Move everything in a draft into a folder, and take stale files away; all or nothing.

    Parameters
    ----------
    draft : Path
        The folder with the new files.
    target : Path
        The folder that is there already; its other files stay.
    stale : iterable of str
        Files of the target that go unless the draft has them, relative to it.
    scratch : Path
        An empty place on the same file system.

    Raises
    ------
    OSError
        If the system refuses; nothing has changed.
    """
    removed = [name for name in stale if not (draft / name).exists() and (target / name).is_file()]
    with locked(target.parent), _covered(draft, target, removed, scratch) as folder:
        aside = scratch / "aside"
        moves = [*_moves(draft, folder, aside), *((folder / name, aside / name) for name in removed)]
        for _, place in moves:
            if aside in place.parents:
                place.parent.mkdir(parents=True, exist_ok=True)
        with ExitStack() as undo:
            for source, place in moves:
                undo.callback(_put_back, source, place)
                source.replace(place)
            undo.pop_all()
    if folder != target:
        _keep_late(folder, target)


def _moves(draft: Path, folder: Path, aside: Path) -> Iterator[tuple[Path, Path]]:
    """List what is renamed to what: old files out of the way, then new ones to their places."""
    for child in sorted(draft.iterdir()):
        place = folder / child.name
        if child.is_dir() and place.is_dir():
            yield from _moves(child, place, aside / child.name)
            continue
        if os.path.lexists(place):
            yield place, aside / child.name
        yield child, place


def _put_back(source: Path, place: Path) -> None:
    if os.path.lexists(place) and not os.path.lexists(source):
        place.replace(source)


@contextmanager
def _covered(draft: Path, target: Path, removed: Iterable[str], scratch: Path) -> Iterator[Path]:
    """Show readers the finished copy of a folder meanwhile; yield where the folder itself is."""
    copy = scratch / "copy"
    try:
        _link_copy(draft, target, removed, copy)
        _exchange(copy, target)
    except OSError as error:
        _logger.debug("%s: files are moved one by one: %s", target, error)
        folder = target
    else:
        folder = copy
    try:
        yield folder
    finally:
        if folder == copy:
            _exchange(copy, target)


def _link_copy(draft: Path, target: Path, removed: Iterable[str], copy: Path) -> None:
    """Copy a folder by hard links, as it shall be in the end."""
    if next(islice(target.rglob("*"), _LINKS_AT_MOST, None), None) is not None:
        raise OSError(errno.E2BIG, f"more than {_LINKS_AT_MOST} files")
    copytree(target, copy, symlinks=True, copy_function=os.link, ignore=ignore_patterns(f"{SCRATCH_PREFIX}*"))
    for path in draft.rglob("*"):
        place = copy / path.relative_to(draft)
        if path.is_dir():
            place.mkdir(exist_ok=True)
        else:
            place.unlink(missing_ok=True)
            place.hardlink_to(path)
    for name in removed:
        (copy / name).unlink()
    owner = target.stat()
    os.chown(copy, owner.st_uid, owner.st_gid)
    copystat(target, copy)


def _keep_late(copy: Path, target: Path) -> None:
    """Move to a folder what others wrote into the copy while it had the name of the folder."""
    for path in copy.rglob("*"):
        place = target / path.relative_to(copy)
        if path.is_dir() or (os.path.lexists(place) and os.path.samestat(path.lstat(), place.lstat())):
            continue
        place.parent.mkdir(parents=True, exist_ok=True)
        path.replace(place)


def _exchange(one: Path, other: Path) -> None:
    """Let two folders swap their names in one step."""
    if sys.platform != "linux":
        raise OSError(errno.ENOSYS, os.strerror(errno.ENOSYS))
    renameat2 = getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None)
    if renameat2 is None:
        raise OSError(errno.ENOSYS, os.strerror(errno.ENOSYS))
    if renameat2(_AT_FDCWD, os.fsencode(one), _AT_FDCWD, os.fsencode(other), _RENAME_EXCHANGE):
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
