"""Files as a whole: read with errors that name place and remedy, written beside and then renamed."""

import errno
import os
import re
import stat
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import wraps
from os import PathLike
from pathlib import Path
from typing import Concatenate, ParamSpec, TextIO, TypeVar

from echoplan.errors import InputError, OutputError
from echoplan.io.replacing import replace_files
from echoplan.io.scratch import scratch_folder

__all__ = [
    "by_name",
    "check_file",
    "check_folder",
    "inside",
    "open_text",
    "read_text",
    "readable",
    "writable",
    "write_bytes",
    "write_text",
    "written_whole",
]

P = ParamSpec("P")
R = TypeVar("R")

_UNREADABLE = {
    errno.ENOENT: ("there is no such file", "check the name"),
    errno.ENOTDIR: ("it lies below a file, not a folder", "check the name"),
    errno.EISDIR: ("it is a folder", "name a file in it"),
    errno.EACCES: ("it may not be read", "ask its owner for permission"),
    errno.ELOOP: ("its links lead in a circle", "name the file itself"),
    errno.ENAMETOOLONG: ("its name is too long", "check the name"),
}
_UNWRITABLE = {
    errno.ENOSPC: "free some space or choose another disk",
    errno.EDQUOT: "free some space or choose another disk",
    errno.EACCES: "choose a folder that you may write to",
    errno.EPERM: "choose a folder that you may write to",
    errno.EROFS: "choose a folder that you may write to",
}


def by_name(function: Callable[Concatenate[Path, P], R]) -> Callable[Concatenate[str | PathLike[str], P], R]:
    """Let a function of a file take its name as well.

    Parameters
    ----------
    function : callable
        What takes a path first.

    Returns
    -------
    callable
        The same, of a path or a string.
    """

    @wraps(function)
    def named(path: str | PathLike[str], /, *args: P.args, **kwargs: P.kwargs) -> R:
        """Call the function with the path of that name."""
        return function(Path(path), *args, **kwargs)

    return named


@contextmanager
def readable(path: Path) -> Iterator[None]:
    """Turn what the operating system says about reading a file into an ``InputError``.

    Parameters
    ----------
    path : Path
        The file or folder to blame.

    Raises
    ------
    InputError
        If the block raises an ``OSError``, or no file can have such a name.
    """
    if "\0" in str(path):
        raise InputError(path, "no file has a name with a zero byte", remedy="check the name")
    try:
        yield
    except OSError as error:
        said = error.strerror or str(error)
        problem, remedy = _UNREADABLE.get(error.errno or 0, (said, "check the disk and try again"))
        raise InputError(path, problem, remedy=remedy) from error


def check_file(path: Path) -> None:
    """Refuse what is no file on a disk: a pipe may never end, and cannot be read twice.

    Parameters
    ----------
    path : Path
        The file.

    Raises
    ------
    InputError
        If it is a pipe, a socket or a device, or cannot be looked at.
    """
    with readable(path):
        mode = path.stat().st_mode
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
        raise InputError(path, "it is a pipe or a device, not a file", remedy="save it as a file and name that")


def inside(path: Path, name: str) -> Path:
    """Return a file that was named by itself or by its folder, in which it has this name."""
    with readable(path):
        return path / name if path.is_dir() else path


@contextmanager
def open_text(path: Path) -> Iterator[TextIO]:
    """Open a text file: UTF-8, with or without a byte-order mark, line ends of any system.

    Parameters
    ----------
    path : Path
        The file.

    Yields
    ------
    TextIO
        The open file, its line ends turned into line feeds.

    Raises
    ------
    InputError
        If it cannot be read, is a pipe or a device, or is no UTF-8.
    """
    check_file(path)
    with readable(path):
        try:
            with path.open(encoding="utf-8-sig") as file:
                yield file
        except UnicodeDecodeError as error:
            place = f"line {_undecodable_line(path)}"
            raise InputError(path, "it is no UTF-8 text", place=place, remedy="save it as UTF-8") from error


@by_name
def read_text(path: Path) -> str:
    """Read a text file.

    Parameters
    ----------
    path : Path or str
        The file.

    Returns
    -------
    str
        Its text, without a byte-order mark and with line feeds only.

    Raises
    ------
    InputError
        If it cannot be read or is no UTF-8.
    """
    with open_text(path) as file:
        return file.read()


