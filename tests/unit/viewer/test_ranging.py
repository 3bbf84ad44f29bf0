import numpy as np
import pytest
from matplotlib.axes import Axes

from echoplan.extraction import Parabola
from echoplan.model import FeatureClass
from echoplan.viewer.palette import COLORS
from echoplan.viewer.ranging import draw_fit, draw_range_errors, draw_ranges
from echoplan.viewer.stages import Fitted, WallProfile
from helpers.canvas import axes_of, color, data, legend, line, names, notes
from helpers.scenes import around, cluster, observed

PROFILE = WallProfile(
    angles=np.radians([-20.0, 0.0, 30.0]),
    measured=np.array([1.012, 1.001, 1.03]),
    compensated=np.array([1.002, 1.001, 0.998]),
    distance=1.0,
)
MEASURED, COMPENSATED = "measured", "after compensation (Eq. 1)"


def fitted(bearing: float, distance: float) -> Fitted:
    """A parabola about a bearing, and echoes that lie a millimetre above it."""
    bearings = around(bearing, 0.3)
    return Fitted(
        cluster=cluster(bearings, np.full(len(bearings), distance)),
        point=observed((0.0, 0.0), bearing=bearing, distance=distance, degrees=(0.0, 0.0, 1.0)).point,
        distances=distance + 0.5 * (bearings - bearing) ** 2 + 0.001,
        parabola=Parabola(
            # Its centre is not its minimum.
            center=bearing - 0.1,
            coefficients=np.array([distance + 0.005, -0.1, 0.5]),
            covariance=np.eye(3),
        ),
    )


@pytest.fixture(scope="module")
def ranges() -> Axes:
    return axes_of(lambda axes: draw_ranges(axes, PROFILE))


@pytest.fixture(scope="module")
def errors() -> Axes:
    return axes_of(lambda axes: draw_range_errors(axes, PROFILE))


@pytest.fixture(scope="module")
def fit() -> Axes:
    return axes_of(lambda axes: draw_fit(axes, fitted(0.5, 1.2)))


def test_distances_are_drawn_in_metres_against_degrees_from_the_normal(ranges: Axes) -> None:
    assert names(ranges) == ("angle from the wall's normal (°)", "distance (m)")
    np.testing.assert_allclose(data(line(ranges, MEASURED)), [[-20, 1.012], [0, 1.001], [30, 1.03]])
    np.testing.assert_allclose(data(line(ranges, COMPENSATED)), [[-20, 1.002], [0, 1.001], [30, 0.998]])


def test_the_wall_is_a_level_line_at_its_distance(ranges: Axes) -> None:
    np.testing.assert_allclose(data(line(ranges, "wall at 1.000 m"))[:, 1], 1.0)


def test_both_kinds_of_distances_and_the_wall_are_explained(ranges: Axes) -> None:
    assert legend(ranges) == ["wall at 1.000 m", MEASURED, COMPENSATED]


def test_nothing_is_drawn_but_the_wall_and_both_kinds_of_distances(ranges: Axes) -> None:
    assert len(ranges.lines) == 3
    assert not ranges.patches
    assert not ranges.collections


def test_before_and_after_differ_in_colour_and_in_fill(ranges: Axes) -> None:
    before, after = line(ranges, MEASURED), line(ranges, COMPENSATED)
    assert color(before) == COLORS[FeatureClass.CORNER]
    assert color(after) == COLORS[FeatureClass.WALL]
    assert before.get_markerfacecolor() == "none"
    assert after.get_markerfacecolor() != "none"


def test_distances_are_not_joined(ranges: Axes) -> None:
    assert {each.get_linestyle() for each in (line(ranges, MEASURED), line(ranges, COMPENSATED))} == {"None"}


def test_errors_are_measured_less_true_in_millimetres(errors: Axes) -> None:
    assert names(errors) == ("angle from the wall's normal (°)", "error (mm)")
    np.testing.assert_allclose(data(line(errors, MEASURED)), [[-20, 12], [0, 1], [30, 30]])
    np.testing.assert_allclose(data(line(errors, COMPENSATED)), [[-20, 2], [0, 1], [30, -2]])


def test_no_error_is_a_level_line_at_nought(errors: Axes) -> None:
    np.testing.assert_array_equal(data(errors.lines[0])[:, 1], [0.0, 0.0])


def test_errors_leave_the_legend_to_the_panel_above(errors: Axes) -> None:
    assert legend(errors) == []


def test_a_fit_is_drawn_in_metres_from_the_hub_against_degrees(fit: Axes) -> None:
    assert names(fit) == ("bearing (°)", "distance from the hub (m)")


def test_a_fit_has_every_compensated_echo(fit: Axes) -> None:
    given = fitted(0.5, 1.2)
    echoes = data(line(fit, "compensated echoes"))
    np.testing.assert_allclose(echoes[:, 0], np.degrees(given.cluster.bearings))
    np.testing.assert_allclose(echoes[:, 1], given.distances)


def test_the_polynomial_is_drawn_from_the_first_echo_to_the_last(fit: Axes) -> None:
    curve = data(line(fit, "polynomial"))
    bearings = np.radians(curve[:, 0])
    ends = fitted(0.5, 1.2).cluster.bearings[[0, -1]]
    np.testing.assert_allclose(bearings[[0, -1]], ends)
    np.testing.assert_allclose(curve[:, 1], 1.2 + 0.5 * (bearings - 0.5) ** 2, atol=1e-12)


def test_the_minimum_lies_at_the_lowest_place_of_the_polynomial(fit: Axes) -> None:
    (minimum,) = data(line(fit, "minimum-distance point"))
    curve = data(line(fit, "polynomial"))
    np.testing.assert_allclose(minimum, [np.degrees(0.5), 1.2])
    assert curve[:, 1].min() == pytest.approx(1.2, abs=1e-5)


def test_the_minimum_is_labelled_with_its_units(fit: Axes) -> None:
    (note,) = notes(fit)
    assert note.get_text() == "28.6°, 1.200 m"
    np.testing.assert_allclose(note.xy, [np.degrees(0.5), 1.2])


def test_a_minimum_straight_ahead_has_no_sign() -> None:
    (note,) = notes(axes_of(lambda axes: draw_fit(axes, fitted(-1e-5, 1.0))))
    assert note.get_text() == "0.0°, 1.000 m"


def test_all_of_a_fit_is_explained(fit: Axes) -> None:
    assert legend(fit) == ["compensated echoes", "polynomial", "minimum-distance point"]
