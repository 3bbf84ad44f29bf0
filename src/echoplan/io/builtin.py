"""Rigs, worlds and routes that come with echoplan, by name."""

from collections.abc import Callable
from importlib.resources import as_file, files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import TypeVar

from echoplan.errors import UnknownNameError
from echoplan.io.rig import read_rig
from echoplan.io.route import read_route
from echoplan.io.world import read_world
from echoplan.model import Rig, Route, World

__all__ = ["builtin_rig", "builtin_route", "builtin_world", "rig_names", "route_names", "world_names"]

ValueT = TypeVar("ValueT")


def rig_names() -> list[str]:
    """List the built-in rigs.

    Returns
    -------
    list of str
        Their names in alphabetical order.

    Examples
    --------
    >>> "rotary-array" in rig_names()
    True
    """
    return _names("rig")


def world_names() -> list[str]:
    """List the built-in worlds.

    Returns
    -------
    list of str
        Their names in alphabetical order.

    Examples
    --------
    >>> "paper-room" in world_names()
    True
    """
    return _names("world")


def route_names() -> list[str]:
    """List the built-in routes: one for each world, of the same name.

    Returns
    -------
    list of str
        Their names in alphabetical order.

    Examples
    --------
    >>> route_names() == world_names()
    True
    """
    return _names("route")


def builtin_rig(name: str) -> Rig:
    """Return a built-in rig.

    Parameters
    ----------
    name : str
        One of ``rig_names()``.

    Returns
    -------
    Rig
        The rig, with all that a simulator needs to know.

    Raises
    ------
    UnknownNameError
        If there is none of that name.

    Examples
    --------
    >>> [sensor.x for sensor in builtin_rig("rotary-array").sensors]
    [0.05, 0.0, -0.05, 0.0]
    """
    return _builtin("rig", name, read_rig)


def builtin_world(name: str) -> World:
    """Return a built-in world.

    Parameters
    ----------
    name : str
        One of ``world_names()``.

    Returns
    -------
    World
        The world.

    Raises
    ------
    UnknownNameError
        If there is none of that name.

    Examples
    --------
    >>> len(builtin_world("paper-room").pillars)
    1
    """
    return _builtin("world", name, read_world)


def builtin_route(name: str) -> Route:
    """Return the built-in route through the world of the same name.

    Parameters
    ----------
    name : str
        One of ``route_names()``.

    Returns
    -------
    Route
        Stations.

    Raises
    ------
    UnknownNameError
        If there is none of that name.

    Examples
    --------
    >>> builtin_route("square").map_from_base.shape[1]
    3
    """
    return _builtin("route", name, read_route)


def _entries(kind: str) -> dict[str, Traversable]:
    folder = files("echoplan") / "data" / f"{kind}s"
    return {Path(entry.name).stem: entry for entry in folder.iterdir()}


def _names(kind: str) -> list[str]:
    return sorted(_entries(kind))


def _builtin(kind: str, name: str, read: Callable[[Path], ValueT]) -> ValueT:
    entries = _entries(kind)
    if name not in entries:
        raise UnknownNameError(kind, name, known=entries)
    with as_file(entries[name]) as path:
        return read(path)
