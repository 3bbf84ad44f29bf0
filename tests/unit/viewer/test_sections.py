import dataclasses

import pytest

from echoplan.viewer.sections import Definitions, Picture, Text, flattened


def test_settings_without_nesting_keep_their_names_and_their_order() -> None:
    assert flattened({"b": 1, "a": 2.5}) == (("b", "1"), ("a", "2.5"))


def test_nested_settings_get_dotted_names_however_deep() -> None:
    settings = {"filter": {"seed": 0, "inner": {"deep": "x"}}, "jump": 0.02}
    assert flattened(settings) == (("filter.seed", "0"), ("filter.inner.deep", "x"), ("jump", "0.02"))


def test_what_is_none_is_not_set() -> None:
    assert flattened({"fuzzy": {"max_width": None}}) == (("fuzzy.max_width", "not set"),)


@pytest.mark.parametrize(("value", "text"), [(0, "0"), (False, "False"), ("", ""), (0.0, "0.0"), ([], "[]")])
def test_what_is_false_is_set_all_the_same(value: object, text: str) -> None:
    assert flattened({"name": value}) == (("name", text),)


def test_lists_stay_in_one_piece() -> None:
    assert flattened({"radii": [0.04, 0.08]}) == (("radii", "[0.04, 0.08]"),)


def test_no_settings_give_no_items() -> None:
    assert flattened({}) == ()
    assert flattened({"stage": {}}) == ()


def test_definitions_are_open_by_default() -> None:
    assert not Definitions(title="Settings", items=()).folded
    assert Definitions(title="Settings", items=(), folded=True).folded


def test_sections_of_the_same_content_are_equal() -> None:
    assert Text(title="a", paragraphs=("b",)) == Text(title="a", paragraphs=("b",))
    assert Text(title="a", paragraphs=("b",)) != Text(title="a", paragraphs=("c",))


def test_sections_do_not_change() -> None:
    picture = Picture(name="figure", title="A figure", caption="What it shows", png=b"")
    with pytest.raises(dataclasses.FrozenInstanceError):
        picture.title = "Another"  # type: ignore[misc]
