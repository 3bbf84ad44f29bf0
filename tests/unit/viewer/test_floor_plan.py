"""Floor plans as files: to scale, the same bytes every time, and honest about their map."""

import re
import zlib
from dataclasses import replace
from io import BytesIO
from itertools import combinations

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.transforms import Bbox
from PIL import Image

from echoplan.model import FeatureMap, Quality, Verdict
from echoplan.viewer import Plan, floor_plan_pdf, floor_plan_png
from echoplan.viewer.floor_plan import floor_plan_figure
from echoplan.viewer.palette import TRUTH
from echoplan.viewer.title_block import SIGNS
from helpers import maps
from helpers.drawings import full_plan, gapped_map

FAILED = Quality(verdict=Verdict.FAILED, reasons=("Nothing fits together.",), next_step="Record again.")
SQUARE = [[[0.0, 0.0], [4.0, 0.0]], [[4.0, 0.0], [4.0, 3.0]], [[4.0, 3.0], [0.0, 3.0]], [[0.0, 3.0], [0.0, 0.0]]]


def room(quality: Quality | None = None) -> Plan:
    found = maps.drawn(*(maps.wall(*ends) for ends in SQUARE), poses=[[1.0, 1.0, 0.0]])
    return Plan(feature_map=replace(found, quality=quality))


def axes_of(plan: Plan, *, name: str = "Kitchen", date: str = "") -> Axes:
    (axes,) = floor_plan_figure(plan, name=name, date=date).axes
    return axes


def words(axes: Axes) -> list[str]:
    return [text.get_text() for text in axes.texts]


def faces(axes: Axes) -> list[float]:
    """Lengths of the thick lines on paper [mm]."""
    return sorted(
        float(np.hypot(np.diff(line.get_xdata()), np.diff(line.get_ydata()))[0])
        for line in axes.lines
        if line.get_linewidth() == 1.4
    )


def test_a_pdf_has_one_page_of_a4_without_a_date_and_the_same_bytes_every_time() -> None:
    data = floor_plan_pdf(room())
    (page,) = re.findall(rb"/MediaBox \[ ?0 0 ([\d.]+) ([\d.]+) ?\]", data)
    assert [float(each) * 25.4 / 72 for each in page] == pytest.approx([297.0, 210.0], abs=0.01)
    assert b"CreationDate" not in data
    assert floor_plan_pdf(room()) == data


def test_the_faces_on_paper_are_those_in_the_room_times_the_scale() -> None:
    axes = axes_of(room())
    assert "1:50 on A4" in words(axes)
    # The two samples of the legend are 8 mm long.
    assert faces(axes) == pytest.approx([8.0, 8.0, 60.0, 60.0, 80.0, 80.0])
    # A unit of the axes is a millimetre on paper.
    assert (np.diff(axes.get_xlim())[0], np.diff(axes.get_ylim())[0]) == (297.0, 210.0)
    assert axes.bbox.width / axes.figure.dpi * 25.4 == pytest.approx(297.0)
    assert axes.bbox.height / axes.figure.dpi * 25.4 == pytest.approx(210.0)


def test_the_strokes_in_the_pdf_are_to_scale() -> None:
    streams = re.findall(rb"stream\r?\n(.*?)\r?\nendstream", floor_plan_pdf(room()), flags=re.DOTALL)
    text = b"".join(zlib.decompress(each) for each in streams if each.startswith(b"x")).decode("latin-1")
    strokes = re.findall(r"([\d.]+) ([\d.]+) m\n([\d.]+) ([\d.]+) l", text)
    lengths = [float(np.hypot(float(x2) - float(x1), float(y2) - float(y1))) for x1, y1, x2, y2 in strokes]
    # 4 m at 1:50 are 80 mm, in points.
    assert sum(abs(length - 80.0 * 72 / 25.4) < 1e-3 for length in lengths) >= 2


def test_a_picture_is_the_same_drawing_at_200_dots_an_inch() -> None:
    data = floor_plan_png(room())
    with Image.open(BytesIO(data)) as picture:
        assert picture.size == pytest.approx((297 / 25.4 * 200, 210 / 25.4 * 200), abs=1)
    assert floor_plan_png(room()) == data


def test_the_title_block_states_name_method_scale_and_a_date_only_if_given() -> None:
    assert {"Kitchen", "by hand", "1:50 on A4", "metres", "map", "Not assessed"} <= set(words(axes_of(room())))
    assert "date" not in words(axes_of(room()))
    assert {"date", "2026-11-27"} <= set(words(axes_of(room(), date="2026-11-27")))


