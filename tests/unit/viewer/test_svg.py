import re
import xml.etree.ElementTree as ET
from collections import Counter
from dataclasses import replace
from importlib.resources import files

import numpy as np
import pytest

from echoplan.model import Changes, Cylinder, FeatureMap, Quality, Verdict
from echoplan.viewer.plan import Plan
from echoplan.viewer.svg import plan_element, plan_svg
from helpers.drawings import SVG, full_plan, gapped_map, marked, stroke, strokes, the, titles, view_box
from helpers.maps import corner, drawn, wall

LAYERS = [
    "grid",
    "echoes",
    "detections",
    "walls",
    "gaps",
    "changes",
    "truth",
    "cylinders",
    "corners",
    "stations",
    "legend",
]
CHANGES = Changes(
    recording="tuesday",
    gone_walls=(np.array([[1.0, 1.0], [2.0, 1.0]]),),
    new_walls=(np.array([[1.0, 2.0], [2.0, 2.0]]),),
    new_cylinders=(Cylinder(center_xy=np.array([1.5, 1.5]), radius=0.1, covariance=1e-6 * np.eye(3)),),
)
NOTHING = Plan(feature_map=FeatureMap(method="none"))


@pytest.fixture(scope="module")
def drawing() -> ET.Element:
    return plan_element(full_plan())


@pytest.fixture(scope="module")
def document() -> ET.Element:
    """The file as a program reads it."""
    return ET.fromstring(plan_svg(full_plan()))


def layer(drawing: ET.Element, name: str) -> ET.Element:
    return next(each for each in drawing if each.get("class") == name)


def corridor(length: float) -> Plan:
    """A wall along y."""
    return Plan(feature_map=drawn(wall([0.0, 0.0], [0.0, length])))


def test_layers_lie_over_each_other_from_the_grid_to_the_legend(drawing: ET.Element) -> None:
    assert [each.get("class") for each in drawing if each.tag == "g"] == LAYERS


def test_a_layer_without_marks_is_still_there() -> None:
    bare = plan_element(NOTHING)
    assert [each.get("class") for each in bare if each.tag == "g"] == LAYERS
    for name in ("walls", "gaps", "changes", "truth", "cylinders", "corners"):
        assert len(layer(bare, name)) == 0


def test_a_drawing_names_its_method_first(drawing: ET.Element) -> None:
    assert drawing[0].tag == "title"
    assert drawing[0].text == "Map made by by hand"


def test_everything_is_in_its_layer_once(drawing: ET.Element) -> None:
    assert len(layer(drawing, "walls")) == 6
    assert len(layer(drawing, "corners")) == 2
    assert len(layer(drawing, "cylinders")) == 1
    assert len(marked(layer(drawing, "stations"), "feature")) == 3
    assert len(marked(layer(drawing, "detections"), "beam")) == 2
    assert len(marked(layer(drawing, "truth"), "true")) == 3


def test_no_name_occurs_twice(drawing: ET.Element) -> None:
    names = [each.attrib["id"] for each in drawing.iter() if "id" in each.attrib]
    assert len(names) == 6 + 2 + 1 + 3
    assert Counter(names).most_common(1)[0][1] == 1


def test_every_feature_has_one_title(drawing: ET.Element) -> None:
    for each in marked(drawing, "feature"):
        assert len(list(titles(each))) == 1


def test_a_drawing_states_its_scale_and_where_the_origin_lies(drawing: ET.Element) -> None:
    # Five metres by three: at 1 : 50 a metre is 20 mm.  100 mm and two borders are wide enough for the legend.
    assert drawing.attrib["data-scale"] == "50"
    assert drawing.attrib["data-origin"] == "10 70"
    np.testing.assert_allclose(view_box(drawing), [0, 0, 120, 92])


def test_the_paper_is_as_great_as_the_drawing(drawing: ET.Element) -> None:
    rectangle = the(drawing, "paper")
    assert rectangle.tag == "rect"
    assert (rectangle.attrib["width"], rectangle.attrib["height"]) == ("120", "92")


