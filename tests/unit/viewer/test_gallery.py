"""Many maps on one page."""

import base64
import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from io import BytesIO

import numpy as np
import pytest
from matplotlib.image import imread

from echoplan.model import Cylinder, FeatureMap, OccupancyGrid, Wall
from echoplan.viewer import Exhibit, Gallery, Plan, Text, gallery_html
from echoplan.viewer.sheet import Sheet
from helpers.drawings import gapped_map
from helpers.maps import ROOM, cylinder, drawn, wall

POSES = [[1.0, 1.0, 0.0], [1.0, 2.0, 3.0]]
WALLS = [wall(start, end) for start, end in ROOM.walls_xy]


def plan(*, far: float = 0.0) -> Plan:
    """A map of the room, with a wall and a cylinder far off if so wanted."""
    ghosts: list[Wall | Cylinder] = [wall([far, 0.0], [far, 1.0]), cylinder([far, far], 0.1)] if far else []
    return Plan(feature_map=drawn(*WALLS, *ghosts, poses=POSES), truth=ROOM)


def rooms(*groups: tuple[Exhibit, ...], names: tuple[str, ...] = ("a", "b", "c")) -> list[ET.Element]:
    """The groups of maps of a page."""
    made = Gallery(title="<Maps>", lead="a & b", rooms=tuple(zip(names, groups, strict=False)))
    found = re.findall(r'<section class="gallery">.*?</section>', gallery_html(made), re.DOTALL)
    return [ET.fromstring(each) for each in found]


def drawings(*groups: tuple[Exhibit, ...]) -> list[ET.Element]:
    return [drawing for group in rooms(*groups) for drawing in group.iter("svg")]


def faces(drawing: ET.Element) -> list[str]:
    return [each.get("d", "") for each in drawing.iter("path") if each.get("class") == "face"]


def test_a_map_that_is_far_off_does_not_make_the_others_small() -> None:
    alone = drawings((Exhibit(name="", plan=plan()),))
    beside = drawings(tuple(Exhibit(name="", plan=plan(far=far)) for far in (0.0, 0.0, 50.0)))
    assert faces(beside[0]) == faces(alone[0])


def test_every_group_has_its_own_frame() -> None:
    small = Plan(feature_map=drawn(wall([0.0, 0.0], [1.0, 0.2]), poses=POSES))
    first, second = drawings((Exhibit(name="", plan=plan()),), (Exhibit(name="", plan=small),))
    assert first.get("viewBox") != second.get("viewBox")


def test_a_group_without_any_map_has_words_only() -> None:
    (group,) = rooms((Exhibit(name="hough", words="no <luck>"),))
    assert group.find(".//svg") is None
    assert (group.findtext(".//figcaption"), group.findtext(".//figure/p")) == ("hough", "no <luck>")


def test_cells_lie_where_they_are_and_only_those_that_are_known_are_seen() -> None:
    values = np.full((30, 50), 0.5)
    values[0, 0], values[29, 49] = 1.0, 0.0
    grid = OccupancyGrid(origin_xy=np.zeros(2), resolution=0.1, values=values)
    (drawing,) = drawings((Exhibit(name="", plan=replace(plan(), grid=grid)),))
    (image,) = drawing.iter("image")
    sheet = Sheet(bounds_xy=plan().bounds_xy)
    left, top = (float(image.get(name, "nan")) for name in ("x", "y"))
    width, height = (float(image.get(name, "nan")) for name in ("width", "height"))
    assert [[left, top + height], [left + width, top]] == pytest.approx(sheet.paper([[0.0, 0.0], [5.0, 3.0]]), abs=1e-3)
    pixels = imread(BytesIO(base64.b64decode(image.get("href", "").partition(",")[2])))
    assert pixels.shape == (30, 50, 4)
    assert np.argwhere(pixels[..., 3] > 0).tolist() == [[0, 49], [29, 0]]
    assert pixels[29, 0, 3] > 0.8
    assert pixels[0, 49, 3] < 0.3


def test_points_are_thinned_out_to_keep_the_page_light() -> None:
    many = replace(plan(), echoes_xy=np.random.default_rng(0).uniform(0.0, 3.0, (4000, 2)))
    (drawing,) = drawings((Exhibit(name="", plan=many),))
    (dots,) = (each for each in drawing.iter("path") if each.get("class") == "dots")
    assert 1000 < dots.get("d", "").count("h0") <= 1500


def test_an_empty_map_is_drawn_as_what_it_is() -> None:
    empty = Plan(feature_map=FeatureMap(method="m", sweeps=np.arange(2), poses=np.array(POSES)), truth=ROOM)
    (drawing,) = drawings((Exhibit(name="", plan=empty),))
    assert faces(drawing) == []
    assert drawing.find("./g[@class='truth']/path") is not None


def test_openings_and_inferred_walls_are_drawn_in_small_too() -> None:
    (drawing,) = drawings((Exhibit(name="", plan=Plan(feature_map=gapped_map())),))
    classes = [each.get("class") for each in drawing.iter("path")]
    assert (classes.count("jamb"), classes.count("stretch"), classes.count("face inferred")) == (2, 1, 1)


def test_features_show_their_numbers_but_take_no_keyboard_focus() -> None:
    (drawing,) = drawings((Exhibit(name="", plan=plan()),))
    assert len([title for title in drawing.iter("title") if (title.text or "").lower().startswith("wall")]) == len(
        WALLS
    )
    assert not [each for each in drawing.iter() if each.get("tabindex") or each.get("id")]


def test_the_page_escapes_all_text_and_holds_the_sections() -> None:
    page = gallery_html(
        Gallery(
            title="<script>alert(1)</script>",
            lead="a & b",
            sections=(Text(title="What <this> is", paragraphs=("$title",)),),
            rooms=(("<b>", (Exhibit(name="<i>", numbers=(("<s>", "<q>"),), words="<u>"),)),),
        )
    )
    assert "<script>alert" not in page
    assert "a &amp; b" in page
    assert "What &lt;this&gt; is" in page
    assert "<p>$title</p>" in page
    for tag in ("<i>", "<b>", "<s>", "<q>", "<u>"):
        assert tag not in page
