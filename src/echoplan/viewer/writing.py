"""Sections and tables as elements of a page, and elements as HTML."""

import base64
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from importlib.resources import files

from echoplan.model import Table
from echoplan.viewer.markup import element
from echoplan.viewer.sections import Definitions, Picture, Section, Text

__all__ = ["escaped", "html_of", "own_file", "section_element", "table_element", "titled"]


def section_element(section: Section) -> ET.Element:
    """Make a section of a page.

    Parameters
    ----------
    section : Section
        Its content.

    Returns
    -------
    Element
        A ``section``.
    """
    match section:
        case Table():
            return titled(table_element(section), title=section.title)
        case Picture():
            return _picture(section)
        case Text():
            return titled(*(element("p", text=each) for each in section.paragraphs), title=section.title)
        case Definitions():
            return _definitions(section)


def titled(*parts: ET.Element, title: str, kind: str = "text") -> ET.Element:
    """Put parts of a page under a heading.

    Parameters
    ----------
    *parts : Element
        The parts.
    title : str
        The heading.
    kind : str, optional
        Class of the section, for the style.

    Returns
    -------
    Element
        A ``section``.
    """
    return element("section", element("h2", text=title), *parts, class_=kind)


def table_element(table: Table, *, feature: str = "") -> ET.Element:
    """Make a table that can be sorted.

    Parameters
    ----------
    table : Table
        The table.
    feature : str, optional
        What its rows are about, if they are features of the map on the same page: each row knows which.

    Returns
    -------
    Element
        A ``div`` that scrolls where the page is too narrow.
    """
    numeric = [all(_is_number(row[column]) for row in table.rows) for column in range(len(table.columns))]
    head = [
        element("th", element("button", text=name, type="button"), scope="col", **_class(number=number))
        for name, number in zip(table.columns, numeric, strict=True)
    ]
    rows = [
        element("tr", *_cells(row, numeric), **({"data_feature": f"{feature}-{row[0]}"} if feature else {}))
        for row in table.rows
    ]
    drawn = element("table", element("thead", element("tr", *head)), element("tbody", *rows))
    return element("div", drawn, class_="scroll")


def html_of(made: ET.Element) -> str:
    """Write an element as HTML.

    Parameters
    ----------
    made : Element
        The element.

    Returns
    -------
    str
        Its markup.
    """
    return ET.tostring(made, encoding="unicode", method="html")


def escaped(text: str) -> str:
    """Write a text that may hold anything.

    Parameters
    ----------
    text : str
        The text.

    Returns
    -------
    str
        The same as HTML.

    Examples
    --------
    >>> escaped("1 < 2")
    '1 &lt; 2'
    """
    made = element("span", text=text)
    return html_of(made).removeprefix("<span>").removesuffix("</span>")


def own_file(name: str) -> str:
    """Read a file that lies beside this module.

    Parameters
    ----------
    name : str
        Its name.

    Returns
    -------
    str
        What is in it.
    """
    return files("echoplan.viewer").joinpath(name).read_text(encoding="utf-8")


def _picture(picture: Picture) -> ET.Element:
    data = base64.b64encode(picture.png).decode("ascii")
    image = element("img", src=f"data:image/png;base64,{data}", alt=picture.caption, loading="lazy")
    figure = element("figure", image, element("figcaption", text=picture.caption))
    return titled(figure, title=picture.title, kind="picture")


def _definitions(definitions: Definitions) -> ET.Element:
    pairs = [
        element(tag, text=text) for item in definitions.items for tag, text in zip(("dt", "dd"), item, strict=True)
    ]
    listed = element("dl", *pairs)
    if not definitions.folded:
        return titled(listed, title=definitions.title)
    return element("section", element("details", element("summary", text=definitions.title), listed))


def _cells(row: Sequence[str], numeric: Sequence[bool]) -> list[ET.Element]:
    first = element("th", text=row[0], scope="row", **_class(number=numeric[0]))
    rest = [
        element("td", text=text, **_class(number=is_one)) for text, is_one in zip(row[1:], numeric[1:], strict=True)
    ]
    return [first, *rest]


def _class(*, number: bool) -> dict[str, str]:
    return {"class_": "number"} if number else {}


def _is_number(text: str) -> bool:
    return not text or text[0] in "+-0123456789\N{MINUS SIGN}"
