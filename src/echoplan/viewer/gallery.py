"""Galleries: many maps side by side on one page, a group a recording."""

import xml.etree.ElementTree as ET
from dataclasses import dataclass, replace
from string import Template

import numpy as np

from echoplan.viewer.cells import grid_marks
from echoplan.viewer.marks import (
    corner_marks,
    cylinder_marks,
    echo_marks,
    gap_marks,
    station_marks,
    truth_marks,
    wall_marks,
)
from echoplan.viewer.markup import element, size
from echoplan.viewer.plan import Plan
from echoplan.viewer.sections import Section
from echoplan.viewer.sheet import Sheet
from echoplan.viewer.writing import escaped, html_of, own_file, section_element, titled

__all__ = ["Exhibit", "Gallery", "gallery_html"]

# What is cut off the border and the foot of a sheet, which a small map does not need [mm].
_TRIM, _FOOT = 5.0, 12.0
# More points than this are thinned out: they are many maps.
_MOST_POINTS = 1500


@dataclass(frozen=True, slots=True, kw_only=True)
class Exhibit:
    """A map in a gallery.

    Parameters
    ----------
    name : str
        What stands above it.
    plan : Plan, optional
        The map; None where there is none to be shown.
    numbers : tuple of tuple of str, optional
        Names and values that stand below it.
    words : str, optional
        What else is to be said of it.
    """

    name: str
    plan: Plan | None = None
    numbers: tuple[tuple[str, str], ...] = ()
    words: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Gallery:
    """Maps side by side.

    Parameters
    ----------
    title : str
        Title of the page.
    lead : str
        A line below it.
    rooms : tuple of tuple
        Title of each group of maps, and its exhibits.
    sections : tuple of Section, optional
        What comes after the maps.
    """

    title: str
    lead: str
    rooms: tuple[tuple[str, tuple[Exhibit, ...]], ...]
    sections: tuple[Section, ...] = ()


def gallery_html(gallery: Gallery) -> str:
    """Write a gallery as one page.

    Parameters
    ----------
    gallery : Gallery
        What it shows; all maps of a group are drawn to one scale.

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
        rooms="\n".join(html_of(_room(name, exhibits)) for name, exhibits in gallery.rooms),
        sections="\n".join(html_of(section_element(each)) for each in gallery.sections),
    )


def _room(name: str, exhibits: tuple[Exhibit, ...]) -> ET.Element:
    bounds = [exhibit.plan.bounds_xy for exhibit in exhibits if exhibit.plan is not None]
    # One map that is far off must not make all the others small.
    sheet = Sheet(bounds_xy=np.median(bounds, axis=0)) if bounds else None
    figures = [element("figure", *_exhibit(exhibit, sheet)) for exhibit in exhibits]
    return titled(element("div", *figures, class_="maps"), title=name, kind="gallery")


def _exhibit(exhibit: Exhibit, sheet: Sheet | None) -> list[ET.Element]:
    drawn = [] if exhibit.plan is None or sheet is None else [_miniature(exhibit.plan, sheet)]
    pairs = [element("div", element("dt", text=name), element("dd", text=value)) for name, value in exhibit.numbers]
    listed = [element("dl", *pairs)] if pairs else []
    words = [element("p", text=exhibit.words)] if exhibit.words else []
    return [element("figcaption", text=exhibit.name), *drawn, *listed, *words]


def _miniature(plan: Plan, sheet: Sheet) -> ET.Element:
    stride = max(-(-len(plan.echoes_xy) // _MOST_POINTS), 1)
    layers = {
        "truth": truth_marks(plan.truth, sheet) if plan.truth else [],
        "cells": grid_marks(plan.grid, sheet) if plan.grid else [],
        "echoes": echo_marks(replace(plan, echoes_xy=plan.echoes_xy[::stride]), sheet),
        "walls": wall_marks(plan, sheet),
        "gaps": gap_marks(plan, sheet),
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
