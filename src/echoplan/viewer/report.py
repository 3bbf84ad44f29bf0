"""Reports: one HTML file with the map, its numbers and whatever else there is to say; it asks for no other file."""

import xml.etree.ElementTree as ET
from dataclasses import dataclass
from string import Template

import numpy as np

from echoplan.model import FeatureMap
from echoplan.viewer.markup import element
from echoplan.viewer.plan import Plan
from echoplan.viewer.quality import quality_element
from echoplan.viewer.sections import Section
from echoplan.viewer.svg import plan_element
from echoplan.viewer.tables import corner_table, cylinder_table, opening_table, wall_table
from echoplan.viewer.wording import plural
from echoplan.viewer.writing import escaped, html_of, own_file, section_element, table_element, titled

__all__ = ["Report", "found_in_words", "report_html"]

# What the reader may hide or show: name of the layer, what to call it, whether it is shown at first.
_LAYERS = (
    ("truth", "true room", True),
    ("detections", "detections of single sweeps", False),
    ("echoes", "echoes as points", True),
    ("enlarged", "uncertainty ten times enlarged", False),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Report:
    """Content of a report.

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
        Its content.

    Returns
    -------
    str
        An HTML document without references to other files.
    """
    found = report.plan.feature_map
    tables = {
        "wall": wall_table(found.walls),
        "opening": opening_table(found.openings),
        "corner": corner_table(found.corners),
        "cylinder": cylinder_table(found.cylinders),
    }
    sections = [
        *(
            titled(table_element(table, feature=kind), title=table.title)
            for kind, table in tables.items()
            if table.rows
        ),
        *(section_element(each) for each in report.sections),
    ]
    quality = [html_of(quality_element(found.quality))] if found.quality else []
    return Template(own_file("report.html")).substitute(
        title=escaped(report.title),
        quality="".join(quality),
        lead=escaped(found_in_words(found)),
        facts=html_of(_facts(report.plan)),
        style=own_file("report.css"),
        script=own_file("report.js") + own_file("sorting.js"),
        map=html_of(plan_element(report.plan)),
        layers=html_of(_layers(report.plan)),
        sections="\n".join(html_of(each) for each in sections),
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
        A sentence; and others if walls absorb sound, or if parts of walls were not observed.

    Examples
    --------
    >>> found_in_words(FeatureMap(method="rcd"))
    '0 walls, 0 corners and 0 cylinders, detected from 0 stations.'
    """
    openings = [plural(len(feature_map.openings), "opening")] if feature_map.openings else []
    features = ", ".join(
        [plural(len(feature_map.walls), "wall"), *openings, plural(len(feature_map.corners), "corner")]
    )
    cylinders = plural(len(feature_map.cylinders), "cylinder")
    found = f"{features} and {cylinders}, detected from {plural(len(feature_map.sweeps), 'station')}."
    return " ".join([found, *_soft_walls(feature_map), *_not_observed(feature_map)])


def _soft_walls(feature_map: FeatureMap) -> list[str]:
    """Say which walls absorb sound, and how much of its amplitude they return."""
    return [
        f"Wall {number} is soft: it returns {100 * 10 ** (-wall.reflection_loss / 20):.0f} % of the amplitude."
        for number, wall in enumerate(feature_map.walls)
        if wall.reflection_loss
    ]


def _not_observed(feature_map: FeatureMap) -> list[str]:
    """Say how much of the walls was inferred or not observed, if any."""
    inferred = sum(float(wall.inferred.sum()) for wall in feature_map.walls)
    unobserved = sum(float(np.hypot(*np.ptp(each.endpoints_xy, axis=0))) for each in feature_map.unobserved)
    lengths = (
        (inferred, "of wall inferred up to undetected corners"),
        (unobserved, "between walls not observed"),
    )
    parts = [f"{length:.2f} m {what}" for length, what in lengths if length]
    return [f"{'; '.join(parts)}."] if parts else []


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
        "detections": bool(plan.detections),
        "echoes": bool(len(plan.echoes_xy)),
        "enlarged": bool(plan.ellipses or plan.feature_map.walls),
    }
    boxes = [_layer(name, words, shown=shown) for name, words, shown in _LAYERS if present[name]]
    return element("fieldset", element("legend", text="Show"), *boxes, class_="layers")


def _layer(name: str, words: str, *, shown: bool) -> ET.Element:
    box = element("input", type="checkbox", name=name, **({"checked": "checked"} if shown else {}))
    sample = element("span", class_="sample")
    sample.tail = words
    return element("label", box, sample)