@contextmanager
def written_whole(path: Path, *, stale: Iterable[str] = ()) -> Iterator[Path]:
    """Write a file or a folder so that it is there whole or not at all.

    The block writes a file, or makes a folder, at the path it is given; that path lies beside the target and
    takes its place only when the block ends well. A folder that exists keeps its other files.

    Parameters
    ----------
    path : Path
        The target; the folders above it are made.
    stale : iterable of str, optional
        Files of an earlier run, relative to the folder: they go unless the block writes them.

    Yields
    ------
    Path
        Where to write, with the name of the target.

    Raises
    ------
    OutputError
        If the operating system refuses; the target is as it was before.

    Examples
    --------
    >>> folder = getfixture("tmp_path")
    >>> with written_whole(folder / "recording") as draft:
    ...     draft.mkdir()
    ...     _ = (draft / "note.txt").write_text("two sweeps")
    >>> (folder / "recording" / "note.txt").read_text()
    'two sweeps'
    """
    with writable(path):
        target = _resolved(path)
        _check_replaceable(target)
        target.parent.mkdir(parents=True, exist_ok=True)
        with scratch_folder(target) as scratch:
            # In a folder of its own: that of the scratch folder is locked.
            draft = scratch / "draft" / target.name
            draft.parent.mkdir()
            yield draft
            _flush(draft)
            _check_movable(draft, target)
            if target.is_dir():
                replace_files(draft, target, stale=stale, scratch=scratch)
            else:
                draft.replace(target)


def check_folder(path: Path, names: Iterable[str]) -> None:
    """Refuse a folder for results before any work is done for them.

    Parameters
    ----------
    path : Path
        The folder; it need not be there yet.
    names : iterable of str
        The files that shall be written into it.

    Raises
    ------
    OutputError
        If the folder cannot be made or written to, or something that is no file bears one of the names.
    """
    with writable(path):
        target = _resolved(path)
        _check_replaceable(target)
        if target.is_file():
            raise _in_the_way(target)
        nearest = next(folder for folder in (target, *target.parents) if folder.exists())
        if not os.access(nearest, os.W_OK | os.X_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
    for name in names:
        with writable(path / name):
            _check_replaceable(target / name)
            if (target / name).is_dir():
                raise _in_the_way(target / name)


@by_name
def write_text(path: Path, text: str) -> None:
    """Write a text file whole or not at all.

    Parameters
    ----------
    path : Path or str
        The file.
    text : str
        What it shall hold; written as UTF-8 with line feeds on every system, and with question marks for lone
        surrogates, of which Python makes file names that are no UTF-8.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    write_bytes(path, text.encode(errors="replace"))


@by_name
def write_bytes(path: Path, data: bytes) -> None:
    """Write a binary file whole or not at all.

    Parameters
    ----------
    path : Path or str
        The file.
    data : bytes
        What it shall hold.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    with written_whole(path) as draft:
        draft.write_bytes(data)


@contextmanager
def writable(path: Path) -> Iterator[None]:
    """Turn what the operating system says about writing a file into an ``OutputError``."""
    try:
        yield
    except OutputError as error:
        raise OutputError(path, error.problem, remedy=error.remedy) from error
    except OSError as error:
        remedy = _UNWRITABLE.get(error.errno or 0, "choose another place")
        raise OutputError(path, error.strerror or str(error), remedy=remedy) from error


def _resolved(path: Path) -> Path:
    try:
        target = path.resolve()
    except RuntimeError as error:  # so it is in Python 3.11 and 3.12; later a link is left in the path
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP)) from error
    if any(map(Path.is_symlink, (target, *target.parents))):
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP))
    return target


def _undecodable_line(path: Path) -> int:
    # Bytes that cannot be decoded become lone surrogates, which no UTF-8 text holds.
    with path.open(encoding="utf-8", errors="surrogateescape") as file:
        return next(number for number, line in enumerate(file, start=1) if re.search(r"[\udc80-\udcff]", line))


def _check_replaceable(target: Path) -> None:
    if target.exists() and not (target.is_file() or target.is_dir()):
        raise OSError(errno.EINVAL, "it is a device, not a file")
    if any(folder.is_file() for folder in target.parents):
        raise OSError(errno.ENOTDIR, "it lies below a file, not a folder")


def _flush(draft: Path) -> None:
    for path in (draft, *draft.rglob("*")):
        if path.is_file():
            with path.open("rb+") as file:
                os.fsync(file.fileno())


def _in_the_way(target: Path) -> OSError:
    return FileExistsError(errno.EEXIST, f"there is a {'folder' if target.is_dir() else 'file'} of that name")


def _check_movable(draft: Path, target: Path) -> None:
    # All of it before any of it is moved.
    if not target.exists():
        return
    if draft.is_dir() != target.is_dir():
        raise _in_the_way(target)
    for child in draft.iterdir() if draft.is_dir() else ():
        _check_movable(child, target / child.name)
