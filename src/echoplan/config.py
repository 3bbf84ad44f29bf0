"""Configurations: the settings of all stages in one file, and the record of a run that can be run again."""

import warnings
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, TypeAlias

from pydantic import BaseModel, Field, create_model

from echoplan.io.files import write_text
from echoplan.io.structure import Form, read_toml
from echoplan.io.text import format_toml
from echoplan.version import __version__

__all__ = ["Run", "Sections", "method_of", "read_config", "write_run"]

Sections: TypeAlias = Mapping[str, type[BaseModel]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """What was run, for the record.

    Parameters
    ----------
    source : str
        Where the sweeps came from.
    method : str, optional
        Name of the method.
    seed : int, optional
        Seed of whatever was random.
    start : str, optional
        The map in which the source was located, or from which its map goes on.
    version : str, optional
        Version of echoplan.
    """

    source: str
    method: str | None = None
    seed: int | None = None
    start: str | None = None
    version: str = __version__


def read_config(path: Path, sections: Sections) -> dict[str, Any]:
    r"""Read the settings of the stages from one file.

    Parameters
    ----------
    path : Path
        TOML with a table for each section; a table or key that is missing has its default.  The record of a
        run is such a file.  A key under its former name is read with a ``FutureWarning``.
    sections : mapping of str to type of BaseModel
        Settings of the stages by the name of their table.

    Returns
    -------
    dict of str to BaseModel
        The settings by the same names.

    Raises
    ------
    InputError
        If the file cannot be read, or has a table, a key or a value that cannot be.

    Examples
    --------
    >>> from echoplan.preprocessing import KmeansSettings
    >>> path = getfixture("tmp_path") / "config.toml"
    >>> _ = path.write_text("[method]\nmin_members = 4\n")
    >>> read_config(path, {"method": KmeansSettings})["method"].min_members
    4
    """
    tables: dict[str, Any] = {name: (settings, Field(default_factory=settings)) for name, settings in sections.items()}
    strict = {"extra": "forbid"}
    form = create_model("Config", __base__=Form, __cls_kwargs__=strict, run=(dict[str, Any], {}), **tables)
    renamed: list[warnings.WarningMessage] = []
    try:
        with warnings.catch_warnings(record=True, action="always", category=FutureWarning) as renamed:
            config = read_toml(path, form)
    finally:
        # An error names the new key, which the file does not have: the warning says which one it was.
        for each in renamed:
            warnings.warn(f"{path}: {each.message}", FutureWarning, stacklevel=2)
    return {name: getattr(config, name) for name in sections}


def method_of(path: Path) -> str | None:
    r"""Return the method of the run whose record serves as configuration.

    Parameters
    ----------
    path : Path
        A configuration.

    Returns
    -------
    str or None
        Name of the method; nothing if it is no record of a run.

    Raises
    ------
    InputError
        If the file cannot be read.

    Examples
    --------
    >>> path = getfixture("tmp_path") / "run.toml"
    >>> _ = path.write_text('[run]\nmethod = "rcd"\n[method]\n')
    >>> method_of(path)
    'rcd'
    """
    form = create_model("Record", __base__=Form, __cls_kwargs__={"extra": "ignore"}, run=(dict[str, Any], {}))
    method = read_toml(path, form).run.get("method")  # type: ignore[attr-defined]
    return method if isinstance(method, str) else None


def write_run(path: Path, run: Run, settings: Mapping[str, BaseModel]) -> None:
    """Write the record of a run: a configuration that says what it was used for.

    Parameters
    ----------
    path : Path
        The file, usually ``run.toml``.
    run : Run
        What was run.
    settings : mapping of str to BaseModel
        Settings of the stages by the name of their table.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    tables = {name: stage.model_dump(mode="json") for name, stage in settings.items()}
    write_text(path, format_toml({"run": asdict(run), **tables}))
