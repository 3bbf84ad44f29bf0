from io import BytesIO

import numpy as np
import pytest
from matplotlib import rcParams
from matplotlib._pylab_helpers import Gcf
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex
from PIL import Image

from echoplan.viewer.palette import INK
from echoplan.viewer.style import add_legend, dress, dress_map, letter, map_height, new_figure, png
from helpers.canvas import axes_of, legend, names


def labelled(axes: Axes) -> None:
    axes.plot([0, 1], [0, 1], label="seen", alpha=0.1)
    axes.plot([0, 1], [1, 0], label="_hidden")
    axes.plot([0, 1], [1, 1])


@pytest.fixture(scope="module")
def picture() -> bytes:
    figure = new_figure(width=3.0, height=1.5)
    figure.subplots().plot([0, 1], [0, 1])
    return png(figure)


def test_a_figure_has_the_requested_size_on_white() -> None:
    figure = new_figure(width=4.0, height=2.5)
    np.testing.assert_allclose(figure.get_size_inches(), [4.0, 2.5])
    assert to_hex(figure.get_facecolor()) == "#ffffff"
    assert isinstance(figure.canvas, FigureCanvasAgg)


def test_a_figure_is_as_wide_as_the_text_of_a_page_by_default() -> None:
    np.testing.assert_allclose(new_figure().get_size_inches(), [6.3, 3.4])


def test_no_figure_touches_the_global_state_of_matplotlib() -> None:
    settings, managed = dict(rcParams), dict(Gcf.figs)
    figure = new_figure()
    dress_map(figure.subplots())
    png(figure)
    assert dict(rcParams) == settings
    assert dict(Gcf.figs) == managed


def test_a_picture_is_a_png_of_200_dots_an_inch(picture: bytes) -> None:
    assert picture.startswith(b"\x89PNG\r\n\x1a\n")
    assert Image.open(BytesIO(picture)).size == (600, 300)


def test_a_picture_is_not_blank(picture: bytes) -> None:
    grey = np.asarray(Image.open(BytesIO(picture)).convert("L"))
    assert grey.max() == 255
    assert 0.001 < (grey < 200).mean() < 0.5


def test_the_same_figure_gives_the_same_bytes(picture: bytes) -> None:
    figure = new_figure(width=3.0, height=1.5)
    figure.subplots().plot([0, 1], [0, 1])
    assert png(figure) == picture


def test_a_picture_does_not_contain_what_made_it(picture: bytes) -> None:
    assert b"Software" not in picture
    assert b"atplotlib" not in picture


def test_axes_have_their_names_and_no_frame() -> None:
    axes = axes_of(lambda axes: dress(axes, x="angle (°)", y="distance (m)"))
    assert names(axes) == ("angle (°)", "distance (m)")
    shown = {side for side, spine in axes.spines.items() if spine.get_visible()}
    assert shown == {"left", "bottom"}


def test_words_are_in_the_ink_of_the_palette_and_in_a_font_that_comes_along() -> None:
    axes = axes_of(lambda axes: dress(axes, x="x", y="y"))
    for text in (axes.xaxis.label, axes.yaxis.label):
        assert text.get_color() == INK
        assert text.get_fontfamily() == ["DejaVu Sans"]


def test_maps_have_both_directions_alike_a_grid_and_metres() -> None:
    axes = axes_of(dress_map)
    assert axes.get_aspect() == 1.0
    assert names(axes) == ("x (m)", "y (m)")
    assert any(each.get_visible() for each in axes.get_xgridlines())
    assert any(each.get_visible() for each in axes.get_ygridlines())


def test_marks_of_a_map_are_few_and_round() -> None:
    axes = axes_of(dress_map)
    axes.set(xlim=(0.0, 4.3), ylim=(0.0, 2.9))
    steps = np.diff(axes.get_xticks())
    assert len(steps) <= 7
    np.testing.assert_allclose(steps, 1.0)


def test_a_panel_has_its_letter_at_its_left() -> None:
    axes = axes_of(lambda axes: letter(axes, "(a) before"))
    assert axes.get_title(loc="left") == "(a) before"
    assert axes.get_title() == ""


def test_a_legend_names_what_has_a_label_and_nothing_else() -> None:
    axes = axes_of(labelled)
    add_legend(axes)
    assert legend(axes) == ["seen"]


def test_marks_in_a_legend_are_opaque_however_faint_they_are_in_the_figure() -> None:
    axes = axes_of(labelled)
    add_legend(axes)
    found = axes.get_legend()
    assert found is not None
    assert [handle.get_alpha() for handle in found.legend_handles if handle is not None] == [1.0]
    assert axes.lines[0].get_alpha() == 0.1


def test_a_legend_above_is_over_the_axes() -> None:
    axes = axes_of(labelled)
    add_legend(axes, columns=3, where="above")
    axes.figure.draw_without_rendering()  # type: ignore[union-attr]
    found = axes.get_legend()
    assert found is not None
    assert found.get_window_extent().y0 >= axes.get_window_extent().y1


def test_where_nothing_has_a_label_there_is_no_legend() -> None:
    axes = axes_of(lambda axes: add_legend(axes, where="above"))
    assert axes.get_legend() is None


@pytest.mark.parametrize(
    ("points", "height"),
    [
        ([[0.0, 0.0], [4.0, 3.0]], 3.0),
        ([[0.0, 0.0], [4.0, 4.0], [2.0, 1.0]], 4.0),
        ([[-1.0, -1.0], [3.0, 5.0]], 6.0),
        # A corridor is neither a strip nor longer than a page.
        ([[0.0, 0.0], [100.0, 1.0]], 1.6),
        ([[0.0, 0.0], [1.0, 100.0]], 7.5),
        ([[0.0, 0.0], [0.0, 3.0]], 7.5),
        ([[1.0, 1.0]], 1.6),
    ],
)
def test_a_panel_is_as_high_as_its_map_within_reason(points: list[list[float]], height: float) -> None:
    assert map_height(np.array(points), width=4.0) == pytest.approx(height)


def test_a_panel_for_nothing_is_square() -> None:
    assert map_height(np.zeros((0, 2)), width=4.0) == 4.0
