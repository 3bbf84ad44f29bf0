import itertools
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.axes import Axes

from echoplan.geometry import directions
from echoplan.model import FeatureClass, Pings
from echoplan.viewer.echoes import draw_classes, draw_clusters, draw_echoes
from echoplan.viewer.palette import COLORS, MARKERS
from echoplan.viewer.stages import Located, SweepStages
from helpers import chamber, scenes
from helpers.canvas import axes_of, color, data, legend, line, lines, names

MINIMA, STRAY = "minimum-distance point", "in no cluster"
SILENCE = SweepStages(
    index=0, valid=scenes.pings(np.zeros(0), np.zeros(0)), kept=scenes.pings(np.zeros(0), np.zeros(0)), located=()
)


def echoes_of(*pings: Pings) -> Axes:
    return axes_of(lambda axes: draw_echoes(axes, pings))


def points(pings: Pings) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    return pings.origins_xy + pings.ranges[:, None] * directions(pings.bearings)


@pytest.fixture(scope="module")
def clusters() -> Axes:
    return axes_of(lambda axes: draw_clusters(axes, chamber.staged()[0]))


@pytest.fixture(scope="module")
def classes() -> Axes:
    return axes_of(lambda axes: draw_classes(axes, chamber.staged()))


def test_echoes_lie_at_the_end_of_the_arm_and_the_range() -> None:
    axes = echoes_of(scenes.pings(np.array([0.0, np.pi / 2]), np.array([1.0, 2.0]), hub=(3.0, 1.0)))
    np.testing.assert_allclose(data(axes.lines[0]), [[4.05, 1.0], [3.0, 3.05]])
    assert names(axes) == ("x (m)", "y (m)")


def test_each_station_has_one_cross_in_the_middle_of_its_hubs() -> None:
    moving = scenes.pings(np.zeros(2), np.ones(2))
    moving = replace(moving, hubs_xy=np.array([[0.0, 0.0], [0.2, 0.4]]))
    axes = echoes_of(moving, scenes.pings(np.zeros(3), np.ones(3), hub=(5.0, 2.0)))
    echoes, stations = axes.lines
    assert len(data(echoes)) == 5
    np.testing.assert_allclose(data(stations), [[0.1, 0.2], [5.0, 2.0]])
    assert stations.get_marker() == "x"


def test_a_station_that_detected_nothing_has_no_cross() -> None:
    axes = echoes_of(scenes.pings(np.zeros(0), np.zeros(0)), scenes.pings(np.zeros(1), np.ones(1), hub=(1.0, 2.0)))
    np.testing.assert_allclose(data(axes.lines[1]), [[1.0, 2.0]])


def test_pings_without_echoes_give_an_empty_map_of_echoes() -> None:
    for axes in (echoes_of(), echoes_of(scenes.pings(np.zeros(0), np.zeros(0)))):
        assert [len(data(each)) for each in axes.lines] == [0, 0]


def test_maps_of_echoes_have_both_directions_alike() -> None:
    assert echoes_of(scenes.pings(np.zeros(1), np.ones(1))).get_aspect() == 1.0


def test_clusters_are_drawn_in_metres_from_the_hub_against_degrees(clusters: Axes) -> None:
    assert names(clusters) == ("bearing (°)", "distance from the hub (m)")
    assert clusters.get_ylim()[0] == 0.0
    np.testing.assert_allclose(clusters.get_xticks(), np.arange(-180, 181, 45))


def test_each_cluster_is_a_line_of_its_own_echoes(clusters: Axes) -> None:
    own = [each for each in clusters.lines if each.get_marker() == "."]
    located = chamber.staged()[0].located
    assert [len(data(each)) for each in own] == [len(each.cluster.pings) for each in located]
    for drawn, each in zip(own, located, strict=True):
        np.testing.assert_allclose(data(drawn)[:, 1], each.cluster.distances)
        turns = (data(drawn)[:, 0] - np.degrees(each.cluster.bearings)) / 360
        np.testing.assert_allclose(turns, np.round(turns[0]), atol=1e-9)


def test_neighbouring_clusters_differ_in_shade(clusters: Axes) -> None:
    shades = [color(each) for each in clusters.lines if each.get_marker() == "."]
    assert len(set(shades)) == 2
    assert all(one != other for one, other in itertools.pairwise(shades))


def test_no_cluster_is_split_and_its_middle_lies_within_half_a_turn(clusters: Axes) -> None:
    for drawn in clusters.lines:
        if drawn.get_marker() == ".":
            bearings = data(drawn)[:, 0]
            assert np.ptp(bearings) <= 41
            assert -180 - 1e-6 <= bearings[[0, -1]].mean() <= 180


