"""The recordings below a folder, and the files that each consists of."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from echoplan.errors import InputError
from echoplan.io.files import readable

__all__ = ["Recorded", "find_recordings"]

# A folder with one of these is one recording; whatever else is missing in it is reported when it is opened.
_MARKS = frozenset({"pings.csv", "metadata.yaml"})
_RESULTS = {"map.json", "run.toml"}
# What belongs to a recording that is a folder: other files, such as notes, may change.
_PARTS = ("pings.csv", "rig.toml", "truth.json", "metadata.yaml")
_BAG_SUFFIXES = (".bag", ".mcap", ".db3")


@dataclass(frozen=True, slots=True, kw_only=True)
class Recorded:
    """A recording on the disk.

    Parameters
    ----------
    name : str
        Where it lies below the folder that was searched, with slashes on every system; unique.
    path : Path
        The folder or the file.
    files : tuple of Path
        Its files: when one of them changes, the recording is another one.
    """

    name: str
    path: Path
    files: tuple[Path, ...]


def find_recordings(folder: Path, *, without: Path | None = None) -> tuple[Recorded, ...]:
    """Find all recordings below a folder.

    A recording is a folder with ``pings.csv``, a folder with the ``metadata.yaml`` of a ROS 2 bag, or a file ``.bag``,
    ``.mcap`` or ``.db3``. What lies inside a recording belongs to it. Hidden folders are not searched, linked ones are.

    Parameters
    ----------
    folder : Path
        Where to search; it may be a recording itself.
    without : Path, optional
        A folder that is not searched: that of the maps.

    Returns
    -------
    tuple of Recorded
        In the order of their names.

    Raises
    ------
    InputError
        If there is no such folder, or nothing in it is a recording.

    Examples
    --------
    >>> folder = getfixture("tmp_path")
    >>> (folder / "monday").mkdir()
    >>> _ = (folder / "monday" / "pings.csv").write_text("t,sensor,range")
    >>> [each.name for each in find_recordings(folder)]
    ['monday']
    """
    with readable(folder):
        if not folder.is_dir():
            problem = "it is a file" if folder.exists() else "there is no such folder"
            raise InputError(folder, problem, remedy="name a folder with recordings below it")
    paths = _search(folder, set() if without is None else {without.resolve()})
    found = [_recorded(path, folder) for path in paths]
    if not found:
        remedy = "name a folder with recordings below it: folders with pings.csv and rig.toml, or bags"
        raise InputError(folder, "there is no recording in it", remedy=remedy)
    return tuple(sorted(found, key=lambda each: each.name))


def _search(folder: Path, searched: set[Path]) -> Iterator[Path]:
    """Yield the recordings in a folder, unless its true path is among those that were searched."""
    children = _children(folder, searched)
    names = {child.name for child in children}
    if not _MARKS.isdisjoint(names):
        yield folder
    # A folder of results is no recording, whatever bags it was exported to.
    elif not names >= _RESULTS:
        for child in children:
            if child.is_dir():
                yield from _search(child, searched)
            elif child.suffix.lower() in _BAG_SUFFIXES and child.is_file():
                yield child


def _children(folder: Path, searched: set[Path]) -> list[Path]:
    """List a folder that was not searched before; other systems leave hidden files beside those that people copy."""
    with readable(folder):
        true = folder.resolve()
        is_new = true not in searched
        searched.add(true)
        return [each for each in sorted(folder.iterdir()) if not each.name.startswith(".")] if is_new else []


def _recorded(path: Path, folder: Path) -> Recorded:
    name = path.resolve().name if path == folder else path.relative_to(folder).as_posix()
    files = [path]
    if path.is_dir():
        with readable(path):
            files = [each for each in path.iterdir() if each.name in _PARTS or each.suffix in _BAG_SUFFIXES]
    # Python decodes names that are not UTF-8 to lone surrogates, which cannot be encoded in any file.
    return Recorded(name=name.encode(errors="replace").decode(), path=path, files=tuple(sorted(files)))
