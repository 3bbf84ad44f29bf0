"""Reports: one HTML file with the map, its numbers and whatever else there is to say; it asks for no other file."""

import base64
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files
from string import Template

from echoplan.model import FeatureMap, Table
from echoplan.viewer.markup import element
from echoplan.viewer.plan import Plan
from echoplan.viewer.sections import Definitions, Picture, Section, Text
from echoplan.viewer.svg import plan_element
from echoplan.viewer.tables import corner_table, cylinder_table, wall_table
from echoplan.viewer.wording import plural

__all__ = ["Report", "found_in_words", "report_html"]

# What the reader may hide or show: name of the layer, what to call it, whether it is shown at first.
_LAYERS = (
    ("truth", "true room", True),
    ("heard", "what single sweeps heard", False),
    ("echoes", "echoes as points", True),
    ("enlarged", "uncertainty ten times enlarged", False),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Report:
    """What a report tells.

    Parameters
    ----------
    title : str
        Its title.
    plan : Plan
        The map and what lies beneath it.
    sections : tuple of Section, optional
        What comes after the map and its tables.
    """

    title: str
    plan: Plan
    sections: tuple[Section, ...] = ()


def report_html(report: Report) -> str:
    """Write a report as one page.

    Parameters
    ----------
    report : Report
        What it tells.

    Returns
    -------
    str
        An HTML document without references to other files.
    """
    found = report.plan.feature_map
    tables = {
        "wall": wall_table(found.walls),
        "corner": corner_table(found.corners),
        "cylinder": cylinder_table(found.cylinders),
    }
    sections = [
        *(_section(_table(table, feature=kind), title=table.title) for kind, table in tables.items() if table.rows),
        *(_written(each) for each in report.sections),
    ]
    return Template(_file("report.html")).substitute(
        title=_text(report.title),
        lead=_text(found_in_words(report.plan.feature_map)),
        facts=_html(_facts(report.plan)),
        style=_file("report.css"),
        script=_file("report.js"),
        map=_html(plan_element(report.plan)),
        layers=_html(_layers(report.plan)),
        sections="\n".join(_html(each) for each in sections),
    )


def found_in_words(feature_map: FeatureMap) -> str:
    """Say what is in a map.

    Parameters
    ----------
    feature_map : FeatureMap
        The map.

    Returns
    -------
    str
        A sentence.

    Examples
    --------
    >>> found_in_words(FeatureMap(method="rcd"))
    '0 walls, 0 corners and 0 cylinders, heard from 0 stations.'
    """
    walls = plural(len(feature_map.walls), "wall")
    corners = plural(len(feature_map.corners), "corner")
    cylinders = plural(len(feature_map.cylinders), "cylinder")
    return f"{walls}, {corners} and {cylinders}, heard from {plural(len(feature_map.sweeps), 'station')}."


def _facts(plan: Plan) -> ET.Element:
    (left, low), (right, high) = plan.bounds_xy
    length = sum(wall.length for wall in plan.feature_map.walls)
    facts = (
        ("Method", plan.feature_map.method),
        ("Size", f"{right - left:.2f} m × {high - low:.2f} m"),  # noqa: RUF001 - the sign of multiplication
        ("Walls", f"{length:.2f} m"),
        ("Frame", plan.feature_map.frame),
    )
    return element("dl", *(element("div", element("dt", text=name), element("dd", text=text)) for name, text in facts))


def _layers(plan: Plan) -> ET.Element:
    present = {
        "truth": plan.truth is not None,
        "heard": bool(plan.heard),
        "echoes": bool(len(plan.echoes_xy)),
        "enlarged": bool(plan.ellipses or plan.feature_map.walls),
    }
    boxes = [_layer(name, words, shown=shown) for name, words, shown in _LAYERS if present[name]]
    return element("fieldset", element("legend", text="Show"), *boxes, class_="layers")


def _layer(name: str, words: str, *, shown: bool) -> ET.Element:
    box = element("input", type="checkbox", name=name, **({"checked": "checked"} if shown else {}))
    box.tail = words
    return element("label", box)


def _written(section: Section) -> ET.Element:
    match section:
        case Table():
            return _section(_table(section), title=section.title)
        case Picture():
            return _picture(section)
        case Text():
            return _section(*(element("p", text=each) for each in section.paragraphs), title=section.title)
        case Definitions():
            return _definitions(section)


def _section(*parts: ET.Element, title: str, kind: str = "text") -> ET.Element:
    return element("section", element("h2", text=title), *parts, class_=kind)


def _picture(picture: Picture) -> ET.Element:
    data = base64.b64encode(picture.png).decode("ascii")
    image = element("img", src=f"data:image/png;base64,{data}", alt=picture.caption, loading="lazy")
    figure = element("figure", image, element("figcaption", text=picture.caption))
    return _section(figure, title=picture.title, kind="picture")


def _definitions(definitions: Definitions) -> ET.Element:
    pairs = [
        element(tag, text=text) for item in definitions.items for tag, text in zip(("dt", "dd"), item, strict=True)
    ]
    listed = element("dl", *pairs)
    if not definitions.folded:
        return _section(listed, title=definitions.title)
    return element("section", element("details", element("summary", text=definitions.title), listed))


def _table(table: Table, *, feature: str = "") -> ET.Element:
    """Make a table that can be sorted; rows about a feature know which."""
    numeric = [all(_is_number(row[column]) for row in table.rows) for column in range(len(table.columns))]
    head = [
        element("th", element("button", text=name, type="button"), scope="col", **_class(number=number))
        for name, number in zip(table.columns, numeric, strict=True)
    ]
    rows = [element("tr", *_cells(row, numeric), **_key(feature, row)) for row in table.rows]
    drawn = element("table", element("thead", element("tr", *head)), element("tbody", *rows))
    return element("div", drawn, class_="scroll")


def _cells(row: Sequence[str], numeric: Sequence[bool]) -> list[ET.Element]:
    first = element("th", text=row[0], scope="row", **_class(number=numeric[0]))
    rest = [
        element("td", text=text, **_class(number=is_one)) for text, is_one in zip(row[1:], numeric[1:], strict=True)
    ]
    return [first, *rest]


def _key(feature: str, row: Sequence[str]) -> dict[str, str]:
    return {"data_feature": f"{feature}-{row[0]}"} if feature else {}


def _class(*, number: bool) -> dict[str, str]:
    return {"class_": "number"} if number else {}


def _is_number(text: str) -> bool:
    return not text or text[0] in "+-0123456789\N{MINUS SIGN}"


def _file(name: str) -> str:
    return files("echoplan.viewer").joinpath(name).read_text(encoding="utf-8")


def _html(made: ET.Element) -> str:
    return ET.tostring(made, encoding="unicode", method="html")


def _text(text: str) -> str:
    made = element("span", text=text)
    return _html(made).removeprefix("<span>").removesuffix("</span>")