@pytest.mark.parametrize(("first", "drawn_from"), [(-20, -20), (150, 150), (170, -190), (-230, 130), (-200, -200)])
def test_a_cluster_is_drawn_where_its_middle_is_within_half_a_turn(first: int, drawn_from: int) -> None:
    bearings = np.radians(np.arange(first, first + 50.0))
    cluster = scenes.cluster(bearings, np.ones(50))
    stages = SweepStages(
        index=0, valid=cluster.pings, kept=cluster.pings, located=(Located(cluster=cluster, observation=None),)
    )
    axes = axes_of(lambda axes: draw_clusters(axes, stages))
    (own,) = (data(each) for each in axes.lines if each.get_marker() == ".")
    np.testing.assert_allclose(own[:, 0], np.arange(drawn_from, drawn_from + 50.0), atol=1e-9)


def test_each_located_cluster_has_its_minimum_among_its_own_echoes(clusters: Axes) -> None:
    minima = data(line(clusters, MINIMA))
    own = [data(each) for each in clusters.lines if each.get_marker() == "."]
    assert len(minima) == len(own) == 6
    for minimum, echoes in zip(minima, own, strict=True):
        assert echoes[0, 0] <= minimum[0] <= echoes[-1, 0]
    np.testing.assert_allclose(minima[[0, 1, 2, 4], 1], [1.2, 0.6, 1.0, 0.8], atol=1e-6)


def test_what_is_in_no_cluster_is_drawn_apart(clusters: Axes) -> None:
    stray = data(line(clusters, STRAY))
    assert len(stray) == len(chamber.staged()[0].stray)
    # The stray echo of 2.5 m at 225 degrees, from an arm of 5 cm.
    assert [-135.0, 2.55] in stray.round(6).tolist()


def test_minima_and_stray_echoes_are_explained(clusters: Axes) -> None:
    assert legend(clusters) == [STRAY, MINIMA]


def test_a_cluster_that_was_not_located_has_no_minimum() -> None:
    stages = chamber.staged()[0]
    blank = replace(stages, located=(replace(stages.located[0], observation=None), *stages.located[1:]))
    axes = axes_of(lambda axes: draw_clusters(axes, blank))
    assert len(data(line(axes, MINIMA))) == 5
    assert sum(each.get_marker() == "." for each in axes.lines) == 6


def test_a_silent_station_has_axes_and_nothing_on_them() -> None:
    axes = axes_of(lambda axes: draw_clusters(axes, SILENCE))
    assert [len(data(each)) for each in axes.lines] == [0, 0]
    assert legend(axes) == [STRAY, MINIMA]


def test_each_class_is_explained_with_the_number_of_its_clusters(classes: Axes) -> None:
    assert legend(classes) == ["flat (8)", "cylinder (2)", "corner (2)"]
    assert names(classes) == ("x (m)", "y (m)")


@pytest.mark.parametrize(
    ("label", "feature_class"),
    [
        ("flat (8)", FeatureClass.WALL),
        ("cylinder (2)", FeatureClass.CYLINDER),
        ("corner (2)", FeatureClass.CORNER),
    ],
)
def test_each_class_has_its_colour_its_mark_and_the_minima_of_its_clusters(
    classes: Axes, label: str, feature_class: FeatureClass
) -> None:
    drawn = line(classes, label)
    own = [each for stages in chamber.staged() for each in stages.located if each.feature_class is feature_class]
    assert color(drawn) == COLORS[feature_class]
    assert drawn.get_marker() == MARKERS[feature_class]
    expected = [each.observation.point.position_xy for each in own if each.observation]
    np.testing.assert_allclose(data(drawn), expected)


def test_all_echoes_of_a_class_have_its_colour(classes: Axes) -> None:
    dots = {color(each): data(each) for each in classes.lines if each.get_marker() == "."}
    for feature_class in FeatureClass:
        own = [each for stages in chamber.staged() for each in stages.located if each.feature_class is feature_class]
        expected = np.concatenate([points(each.cluster.pings) for each in own])
        np.testing.assert_allclose(dots[COLORS[feature_class]], expected)


def test_classes_that_were_not_detected_are_counted_all_the_same() -> None:
    axes = axes_of(lambda axes: draw_classes(axes, [SILENCE]))
    assert legend(axes) == ["flat (0)", "cylinder (0)", "corner (0)"]
    assert all(len(data(each)) == 0 for each in axes.lines)


def test_a_cluster_without_a_class_is_not_drawn_among_them() -> None:
    stages = chamber.staged()[0]
    blank = replace(stages, located=(replace(stages.located[0], observation=None), *stages.located[1:]))
    axes = axes_of(lambda axes: draw_classes(axes, [blank]))
    assert legend(axes)[0] == "flat (3)"
    assert lines(axes, "flat (4)") == []
