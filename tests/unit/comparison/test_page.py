"""One page with all maps side by side that asks for nothing else and escapes all text."""

import re
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np

from echoplan.comparison import comparison_page, score_methods
from echoplan.model import OccupancyGrid
from helpers.outcomes import some

PAGE = comparison_page(score_methods(some(), ["good", "poor"]))


def rooms(page: str) -> list[ET.Element]:
    return [ET.fromstring(each) for each in re.findall(r'<section class="gallery">.*?</section>', page, re.DOTALL)]


def test_there_is_a_group_for_each_recording_and_in_it_a_map_for_each_method() -> None:
    groups = rooms(PAGE)
    assert [group.findtext("h2") for group in groups] == ["sim:room", "rec/<two>"]
    for group in groups:
        assert [each.text for each in group.iter("figcaption")] == ["good", "poor"]


def test_every_map_lies_over_the_truth() -> None:
    drawings = [drawing for group in rooms(PAGE) for drawing in group.iter("svg")]
    assert len(drawings) == 3
    for drawing in drawings:
        layers = [layer.get("class") for layer in drawing.findall("g")]
        assert layers.index("truth") < layers.index("walls")
        assert drawing.find("./g[@class='truth']/path") is not None


def test_all_maps_of_a_group_have_one_frame() -> None:
    assert len({drawing.get("viewBox") for drawing in rooms(PAGE)[0].iter("svg")}) == 1


def test_numbers_are_below_each_map() -> None:
    good, poor = (figure.findall("dl/div") for figure in rooms(PAGE)[0].iter("figure"))
    shown = [{pair.findtext("dt"): pair.findtext("dd") for pair in pairs} for pairs in (good, poor)]
    assert [each["walls"] for each in shown] == ["5 of 5", "3 of 5"]
    assert [each["extra walls"] for each in shown] == ["0", "0"]
    assert [each["time"] for each in shown] == ["0.36 s", "0.72 s"]


def test_points_and_cells_of_which_a_map_was_made_lie_beneath_it() -> None:
    cells = OccupancyGrid(origin_xy=np.zeros(2), resolution=0.5, values=np.full((6, 10), 0.9))
    outcomes = [replace(each, points_xy=np.ones((7, 2)), grid=cells) for each in some()[:1]]
    (group,) = rooms(comparison_page(score_methods(outcomes, ["good"])))
    assert [dots.get("d", "").count("h0") for dots in group.iter("path") if dots.get("class") == "dots"] == [7]
    assert len(list(group.iter("image"))) == 1


def test_a_failure_is_shown_in_the_place_of_the_map() -> None:
    figure = list(rooms(PAGE)[1].iter("figure"))[1]
    assert figure.findtext("p") == "failed: ValueError: no <walls>"
    assert figure.find("svg") is None


def test_the_numbers_of_all_come_below_the_maps() -> None:
    assert PAGE.index('class="gallery"') < PAGE.index("Methods on the same recordings") < PAGE.index("What failed")


def test_names_of_elements_occur_but_once() -> None:
    names = re.findall(r'\sid="([^"]*)"', PAGE)
    assert len(names) == len(set(names))


def test_the_page_asks_for_no_other_file() -> None:
    assert not re.search(r'(?:src|href)\s*=\s*"?(?!data:)|@import|url\(|https?:', PAGE)


def test_without_truth_the_maps_are_shown_all_the_same() -> None:
    page = comparison_page(score_methods(some(truth=None), ["good", "poor"]))
    assert sum(len(list(group.iter("svg"))) for group in rooms(page)) == 3
    assert "map error" not in page
    assert "<dt>walls</dt>" not in page
