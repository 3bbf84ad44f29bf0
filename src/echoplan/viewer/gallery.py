"""Galleries: many maps side by side on one page, a row a recording, a column a method."""

import xml.etree.ElementTree as ET
from dataclasses import dataclass
from string import Template

import numpy as np

from echoplan.viewer.marks import corner_marks, cylinder_marks, station_marks, truth_marks, wall_marks
from echoplan.viewer.markup import element, size
from echoplan.viewer.plan import Plan
from echoplan.viewer.sections import Section
from echoplan.viewer.sheet import Sheet
from echoplan.viewer.writing import escaped, html_of, own_file, section_element

__all__ = ["Exhibit", "Gallery", "gallery_html"]

# What is cut off the border and the foot of a sheet, which a small map does not need [mm].
_TRIM, _FOOT = 5.0, 12.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Exhibit:
    """A map in a gallery.

    Parameters
    ----------
    caption : str
        What to say of it.
    plan : Plan, optional
        The map; None where there is none to be shown.
    """

    caption: str
    plan: Plan | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Gallery:
    """Maps side by side.

    Parameters
    ----------
    title : str
        Title of the page.
    lead : str
        A line below it.
    sections : tuple of Section
        What comes before the maps.
    columns : tuple of str
        Heads of the columns.
    rows : tuple of tuple
        Head of each row and its exhibits, one a column.
    """

    title: str
    lead: str
    sections: tuple[Section, ...]
    columns: tuple[str, ...]
    rows: tuple[tuple[str, tuple[Exhibit, ...]], ...]


def gallery_html(gallery: Gallery) -> str:
    """Write a gallery as one page.

    Parameters
    ----------
    gallery : Gallery
        What it shows; all maps of a row are drawn to one scale.

    Returns
    -------
    str
        An HTML document without references to other files.
    """
    return Template(own_file("gallery.html")).substitute(
        title=escaped(gallery.title),
        lead=escaped(gallery.lead),
        style=own_file("report.css") + own_file("gallery.css"),
        script=own_file("sorting.js"),
        sections="\n".join(html_of(section_element(each)) for each in gallery.sections),
        maps=html_of(_maps(gallery)),
    )


def _maps(gallery: Gallery) -> ET.Element:
    corner = element("td")
    heads = [element("th", text=name, scope="col") for name in gallery.columns]
    rows = [_row(name, exhibits) for name, exhibits in gallery.rows]
    table = element("table", element("thead", element("tr", corner, *heads)), element("tbody", *rows))
    return element("div", table, class_="scroll gallery")


def _row(name: str, exhibits: tuple[Exhibit, ...]) -> ET.Element:
    bounds = [exhibit.plan.bounds_xy for exhibit in exhibits if exhibit.plan is not None]
    # One map that is far off must not make all the others small.
    sheet = Sheet(bounds_xy=np.median(bounds, axis=0)) if bounds else None
    cells = [element("td", *_exhibit(exhibit, sheet)) for exhibit in exhibits]
    return element("tr", element("th", text=name, scope="row"), *cells)


def _exhibit(exhibit: Exhibit, sheet: Sheet | None) -> list[ET.Element]:
    drawn = [] if exhibit.plan is None or sheet is None else [_miniature(exhibit.plan, sheet)]
    return [*drawn, element("p", text=exhibit.caption)]


def _miniature(plan: Plan, sheet: Sheet) -> ET.Element:
    layers = {
        "walls": wall_marks(plan, sheet),
        "truth": truth_marks(plan.truth, sheet) if plan.truth else [],
        "cylinders": cylinder_marks(plan, sheet),
        "corners": corner_marks(plan, sheet),
        "stations": station_marks(plan, sheet),
    }
    width, height = (sheet.size - [2 * _TRIM, 2 * _TRIM + _FOOT]).tolist()
    drawing = element(
        "svg",
        *(element("g", *marks, class_=name) for name, marks in layers.items()),
        class_="map",
        role="img",
        aria_label=f"Map made by {plan.feature_map.method}",
        viewBox=f"{size(_TRIM)} {size(_TRIM)} {size(width)} {size(height)}",
    )
    for each in drawing.iter():
        # On a page with many maps, names would occur twice and the keyboard would stop a thousand times.
        each.attrib.pop("id", None)
        each.attrib.pop("tabindex", None)
    return drawing