def test_a_wall_lies_where_the_scale_and_the_origin_put_it(drawing: ET.Element) -> None:
    face = the(layer(drawing, "walls")[1], "face")
    np.testing.assert_allclose(stroke(face), [[10 + 5 * 20, 70.0], [10 + 5 * 20, 70 - 1.5 * 20]])


def test_lines_of_the_grid_run_right_across_the_map_at_round_coordinates(drawing: ET.Element) -> None:
    lines = strokes(the(layer(drawing, "grid"), "line"))
    upright = [line for line in lines if line[0, 0] == line[1, 0]]
    level = [line for line in lines if line[0, 1] == line[1, 1]]
    np.testing.assert_allclose([line[:, 0] for line in upright], [[10 + 40 * each] * 2 for each in (0, 1, 2)])
    np.testing.assert_allclose([line[:, 1] for line in level], [[70 - 40 * each] * 2 for each in (0, 1)])
    np.testing.assert_allclose([sorted(line[:, 1]) for line in upright], [[10, 70]] * 3)
    np.testing.assert_allclose([sorted(line[:, 0]) for line in level], [[10, 110]] * 2)


def test_lines_of_the_grid_have_their_coordinates_at_the_edges(drawing: ET.Element) -> None:
    texts = [each for each in layer(drawing, "grid") if each.tag == "text"]
    below, beside = ([each for each in texts if each.attrib["text-anchor"] == anchor] for anchor in ("middle", "end"))
    assert [each.text for each in below] == ["0", "2", "4"]
    assert [each.text for each in beside] == ["0", "2"]
    np.testing.assert_allclose([float(each.attrib["x"]) for each in below], [10, 50, 90])
    assert all(float(each.attrib["y"]) > 70 for each in below)
    assert all(float(each.attrib["x"]) < 10 for each in beside)


def test_coordinates_of_the_grid_are_written_without_rounding_errors() -> None:
    labels = [each.text for each in layer(plan_element(Plan(feature_map=drawn(corner([-0.7, 0.3])))), "grid")]
    assert labels[1:] == ["-1", "-0.5", "0", "0.5"]


def test_the_scale_bar_is_one_step_of_the_grid_and_half_of_it_is_light(drawing: ET.Element) -> None:
    whole, half = marked(layer(drawing, "legend"), "bar")
    (left, base), (right, level) = stroke(whole)
    assert (right - left, level) == (40, base)
    np.testing.assert_allclose(stroke(half), [[left + 20, base], [right, base]])
    assert half.attrib["class"] == "bar half"


def test_the_legend_shows_the_length_of_its_bar_the_scale_and_the_axes(drawing: ET.Element) -> None:
    assert [each.text for each in layer(drawing, "legend") if each.tag == "text"] == ["2 m", "1 : 50", "x", "y"]


def test_arrows_point_to_the_right_and_up(drawing: ET.Element) -> None:
    along, _, up, _ = strokes(the(layer(drawing, "legend"), "axes"))
    np.testing.assert_allclose(along[1] - along[0], [6, 0])
    np.testing.assert_allclose(up[1] - up[0], [0, -6])


def test_arrows_have_heads_at_their_tips(drawing: ET.Element) -> None:
    for shaft, head in zip(*[iter(strokes(the(layer(drawing, "legend"), "axes")))] * 2, strict=True):
        np.testing.assert_allclose(head[1], shaft[1])
        np.testing.assert_allclose(np.hypot(*(head[[0, 2]] - shaft[1]).T), np.hypot(1.6, 0.8))


def test_the_legend_lies_below_the_map(drawing: ET.Element) -> None:
    points = np.concatenate([each for made in layer(drawing, "legend") if "d" in made.attrib for each in strokes(made)])
    assert points[:, 1].min() > 70
    assert points[:, 1].max() < 92


