import numpy as np
import pytest
from matplotlib.figure import Figure

from echoplan.model import FeatureClass, FeatureMap
from echoplan.viewer.figures import (
    class_figure,
    cluster_figure,
    filter_figure,
    fit_figure,
    membership_figure,
    plan_figure,
    range_figure,
)
from echoplan.viewer.plan import Plan
from echoplan.viewer.stages import Fitted, WallProfile, example, fitted_cluster, wall_profile
from helpers import chamber
from helpers.canvas import data, legend, line, names
from helpers.drawings import full_plan
from helpers.maps import drawn, wall


@pytest.fixture(scope="module")
def profile() -> WallProfile:
    located = example(chamber.staged(), FeatureClass.WALL)
    assert located is not None
    found = wall_profile(located, chamber.LINES)
    assert found is not None
    return found


@pytest.fixture(scope="module")
def fitted() -> Fitted:
    located = example(chamber.staged(), FeatureClass.WALL)
    assert located is not None
    found = fitted_cluster(located)
    assert found is not None
    return found


@pytest.fixture(scope="module")
def ranges(profile: WallProfile) -> Figure:
    return range_figure(profile)


@pytest.fixture(scope="module")
def filtered() -> Figure:
    return filter_figure(chamber.staged())


def height(figure: Figure) -> float:
    return float(figure.get_size_inches()[1])


def test_distances_are_above_their_errors_on_one_axis_of_angles(ranges: Figure) -> None:
    above, below = ranges.axes
    assert names(above) == ("", "distance (m)")
    assert names(below) == ("angle from the wall's normal (°)", "error (mm)")
    assert above.get_xlim() == below.get_xlim()


def test_errors_are_a_thousand_times_what_distances_differ_from_the_wall(ranges: Figure, profile: WallProfile) -> None:
    above, below = (data(line(axes, "measured")) for axes in ranges.axes)
    np.testing.assert_allclose(below[:, 1], 1000 * (above[:, 1] - profile.distance), atol=1e-9)
    assert len(above) == 41


def test_compensation_takes_out_what_the_arm_adds(ranges: Figure) -> None:
    _, below = ranges.axes
    errors = {name: np.abs(data(line(below, name))[:, 1]).max() for name in ("measured", "after compensation (Eq. 1)")}
    # An arm of 50 mm adds 3 mm at 20 degrees; what is late adds 2.4 mm to both.
    assert errors["measured"] == pytest.approx(50 * (1 - np.cos(np.radians(20))) + 2.437, abs=0.01)
    assert errors["after compensation (Eq. 1)"] == pytest.approx(2.437, abs=0.01)


def test_a_fit_has_one_panel_of_the_cluster(fitted: Fitted) -> None:
    (axes,) = fit_figure(fitted).axes
    assert names(axes) == ("bearing (°)", "distance from the hub (m)")
    np.testing.assert_allclose(data(line(axes, "compensated echoes"))[:, 1], fitted.distances)


def test_the_membership_functions_have_one_panel() -> None:
    (axes,) = membership_figure().axes
    assert names(axes) == ("width of the cluster (1)", "membership (1)")


def test_the_filter_is_shown_before_and_after_and_counted(filtered: Figure) -> None:
    before, after = filtered.axes
    counts = [
        sum(len(each) for each in pings) for pings in zip(*((s.valid, s.kept) for s in chamber.staged()), strict=True)
    ]
    assert before.get_title(loc="left") == f"(a) {counts[0]} echoes"
    assert after.get_title(loc="left") == f"(b) {counts[1]} kept by the filter"
    assert [len(data(axes.lines[0])) for axes in (before, after)] == counts
    assert counts[0] > counts[1] > 0


def test_before_and_after_are_on_the_same_axes(filtered: Figure) -> None:
    before, after = filtered.axes
    assert before.get_xlim() == after.get_xlim()
    assert before.get_ylim() == after.get_ylim()
    assert (names(before), names(after)) == (("x (m)", "y (m)"), ("x (m)", ""))


def test_clusters_of_one_station_have_one_panel() -> None:
    (axes,) = cluster_figure(chamber.staged()[0]).axes
    assert sum(each.get_marker() == "." for each in axes.lines) == 6


def test_classes_of_all_stations_have_one_panel() -> None:
    (axes,) = class_figure(chamber.staged()).axes
    assert legend(axes) == ["flat (8)", "cylinder (2)", "corner (2)"]


@pytest.mark.parametrize("figure", [filter_figure, class_figure])
def test_no_stations_are_a_square_of_nothing(figure: object) -> None:
    made = figure([])  # type: ignore[operator]
    assert all(len(data(each)) == 0 for axes in made.axes for each in axes.lines)
    assert height(made) == pytest.approx(0.8 + (2.7 if len(made.axes) == 2 else 5.4))


def test_a_map_has_one_panel() -> None:
    (axes,) = plan_figure(full_plan()).axes
    assert names(axes) == ("x (m)", "y (m)")
    assert "wall" in legend(axes)


def test_a_map_of_nothing_is_a_figure_all_the_same() -> None:
    (axes,) = plan_figure(Plan(feature_map=FeatureMap(method="none"))).axes
    assert legend(axes) == []


@pytest.mark.parametrize(
    ("end", "high"), [([4.0, 3.0], 1.3 + 5.6 * 0.75), ([30.0, 1.0], 1.3 + 5.6 * 0.4), ([1.0, 30.0], 8.8)]
)
def test_a_figure_is_as_high_as_its_map_and_no_higher_than_a_page(end: list[float], high: float) -> None:
    figure = plan_figure(Plan(feature_map=drawn(wall([0.0, 0.0], end))))
    assert height(figure) == pytest.approx(high)


def test_figures_are_as_wide_as_the_text_of_a_page(ranges: Figure, filtered: Figure) -> None:
    assert {float(figure.get_size_inches()[0]) for figure in (ranges, filtered)} == {6.3}
