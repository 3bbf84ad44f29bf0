"""Every exception that echoplan raises, as one tree.

::

    EchoplanError
    ├── InvalidValueError (ValueError)    an invalid value: a wrong shape, a negative radius
    ├── InputError        (ValueError)    a file or a setting that cannot be used as it is
    ├── OutputError       (OSError)       a result that cannot be written
    ├── UnknownNameError  (LookupError)   an unknown method, rig or world
    └── MissingExtraError (ImportError)   an optional package that is not installed

Libraries raise; only ``echoplan.cli.main`` catches, prints one line and returns 2.
"""

import difflib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

__all__ = [
    "EchoplanError",
    "InputError",
    "InvalidValueError",
    "MissingExtraError",
    "OutputError",
    "UnknownNameError",
]


class EchoplanError(Exception):
    """Base of all errors that echoplan raises on purpose; they travel between processes."""

    def __reduce__(self) -> tuple[Any, ...]:
        # Python would call the constructor with the message alone, whatever else it asks for.
        return _revived, (type(self), self.args, vars(self))


class InvalidValueError(EchoplanError, ValueError):
    """A value that cannot be: the message has its name, what it is and what it must be."""


class InputError(EchoplanError, ValueError):
    """An input that cannot be used, reported in one line: where, what and the remedy.

    Parameters
    ----------
    source : Path or str
        The file (or other source) at fault.
    problem : str
        What is wrong, with the offending value.
    remedy : str
        What to do about it.
    place : str, optional
        The place inside the source: ``"line 7, column range"``.
    """

    def __init__(self, source: Path | str, problem: str, *, remedy: str, place: str = "") -> None:
        self.source = str(source)
        self.place = place
        self.problem = problem
        self.remedy = remedy
        where = f"{source}, {place}" if place else f"{source}"
        super().__init__(f"{where}: {problem}; {remedy}")


class OutputError(EchoplanError, OSError):
    """A result that cannot be written; nothing half-written is left behind.

    Parameters
    ----------
    target : Path or str
        The file or folder that was to be written.
    problem : str
        What the operating system said.
    remedy : str
        What to do about it.
    """

    def __init__(self, target: Path | str, problem: str, *, remedy: str) -> None:
        self.target = str(target)
        self.problem = problem
        self.remedy = remedy
        super().__init__(f"{target}: {problem}; {remedy}")


class UnknownNameError(EchoplanError, LookupError):
    """An unknown name, with the known names and the nearest of them.

    Parameters
    ----------
    kind : str
        What the name should name: ``"method"``, ``"rig"``.
    name : str
        The unknown name.
    known : iterable of str
        The names there are.
    """

    def __init__(self, kind: str, name: str, *, known: Iterable[str]) -> None:
        names = sorted(known)
        near = difflib.get_close_matches(name, names, n=1)
        hint = f"did you mean {near[0]!r}? " if near else ""
        super().__init__(f"unknown {kind} {name!r}; {hint}known: {', '.join(names)}")


class MissingExtraError(EchoplanError, ImportError):
    """An optional package that is not installed.

    Parameters
    ----------
    package : str
        The package that could not be imported.
    extra : str
        The extra of echoplan that brings it.
    """

    def __init__(self, package: str, *, extra: str) -> None:
        super().__init__(f"{package} is not installed; install it with: pip install {package} (extra {extra!r})")


def _revived(kind: type[EchoplanError], args: tuple[Any, ...], fields: dict[str, Any]) -> EchoplanError:
    error = kind.__new__(kind)
    error.args = args
    vars(error).update(fields)
    return error