@pytest.mark.parametrize("length", [1.0, 2.4, 5.0, 20.0, 24.5, 100.0, 240.0, 2000.0])
def test_the_legend_of_a_corridor_stays_on_its_paper(length: float) -> None:
    made = plan_element(corridor(length))
    _, _, width, height = view_box(made)
    legend = layer(made, "legend")
    points = np.concatenate([each for one in legend if "d" in one.attrib for each in strokes(one)])
    assert points[:, 0].min() >= 0
    assert points[:, 0].max() <= width
    assert points[:, 1].max() <= height
    # Letters of this font are about 0.6 of their height of 3 mm.
    ends = {each.text or "": float(each.attrib["x"]) + 1.9 * len(each.text or "") for each in legend if each.text}
    scale = next(text for text in ends if text.startswith("1 :"))
    assert ends[scale] < points[points[:, 0] > 60][:, 0].min()


def test_a_narrow_map_lies_in_the_middle_of_its_paper() -> None:
    made = plan_element(corridor(20.0))
    assert view_box(made)[2] == 110
    np.testing.assert_allclose(stroke(the(made, "face"))[:, 0], 55)
    assert made.attrib["data-origin"].split()[0] == "55"


@pytest.mark.parametrize("degrees", [20, 28, 32, 38, 42, 60])
def test_the_mitre_of_a_sharp_corner_stays_on_its_paper(degrees: float) -> None:
    # As high as a page allows, so that walls are at their thickest.
    reach = 2.45 * np.tan(np.radians(degrees) / 2)
    sides = [wall([0.0, 0.0], [side * reach, 2.45]) for side in (-1, 1)]
    made = plan_element(Plan(feature_map=drawn(*sides, poses=[[0.0, 1.0, 0.0]])))
    _, _, width, height = view_box(made)
    points = np.concatenate([stroke(each) for each in marked(made, "body")])
    assert (points >= 0).all()
    assert (points <= [width, height]).all()
    # The paper ends 10 mm and a foot of 12 mm below the corner, which the legend has for itself.
    assert points[:, 1].max() <= height - 12


def test_detections_and_echoes_are_cut_off_at_the_edge_of_the_map(drawing: ET.Element) -> None:
    for name in ("echoes", "detections"):
        (window,) = layer(drawing, name)
        assert window.tag == "svg"
        assert window.attrib["overflow"] == "hidden"
        np.testing.assert_allclose(view_box(window), [0, 0, 120, 92 - 16])
        # Its unit stays the millimetre.
        assert (window.attrib["width"], window.attrib["height"]) == ("120", "76")


def test_a_file_is_an_svg_of_its_own_printed_to_scale(document: ET.Element) -> None:
    assert document.tag == f"{SVG}svg"
    _, _, width, height = view_box(document)
    assert document.attrib["width"] == f"{width:g}mm"
    assert document.attrib["height"] == f"{height:g}mm"


def test_a_narrow_file_is_as_wide_as_its_view() -> None:
    made = ET.fromstring(plan_svg(corridor(20.0)))
    assert made.attrib["width"] == "110mm"
    assert view_box(made)[2] == 110


def test_a_file_carries_its_own_style_and_asks_for_no_other(document: ET.Element) -> None:
    style = document[1]
    assert style.tag == f"{SVG}style"
    assert style.text == files("echoplan.viewer").joinpath("map.css").read_text(encoding="utf-8")
    text = plan_svg(full_plan())
    assert "href" not in text
    assert not re.search(r"url\(|@import|<script", text)


def test_a_file_holds_the_same_drawing_as_a_page(document: ET.Element, drawing: ET.Element) -> None:
    within = [each for each in document.iter() if each.tag != f"{SVG}style"]
    assert [each.tag for each in within] == [f"{SVG}{each.tag}" for each in drawing.iter()]
    assert [each.attrib for each in within[1:]] == [each.attrib for each in list(drawing.iter())[1:]]


