"""Sections of a report: what a caller adds to it, each a plain value."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

from echoplan.model import Table

__all__ = ["Definitions", "Picture", "Section", "Text", "flattened"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """A figure.

    Parameters
    ----------
    name : str
        Stem of its file.
    title : str
        What it shows.
    caption : str
        What is to be seen in it; read out to those who cannot see it.
    png : bytes
        The picture.
    """

    name: str
    title: str
    caption: str
    png: bytes


@dataclass(frozen=True, slots=True, kw_only=True)
class Definitions:
    """Names and what they stand for.

    Parameters
    ----------
    title : str
        What they are about.
    items : tuple of tuple of str
        Names and values.
    folded : bool, optional
        Show only the title until it is opened.
    """

    title: str
    items: tuple[tuple[str, str], ...]
    folded: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Text:
    """Some words.

    Parameters
    ----------
    title : str
        What they are about.
    paragraphs : tuple of str
        The words, without markup.
    """

    title: str
    paragraphs: tuple[str, ...]


Section: TypeAlias = Picture | Table | Definitions | Text


def flattened(settings: Mapping[str, object]) -> tuple[tuple[str, str], ...]:
    """Write nested settings as names and values.

    Parameters
    ----------
    settings : mapping
        Settings of a run, ready for JSON.

    Returns
    -------
    tuple of tuple of str
        Dotted names and their values, in the order given.

    Examples
    --------
    >>> flattened({"filter": {"seed": 0}, "rules": "paper", "max_width": None})
    (('filter.seed', '0'), ('rules', 'paper'), ('max_width', 'not set'))
    """
    items: list[tuple[str, str]] = []
    for name, value in settings.items():
        if isinstance(value, Mapping):
            items += [(f"{name}.{inner}", text) for inner, text in flattened(value)]
        else:
            items.append((name, "not set" if value is None else str(value)))
    return tuple(items)
