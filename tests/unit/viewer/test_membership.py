import numpy as np
import pytest
from matplotlib.axes import Axes

from echoplan.classical.fuzzy import CROSSINGS, memberships
from echoplan.model import FeatureClass
from echoplan.viewer.membership import draw_memberships
from echoplan.viewer.palette import COLORS
from helpers.canvas import axes_of, color, data, legend, line, names, notes

STATES = {
    "small: corner": FeatureClass.CORNER,
    "medium: cylinder": FeatureClass.CYLINDER,
    "big: flat": FeatureClass.WALL,
}


@pytest.fixture(scope="module")
def axes() -> Axes:
    return axes_of(draw_memberships)


def test_both_axes_are_shares(axes: Axes) -> None:
    assert names(axes) == ("width of the cluster (1)", "membership (1)")
    assert axes.get_xlim() == (0.0, 1.0)
    low, high = axes.get_ylim()
    assert low == 0.0
    assert high > 1.0


def test_each_state_is_explained_with_the_class_it_speaks_for(axes: Axes) -> None:
    assert legend(axes) == list(STATES)


@pytest.mark.parametrize("number", range(3))
def test_each_curve_is_the_membership_over_all_widths(axes: Axes, number: int) -> None:
    curve = data(line(axes, list(STATES)[number]))
    assert curve[0, 0] == 0.0
    assert curve[-1, 0] == 1.0
    np.testing.assert_allclose(curve[:, 1], memberships(curve[:, 0])[:, number])


@pytest.mark.parametrize("label", STATES)
def test_curves_have_the_colours_of_their_classes(axes: Axes, label: str) -> None:
    assert color(line(axes, label)) == COLORS[STATES[label]]


def test_curves_differ_in_their_dashes_too(axes: Axes) -> None:
    assert len({line(axes, label).get_linestyle() for label in STATES}) == 3


def test_small_falls_big_rises_and_medium_has_its_peak_at_its_own_width(axes: Axes) -> None:
    small, medium, big = (data(line(axes, label)) for label in STATES)
    assert (np.diff(small[:, 1]) <= 0).all()
    assert (np.diff(big[:, 1]) >= 0).all()
    assert medium[medium[:, 1].argmax(), 0] == pytest.approx(0.55)


def test_the_widths_at_which_the_class_changes_are_marked_and_labelled(axes: Axes) -> None:
    assert [note.get_text() for note in notes(axes)] == ["$L_1$ = 0.4109", "$L_2$ = 0.6614"]
    np.testing.assert_allclose([note.xy for note in notes(axes)], [[each, 0.0] for each in CROSSINGS])


def test_marks_lie_where_two_curves_cross_above_the_third(axes: Axes) -> None:
    crossings = np.concatenate([data(each) for each in axes.lines if each.get_marker() == "o"])
    np.testing.assert_allclose(crossings[:, 0], CROSSINGS)
    for (width, height), pair in zip(crossings, ((0, 1), (1, 2)), strict=True):
        degrees = memberships(width)
        np.testing.assert_allclose(degrees[list(pair)], height)
        assert height == pytest.approx(degrees.max())


def test_a_line_falls_from_each_crossing_to_its_width(axes: Axes) -> None:
    segments = [np.array(path.vertices, dtype=np.float64) for each in axes.collections for path in each.get_paths()]
    assert len(segments) == 2
    for segment, crossing in zip(segments, CROSSINGS, strict=True):
        np.testing.assert_allclose(segment, [[crossing, 0.0], [crossing, memberships(crossing).max()]])


def test_the_widths_of_the_states_are_named_on_their_axis(axes: Axes) -> None:
    np.testing.assert_allclose(axes.get_xticks(), [0.0, 0.15, 0.55, 0.9, 1.0])
    assert [each.get_text() for each in axes.get_xticklabels()] == [
        "0.00\n",
        "0.15\n$L_s$",
        "0.55\n$L_m$",
        "0.90\n$L_b$",
        "1.00\n$L_{max}$",
    ]
