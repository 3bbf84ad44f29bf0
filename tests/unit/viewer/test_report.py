"""One page that asks for nothing else, says everything, and escapes all text."""

import re
from html.parser import HTMLParser

import numpy as np
import pytest

from echoplan.evaluation import evaluate
from echoplan.io import builtin_rig, builtin_route, builtin_world
from echoplan.methods import find_method, map_sweeps, observations_of
from echoplan.model import FeatureMap, Table, Truth
from echoplan.simulation import Simulation
from echoplan.viewer import Definitions, EchoListener, Picture, Plan, Report, Text, found_in_words, report_html
from helpers.drawings import gapped_map

VOID = {"meta", "img", "input"}


class Page(HTMLParser):
    """What a page holds: its elements, and whether each was closed in its turn."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.texts: list[str] = []
        self.open: list[str] = []
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag, tag

    def handle_data(self, data: str) -> None:
        self.texts.append(data)

    def all(self, tag: str) -> list[dict[str, str | None]]:
        return [attributes for name, attributes in self.elements if name == tag]


@pytest.fixture(scope="module")
def plan() -> Plan:
    simulation = Simulation(
        world=builtin_world("paper-room"), rig=builtin_rig("rotary-array"), route=builtin_route("paper-room"), seed=1
    )
    listener = EchoListener(simulation.rig, most=500)
    mapper = find_method("mdp-fuzzy").build(simulation.rig)
    found = map_sweeps(mapper, listener.listen(simulation))
    return Plan(
        feature_map=found, truth=simulation.truth, detections=observations_of(mapper), echoes_xy=listener.points_xy
    )


@pytest.fixture(scope="module")
def page(plan: Plan) -> Page:
    return Page(report_html(Report(title="A room", plan=plan)))


def test_every_element_is_closed(page: Page) -> None:
    assert page.open == []


def test_nothing_is_fetched(plan: Plan) -> None:
    picture = Picture(name="p", title="P", caption="C", png=b"\x89PNG")
    html = report_html(Report(title="A room", plan=plan, sections=(picture,)))
    page = Page(html)
    fetched = [each[name] for _, each in page.elements for name in ("src", "href", "data", "action") if each.get(name)]
    assert [(each or "")[:5] for each in fetched] == ["data:"]
    assert not re.search(r"url\(|@import|fetch\(|XMLHttpRequest|import\(", html)
    assert not re.search(r"https?://(?!www\.w3\.org)", html)


def test_each_feature_of_the_map_has_its_row_and_its_drawing_of_one_name(page: Page, plan: Plan) -> None:
    found = plan.feature_map
    named = {"wall": found.walls, "corner": found.corners, "cylinder": found.cylinders}
    keys = {f"{kind}-{number}" for kind, features in named.items() for number in range(len(features))}
    assert {row["data-feature"] for row in page.all("tr") if "data-feature" in row} == keys
    assert keys <= {group.get("id") for group in page.all("g")}


def test_only_layers_that_are_there_can_be_switched(page: Page, plan: Plan) -> None:
    assert [box["name"] for box in page.all("input")] == ["truth", "detections", "echoes", "enlarged"]
    bare = Page(report_html(Report(title="A room", plan=Plan(feature_map=plan.feature_map))))
    assert [box["name"] for box in bare.all("input")] == ["enlarged"]
    assert Page(report_html(Report(title="None", plan=Plan(feature_map=FeatureMap(method="rcd"))))).all("input") == []


def test_the_legend_names_each_kind_of_change_that_the_map_shows(plan: Plan) -> None:
    text = report_html(Report(title="A room", plan=plan))
    assert {"gone since earlier recordings", "new since earlier recordings"} <= {*Page(text).texts}
    for kind in ("gone", "new"):
        assert f".plan:not(:has(.map .{kind})) .of-{kind}" in text
        assert f"\n.{kind} {{ stroke:" in text


def test_the_layers_that_are_shown_at_first_are_ticked(page: Page) -> None:
    ticked = {box["name"] for box in page.all("input") if "checked" in box}
    assert ticked == {"truth", "echoes"}


@pytest.mark.parametrize("text", ["<script>alert(1)</script>", 'a "b" & <c>', "$title ${map}"])
def test_no_text_becomes_markup(plan: Plan, text: str) -> None:
    sections = (
        Text(title=text, paragraphs=(text,)),
        Definitions(title=text, items=((text, text),), folded=True),
        Table(title=text, columns=(text,), rows=((text,),)),
        Picture(name="p", title=text, caption=text, png=b""),
    )
    page = Page(report_html(Report(title=text, plan=plan, sections=sections)))
    assert page.open == []
    assert len(page.all("script")) == 1
    assert sum(part == text for part in page.texts) == 12


def test_numbers_are_aligned_right_and_words_left() -> None:
    table = Table(title="T", columns=("name", "size", "change"), rows=(("one", "1.5", "-2"), ("two", "", "+3")))
    page = Page(report_html(Report(title="R", plan=Plan(feature_map=FeatureMap(method="m")), sections=(table,))))
    assert [head.get("class") for head in page.all("th") if head["scope"] == "col"] == [None, "number", "number"]
    assert [cell.get("class") for cell in page.all("td")] == ["number"] * 4


def test_long_settings_are_folded_and_short_ones_lie_open() -> None:
    folded = Definitions(title="F", items=(("alpha", "71"), ("beta", "72")), folded=True)
    lying_open = Definitions(title="O", items=(("gamma", "73"),))
    empty = Plan(feature_map=FeatureMap(method="m"))
    page = Page(report_html(Report(title="R", plan=empty, sections=(folded, lying_open))))
    assert len(page.all("details")) == 1
    assert [page.texts.count(each) for each in ("alpha", "beta", "gamma", "71", "72", "73")] == [1] * 6


def test_a_picture_is_embedded_and_described_for_those_who_cannot_see_it() -> None:
    picture = Picture(name="p", title="P", caption="A wall at 1 m.", png=b"png")
    empty = Plan(feature_map=FeatureMap(method="m"))
    (image,) = Page(report_html(Report(title="R", plan=empty, sections=(picture,)))).all("img")
    assert image["src"] == "data:image/png;base64,cG5n"
    assert image["alt"] == "A wall at 1 m."


def test_a_map_is_summed_up_in_a_sentence(plan: Plan) -> None:
    counts = [len(each) for each in (plan.feature_map.walls, plan.feature_map.corners, plan.feature_map.cylinders)]
    assert [int(each) for each in re.findall(r"\d+", found_in_words(plan.feature_map))] == [*counts, 10]


def test_openings_have_a_row_and_a_drawing_of_one_name() -> None:
    page = Page(report_html(Report(title="A floor", plan=Plan(feature_map=gapped_map()))))
    assert {"opening-0", "opening-1"} <= {row.get("data-feature") for row in page.all("tr")}
    assert {"opening-0", "opening-1", "unobserved-stretch-0"} <= {group.get("id") for group in page.all("g")}
    assert page.texts.count("Openings") == 1


def test_the_sum_of_a_map_names_what_was_not_observed() -> None:
    assert found_in_words(gapped_map()) == (
        "4 walls, 2 openings, 0 corners and 0 cylinders, detected from 5 stations. "
        "0.50 m of wall inferred up to undetected corners; 0.50 m between walls not observed."
    )


def test_the_map_of_a_room_without_features_is_still_a_page() -> None:
    truth = Truth(walls_xy=np.array([[[0.0, 0.0], [1.0, 0.0]]]), walls_detected_by=np.array([0]))
    plan = Plan(feature_map=FeatureMap(method="m"), truth=truth)
    assert not evaluate(plan.feature_map, truth).matches.walls.right
    page = Page(report_html(Report(title="Nothing", plan=plan)))
    assert page.all("table") == []
    assert len(page.all("svg")) >= 1