def test_a_file_is_made_of_elements_that_every_program_draws(document: ET.Element) -> None:
    known = {"svg", "title", "style", "rect", "g", "path", "circle", "ellipse", "text"}
    assert {each.tag.removeprefix(SVG) for each in document.iter()} == known


def test_a_file_ends_its_last_line() -> None:
    assert plan_svg(NOTHING).endswith("</svg>\n")


def test_the_style_has_rules_only_for_what_is_drawn(document: ET.Element) -> None:
    gaps = plan_element(Plan(feature_map=replace(gapped_map(), changes=(CHANGES,))))
    failed = plan_element(Plan(feature_map=replace(gapped_map(), quality=Quality(verdict=Verdict.FAILED))))
    used = {name for each in (*document.iter(), *gaps.iter(), *failed.iter()) for name in each.get("class", "").split()}
    rules = re.sub(r"/\*.*?\*/|{.*?}", " ", document[1].text or "", flags=re.DOTALL)
    assert set(re.findall(r"\.([a-z]+)", rules)) <= used


def test_what_is_gone_and_what_is_new_are_drawn_with_their_names() -> None:
    gone, new = layer(plan_element(Plan(feature_map=FeatureMap(method="joint", changes=(CHANGES,)))), "changes")
    assert [each.get("class") for each in (gone, new)] == ["gone", "new"]
    assert list(titles(gone)) == ["gone"]
    # A wall and the circle of a cylinder.
    assert ((gone.get("d") or "").count("M"), (new.get("d") or "").count("M")) == (1, 2)


def test_the_paths_of_two_recordings_are_not_joined() -> None:
    poses = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0], [4.0, 0.0, 0.0]]
    found = replace(drawn(poses=poses), changes=(Changes(first_sweep=2),))
    (way,) = [each for each in plan_element(Plan(feature_map=found)).iter() if each.get("class") == "way"]
    assert ((way.get("d") or "").count("M"), (way.get("d") or "").count("L")) == (2, 2)


def test_titles_keep_their_lines(document: ET.Element) -> None:
    title = next(text for text in titles(document) if text.startswith("wall 0"))
    assert "\nlength: 5.000 m\n" in title


@pytest.mark.parametrize("method", ["<script>alert(1)</script>", "a & b", "]]>", "\x00\x0b\ud800", '"><svg onload="'])
def test_no_name_of_a_method_becomes_markup_or_spoils_the_file(method: str) -> None:
    plain = ET.fromstring(plan_svg(NOTHING))
    made = ET.fromstring(plan_svg(replace(NOTHING, feature_map=FeatureMap(method=method))).encode())
    assert [each.tag for each in made.iter()] == [each.tag for each in plain.iter()]
    assert next(titles(made)) == "Map made by " + re.sub("[\x00\x0b\ud800]", "\ufffd", method)


def test_an_empty_map_is_a_square_metre_of_grid() -> None:
    made = plan_element(NOTHING)
    assert made.attrib["data-scale"] == "10"
    np.testing.assert_allclose(view_box(made), [0, 0, 120, 132])
    assert len(strokes(the(layer(made, "grid"), "line"))) == 6


def test_a_map_of_one_corner_shows_it_in_the_middle() -> None:
    made = plan_element(Plan(feature_map=drawn(corner([7.25, -3.25]))))
    transform = next(each.attrib["transform"] for each in marked(made, "corner")[0] if "transform" in each.attrib)
    assert transform.startswith("translate(60 60)")


def test_a_thousand_stations_make_a_file_of_modest_size() -> None:
    turn = np.linspace(0, 20 * np.pi, 1000)
    poses = np.column_stack([2 * np.cos(turn), 2 * np.sin(turn), turn])
    text = plan_svg(Plan(feature_map=drawn(poses=poses)))
    assert len(text) < 1_000_000
    names = [each.attrib["id"] for each in ET.fromstring(text).iter() if "id" in each.attrib]
    assert len(set(names)) == len(names) == 1000
