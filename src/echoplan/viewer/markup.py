"""Elements of SVG and HTML; whatever text they carry is escaped when they are written."""

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

__all__ = ["coordinates", "element", "path", "size"]

# What no XML document may hold, not even escaped (XML 1.0, production 2).
_FORBIDDEN = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def element(tag: str, *children: ET.Element, text: str = "", **attributes: str) -> ET.Element:
    """Make an element.

    Parameters
    ----------
    tag : str
        Its name.
    *children : Element
        What is in it.
    text : str, optional
        What it says, before its children; characters that no document may hold become replacement characters.
    **attributes : str
        Its attributes; a trailing underscore is dropped and others become dashes, as in ``class_``, ``data_key``.

    Returns
    -------
    Element
        The element.

    Examples
    --------
    >>> ET.tostring(element("text", text="1 < 2", class_="tick"))
    b'<text class="tick">1 &lt; 2</text>'
    """
    made = ET.Element(tag, {name.rstrip("_").replace("_", "-"): _allowed(value) for name, value in attributes.items()})
    made.text = _allowed(text) or None
    made.extend(children)
    return made


def size(value: float) -> str:
    """Write a number for a drawing.

    Parameters
    ----------
    value : float
        The number.

    Returns
    -------
    str
        To a ten-thousandth, without needless zeros.

    Examples
    --------
    >>> size(-0.00001), size(12.50)
    ('0', '12.5')
    """
    return f"{value:z.4f}".rstrip("0").rstrip(".")


def coordinates(point: ArrayLike) -> str:
    """Write a point for a drawing.

    Parameters
    ----------
    point : array_like, shape (2,)
        The point.

    Returns
    -------
    str
        Both numbers.

    Examples
    --------
    >>> coordinates([1.0, 2.25])
    '1 2.25'
    """
    return " ".join(size(value) for value in np.asarray(point, dtype=np.float64).tolist())


def path(strokes: Iterable[ArrayLike], *, closed: bool = False) -> str:
    """Write strokes as the data of an SVG path.

    Parameters
    ----------
    strokes : iterable of array_like, shape (n, 2)
        The points of each stroke.
    closed : bool, optional
        Join the last point of each to its first.

    Returns
    -------
    str
        The path.

    Examples
    --------
    >>> path([[[0, 0], [1, 0]], [[2, 2], [3, 2]]])
    'M0 0L1 0M2 2L3 2'
    """
    end = "Z" if closed else ""
    return "".join("M" + "L".join(coordinates(point) for point in np.asarray(stroke)) + end for stroke in strokes)


def _allowed(text: str) -> str:
    return _FORBIDDEN.sub("\N{REPLACEMENT CHARACTER}", text)
