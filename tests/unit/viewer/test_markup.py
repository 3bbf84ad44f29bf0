import xml.etree.ElementTree as ET

import numpy as np
import pytest

from echoplan.viewer.markup import coordinates, element, path, size

HOSTILE = [
    "<script>alert(1)</script>",
    "a & b",
    "]]>",
    '"quoted"',
    "it's",
    "&amp;",
    "<!-- -->",
    "Grundriß \N{GREEK SMALL LETTER SIGMA} °",
]
FORBIDDEN = ["\x00", "\x08", "\x0b", "\x0c", "\x1f", "\ud800", "\udfff", "\ufffe", "\uffff"]


def read(made: ET.Element) -> ET.Element:
    """An element as a program reads what was written."""
    return ET.fromstring(ET.tostring(made, encoding="utf-8"))


def test_an_element_has_its_name_its_text_and_its_children_in_their_order() -> None:
    made = element("g", element("path"), element("circle"), text="words")
    assert ET.tostring(made) == b"<g>words<path /><circle /></g>"


def test_attributes_whose_names_python_keeps_for_itself_end_with_an_underscore() -> None:
    assert element("path", class_="wall", for_="box").attrib == {"class": "wall", "for": "box"}


def test_underscores_within_a_name_become_dashes() -> None:
    assert element("g", data_sweep="1", text_anchor="middle").attrib == {"data-sweep": "1", "text-anchor": "middle"}


def test_names_of_mixed_case_stay_as_they_are() -> None:
    assert element("svg", viewBox="0 0 1 1").attrib == {"viewBox": "0 0 1 1"}


def test_no_text_is_not_an_empty_text() -> None:
    assert element("g").text is None
    assert ET.tostring(element("g")) == b"<g />"


@pytest.mark.parametrize("text", HOSTILE)
def test_text_comes_back_as_it_was_and_never_as_markup(text: str) -> None:
    found = read(element("title", text=text, data_name=text))
    assert found.text == text
    assert found.attrib == {"data-name": text}
    assert len(found) == 0


@pytest.mark.parametrize("character", FORBIDDEN)
def test_characters_that_no_document_may_hold_are_replaced(character: str) -> None:
    found = read(element("title", text=f"a{character}b", data_name=f"a{character}b"))
    assert found.text == "a\ufffdb"
    assert found.attrib == {"data-name": "a\ufffdb"}


@pytest.mark.parametrize("character", ["\t", "\n", " ", "~", "\x7f", "\ud7ff", "\ue000", "\ufffd", "\U00010000", "🦇"])
def test_characters_that_a_document_may_hold_stay(character: str) -> None:
    text = f"a{character}b"
    assert element("title", text=text).text == text
    assert read(element("title", text=text)).text == text


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (-0.0, "0"),
        (-0.00004, "0"),
        (0.00006, "0.0001"),
        (100.0, "100"),
        (1200, "1200"),
        (12.50, "12.5"),
        (-3.14159, "-3.1416"),
        (1e6, "1000000"),
        (np.float64(0.1), "0.1"),
    ],
)
def test_a_number_is_written_to_a_ten_thousandth_without_needless_zeros(value: float, text: str) -> None:
    assert size(value) == text


def test_a_point_is_two_numbers_whatever_it_is_made_of() -> None:
    assert coordinates((1, 2)) == "1 2"
    assert coordinates(np.array([-0.00001, 7.25])) == "0 7.25"


def test_an_open_stroke_ends_where_it_ends() -> None:
    assert path([[[0.0, 0.0], [1.0, 0.0], [1.0, 2.5]]]) == "M0 0L1 0L1 2.5"


def test_a_closed_stroke_returns_to_its_start() -> None:
    assert path([[[0, 0], [1, 0], [1, 1]]], closed=True) == "M0 0L1 0L1 1Z"


def test_each_of_many_strokes_is_closed() -> None:
    assert path(np.zeros((2, 2, 2)), closed=True) == "M0 0L0 0ZM0 0L0 0Z"


def test_no_strokes_are_no_path() -> None:
    assert path([]) == ""
    assert path(np.zeros((0, 2, 2))) == ""


def test_strokes_may_differ_in_length() -> None:
    assert path([np.array([[0.0, 0.0]]), np.array([[1.0, 1.0], [2.0, 2.0]])]) == "M0 0M1 1L2 2"
