"""One page with all maps side by side that asks for nothing else and believes no text."""

import re
import xml.etree.ElementTree as ET

from echoplan.comparison import comparison_page, score_methods
from outcomes import some

PAGE = comparison_page(score_methods(some(), ["good", "poor"]))


def gallery(page: str) -> ET.Element:
    found = re.search(r'<div class="scroll gallery">.*?</table></div>', page, re.DOTALL)
    assert found
    return ET.fromstring(found[0])


def test_there_is_a_row_for_each_recording_and_a_column_for_each_method() -> None:
    table = gallery(PAGE)
    assert [head.text for head in table.findall(".//thead//th")] == ["good", "poor"]
    assert [row.findtext("th") for row in table.findall(".//tbody/tr")] == ["sim:room", "rec/<two>"]


def test_every_map_lies_over_the_truth() -> None:
    drawings = gallery(PAGE).findall(".//svg")
    assert len(drawings) == 3
    assert all(drawing.find("./g[@class='truth']/path") is not None for drawing in drawings)


def test_all_maps_of_a_row_have_one_frame() -> None:
    first, _ = gallery(PAGE).findall(".//tbody/tr")
    assert len({drawing.get("viewBox") for drawing in first.iter("svg")}) == 1


def test_a_failure_stands_in_the_place_of_the_map() -> None:
    cell = gallery(PAGE).findall(".//tbody/tr")[1].findall("td")[1]
    assert cell.findtext("p") == "failed: ValueError: no <walls>"
    assert cell.find("svg") is None


def test_names_of_elements_occur_but_once() -> None:
    names = re.findall(r'\sid="([^"]*)"', PAGE)
    assert len(names) == len(set(names))


def test_the_page_asks_for_no_other_file() -> None:
    assert not re.search(r'(?:src|href)\s*=\s*"?(?!data:)|@import|url\(|https?:', PAGE)


def test_without_truth_the_maps_are_shown_all_the_same() -> None:
    page = comparison_page(score_methods(some(truth=None), ["good", "poor"]))
    assert len(gallery(page).findall(".//svg")) == 3
    assert "map error" not in page
