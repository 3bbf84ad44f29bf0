"""Drawings as a program reads them, for tests: strokes, places and turns of SVG elements."""

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.classical.features import Observation
from echoplan.model import Corner, CornerKind, FeatureMap, Opening, UnobservedStretch
from echoplan.viewer.plan import Plan
from helpers.maps import ROOM, corner, cylinder, drawn, wall
from helpers.scenes import observed_circle, observed_wall

SVG = "{http://www.w3.org/2000/svg}"
NUMBER = r"-?\d+(?:\.\d+)?"
STATIONS = [[1.0, 1.0, 0.0], [1.0, 2.0, 3.0], [4.0, 0.75, -1.0]]
DETECTIONS = (observed_wall((0.0, 5.0), (1.0, 1.0)), observed_circle((3.5, 0.6, 0.1), (1.0, 2.0), sweep=1))


def full_plan(*, detections: tuple[Observation, ...] = DETECTIONS) -> Plan:
    """The L-shaped room with all there can be: walls, both kinds of corners, a column, stations, beams, echoes."""
    edge = Corner(position_xy=np.array([2.0, 1.5]), kind=CornerKind.CONVEX, covariance=np.diag([4e-4, 1e-4]))
    walls = [wall(start, end) for start, end in ROOM.walls_xy]
    found = drawn(*walls, corner([0.0, 0.0]), edge, cylinder([3.5, 0.6], 0.1), poses=STATIONS)
    return Plan(feature_map=found, truth=ROOM, detections=detections, echoes_xy=np.array([[1.0, 0.0], [9.0, 9.0]]))


def gapped_map() -> FeatureMap:
    """A floor with a doorway that was driven through, a slit that was seen through and a hidden stretch.

    Its last wall is inferred over 0.5 m at its end; all was observed from above.
    """
    floor = [wall([left, 0.0], [right, 0.0]) for left, right in ((0.0, 1.0), (1.9, 3.0), (3.25, 4.0), (4.5, 6.0))]
    floor[-1] = replace(floor[-1], endpoint_sigmas=np.array([0.01, np.nan]), inferred=np.array([0.0, 0.5]))
    return replace(
        drawn(*floor, poses=[[1.5, 1.0, 0.0], [1.5, -1.0, 0.0], [3.0, 1.0, 0.0], [5.0, 1.0, 0.0], [3.5, 1.0, 0.0]]),
        openings=(
            Opening(endpoints_xy=np.array([[1.0, 0.0], [1.9, 0.0]]), width_sigma=0.02, walls=(0, 1), passed=True),
            Opening(endpoints_xy=np.array([[3.0, 0.0], [3.25, 0.0]]), width_sigma=0.1, walls=(1, 2)),
        ),
        unobserved=(UnobservedStretch(endpoints_xy=np.array([[4.0, 0.0], [4.5, 0.0]]), walls=(2, 3)),),
    )


def strokes(made: ET.Element) -> list[FloatArray]:
    """Points of each stroke of a path of straight lines, those that Z closes without the repeated start."""
    parts = made.attrib["d"].removesuffix("Z").split("M")[1:]
    return [
        np.array([[float(each) for each in re.findall(NUMBER, point)] for point in part.split("L")]) for part in parts
    ]


def stroke(made: ET.Element) -> FloatArray:
    """Points of a path of one stroke."""
    (only,) = strokes(made)
    return only


def placed(made: ET.Element) -> tuple[FloatArray, float]:
    """Place and turn [degrees] of a group."""
    numbers = [float(each) for each in re.findall(NUMBER, made.attrib["transform"])]
    assert re.fullmatch(rf"translate\({NUMBER} {NUMBER}\)( rotate\({NUMBER}\))?", made.attrib["transform"])
    return np.array(numbers[:2]), numbers[2] if len(numbers) == 3 else 0.0


def marked(made: ET.Element | list[ET.Element], name: str) -> list[ET.Element]:
    """All elements of a class, in the order of the drawing."""
    roots = made if isinstance(made, list) else [made]
    return [each for root in roots for each in root.iter() if name in each.get("class", "").split()]


def the(made: ET.Element | list[ET.Element], name: str) -> ET.Element:
    """The only element of a class."""
    (only,) = marked(made, name)
    return only


def group_of(made: ET.Element | list[ET.Element], name: str) -> ET.Element:
    """The group that holds the only element of a class."""
    roots = made if isinstance(made, list) else [made]
    child = the(made, name)
    return next(each for root in roots for each in root.iter() if child in list(each))


def titles(made: ET.Element) -> Iterator[str]:
    """What an element and all in it say of themselves."""
    return (each.text or "" for each in made.iter() if each.tag.removeprefix(SVG) == "title")


def view_box(made: ET.Element) -> FloatArray:
    """Left, upper, width and height of a drawing."""
    return np.array([float(each) for each in made.attrib["viewBox"].split()])
