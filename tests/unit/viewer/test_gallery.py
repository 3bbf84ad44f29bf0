"""Many maps on one page."""

import re
import xml.etree.ElementTree as ET

import numpy as np

from echoplan.model import Cylinder, FeatureMap, Table, Wall
from echoplan.viewer import Exhibit, Gallery, Plan, Text, gallery_html
from maps import ROOM, cylinder, drawn, wall

POSES = [[1.0, 1.0, 0.0], [1.0, 2.0, 3.0]]
WALLS = [wall(start, end) for start, end in ROOM.walls_xy]


def plan(*, far: float = 0.0) -> Plan:
    """A map of the room, with a wall and a cylinder far off if so wanted."""
    ghosts: list[Wall | Cylinder] = [wall([far, 0.0], [far, 1.0]), cylinder([far, far], 0.1)] if far else []
    return Plan(feature_map=drawn(*WALLS, *ghosts, poses=POSES), truth=ROOM)


def table(*rows: tuple[Exhibit, ...], names: tuple[str, ...] = ("a", "b", "c")) -> ET.Element:
    """The maps of a page as an element."""
    made = Gallery(
        title="<Maps>",
        lead="a & b",
        sections=(Table(title="Numbers", columns=("name", "value"), rows=(("x", "1"),)),),
        columns=("one", "two", "three")[: len(rows[0])],
        rows=tuple(zip(names, rows, strict=False)),
    )
    found = re.search(r'<div class="scroll gallery">(.*)</div>\n</section>', gallery_html(made), re.DOTALL)
    assert found
    return ET.fromstring(found[1])


def faces(drawing: ET.Element) -> list[str]:
    return [each.get("d", "") for each in drawing.iter("path") if each.get("class") == "face"]


def test_a_map_that_is_far_off_does_not_make_the_others_small() -> None:
    alone = table((Exhibit(caption="", plan=plan()),))
    beside = table(tuple(Exhibit(caption="", plan=plan(far=far)) for far in (0.0, 0.0, 50.0)))
    assert faces(beside.findall(".//svg")[0]) == faces(alone.findall(".//svg")[0])


def test_every_row_has_its_own_frame() -> None:
    small = Plan(feature_map=drawn(wall([0.0, 0.0], [1.0, 0.2]), poses=POSES))
    first, second = table((Exhibit(caption="", plan=plan()),), (Exhibit(caption="", plan=small),)).findall(".//svg")
    assert first.get("viewBox") != second.get("viewBox")


def test_a_row_without_any_map_has_captions_only() -> None:
    row = table((Exhibit(caption="no <luck>"),)).findall("./tbody/tr")[0]
    assert row.find(".//svg") is None
    assert row.findtext("./td/p") == "no <luck>"


def test_an_empty_map_is_drawn_as_what_it_is() -> None:
    empty = Plan(feature_map=FeatureMap(method="m", sweeps=np.arange(2), poses=np.array(POSES)), truth=ROOM)
    drawing = table((Exhibit(caption="", plan=empty),)).find(".//svg")
    assert drawing is not None
    assert faces(drawing) == []
    assert drawing.find("./g[@class='truth']/path") is not None


def test_features_tell_their_numbers_but_stop_no_keyboard() -> None:
    drawing = table((Exhibit(caption="", plan=plan()),)).find(".//svg")
    assert drawing is not None
    assert len([title for title in drawing.iter("title") if (title.text or "").lower().startswith("wall")]) == len(
        WALLS
    )
    assert not [each for each in drawing.iter() if each.get("tabindex") or each.get("id")]


def test_the_page_believes_no_text_and_holds_the_sections() -> None:
    page = gallery_html(
        Gallery(
            title="<script>alert(1)</script>",
            lead="a & b",
            sections=(Text(title="What <this> is", paragraphs=("$title",)),),
            columns=("<i>",),
            rows=(("<b>", (Exhibit(caption="<u>"),)),),
        )
    )
    assert "<script>alert" not in page
    assert "a &amp; b" in page
    assert "What &lt;this&gt; is" in page
    assert "<p>$title</p>" in page
    for tag in ("<i>", "<b>", "<u>"):
        assert tag not in page