def test_a_map_that_is_not_good_says_so_across_the_title_block() -> None:
    warning = "Failed map: it does not show the room. Nothing fits together."
    assert warning in words(axes_of(room(FAILED)))
    good = words(axes_of(room(Quality(verdict=Verdict.GOOD))))
    assert "Good map: the echoes fit together." in good
    assert not any("Failed" in each or "Doubtful" in each for each in good)


def test_a_long_warning_ends_after_two_lines() -> None:
    long = replace(FAILED, reasons=("Walls may be missing, duplicated or in the wrong place. " * 9,))
    (warning,) = [each for each in words(axes_of(room(long))) if each.startswith("Failed map") and "\n" in each]
    assert warning.count("\n") == 1
    assert warning.endswith("\N{HORIZONTAL ELLIPSIS}")


def test_the_true_room_is_not_drawn() -> None:
    axes = axes_of(full_plan())
    assert all(to_hex(line.get_color()) != TRUTH for line in axes.lines)
    assert words(axes) == words(axes_of(replace(full_plan(), truth=None)))


def test_inferred_pieces_are_dashed_and_unobserved_stretches_dotted_and_the_legend_says_so() -> None:
    axes = axes_of(Plan(feature_map=gapped_map()))
    styles = [line.get_linestyle() for line in axes.lines]
    # One in the drawing and one in the legend: both are "--" for matplotlib, whatever the pattern.
    assert styles.count("--") == 4
    assert {"inferred, not detected", "unobserved: wall or opening", "opening, such as a door"} <= set(words(axes))
    assert not {"inferred, not detected", "unobserved: wall or opening"} & set(words(axes_of(room())))


def test_the_legend_explains_walls_of_unknown_thickness_where_there_are_some() -> None:
    faces = [maps.wall([0.0, 0.0], [4.0, 0.0]), maps.wall([4.0, -0.1], [0.0, -0.1])]
    partition = maps.drawn(*faces, poses=[[2.0, 1.0, 0.0], [2.0, -1.0, 0.0]])
    assert SIGNS["thickness"] in words(axes_of(room()))
    assert SIGNS["thickness"] not in words(axes_of(Plan(feature_map=partition)))


def test_a_corner_is_marked_where_no_wall_ends() -> None:
    found = replace(room().feature_map, corners=(maps.corner([0.0, 0.0]), maps.corner([2.0, 1.0])))
    crosses = [line for line in axes_of(Plan(feature_map=found)).lines if line.get_marker() == "x"]
    # One in the drawing and one in the legend.
    assert len(crosses) == 2


def test_an_empty_map_says_that_no_walls_were_found() -> None:
    assert "No walls found" in words(axes_of(Plan(feature_map=FeatureMap(method="joint"))))


def crowded(height: float) -> Plan:
    """A map with every sign there is, as high as given: on A4 it lies across or upright."""
    found = gapped_map()
    top = maps.wall([0.0, height], [3.0, height])
    features = (maps.corner([2.0, 1.0]), maps.corner([4.0, 1.5]))
    columns = (maps.cylinder([1.0, 2.0], 0.1), maps.cylinder([5.0, 1.0], 0.2))
    walls = (*found.walls, replace(top, endpoint_sigmas=np.array([0.1, np.nan])))
    found = replace(found, walls=walls, corners=features, cylinders=columns, quality=FAILED)
    return Plan(feature_map=found)


@pytest.mark.parametrize("height", [3.0, 9.0, 30.0])
def test_no_text_covers_another_or_leaves_the_page(height: float) -> None:
    axes = axes_of(crowded(height), name="A name of many words " * 5, date="2026-11-27")
    assert {*SIGNS.values()} <= set(words(axes))
    axes.figure.canvas.draw()
    boxes = dict[str, Bbox]()
    for number, text in enumerate(each for each in axes.texts if each.get_text()):
        # Names of cells end at the edge of their cell.
        clip = text.get_clip_box() if text.get_clip_on() else None
        seen = Bbox.intersection(text.get_window_extent(), clip or axes.bbox)
        assert seen is not None, text.get_text()
        boxes[f"{number} {text.get_text()}"] = seen
    overlapping = []
    for one, other in combinations(boxes, 2):
        common = Bbox.intersection(boxes[one], boxes[other])
        # A pixel is nothing.
        if common is not None and min(common.width, common.height) > 1.0:
            overlapping.append((one, other))
    assert overlapping == []


@pytest.mark.parametrize(
    "name", ["$x_1$ \\alpha", "\u6f22\u5b57 \U0001f3e0", "two\nlines\tand a tab", "\ud800 lone", ""]
)
def test_any_name_is_written_as_it_is_or_with_question_marks(name: str) -> None:
    assert floor_plan_pdf(room(), name=name, date=name).startswith(b"%PDF")
    assert "?" in words(axes_of(room(), name="\u6f22"))
    assert "two lines" in words(axes_of(room(), name="two\nlines"))
