from dataclasses import replace

import numpy as np
import pytest

from echoplan.classical.mdp_fuzzy import MdpFuzzyMapper
from echoplan.errors import InvalidValueError
from echoplan.extraction import compensated_distances
from echoplan.geometry import directions, wrap
from echoplan.model import FeatureClass
from echoplan.viewer.stages import (
    Fitted,
    Located,
    SweepStages,
    WallProfile,
    example,
    fitted_cluster,
    sweep_stages,
    wall_profile,
)
from helpers import chamber, scenes
from helpers.chamber import COLUMN, EDGE, HUBS, LATENESS, LINES
from helpers.scenes import ARM, around, cluster, observed, wall_ranges


def at_wall(
    *, distance: float = 1.0, normal: float = 0.3, half_width: float = 0.35, lateness: float = LATENESS
) -> Located:
    """A wall about whose normal the array at the origin turned, as it would be located."""
    bearings = around(normal, half_width)
    ranges = wall_ranges(bearings, normal=normal, distance=distance) + lateness * (bearings - normal) ** 2
    detection = observed((0.0, 0.0), bearing=normal, distance=distance, degrees=(0.0, 0.0, 1.0))
    return Located(cluster=cluster(bearings, ranges), observation=detection)


def classes(stages: SweepStages) -> list[FeatureClass | None]:
    return [each.feature_class for each in stages.located]


def turned_to(located: Located) -> float:
    assert located.observation is not None
    return located.observation.point.bearing


def test_a_sweep_keeps_its_number() -> None:
    assert [each.index for each in chamber.staged()] == [3, 5]


def test_valid_are_all_echoes_and_no_silence() -> None:
    _, sweeps = chamber.mapped()
    for sweep, stages in zip(sweeps, chamber.staged(), strict=True):
        assert len(stages.valid) == np.isfinite(sweep.ranges).sum()
        assert np.isfinite(stages.valid.ranges).all()


def test_the_filter_only_takes_away() -> None:
    for stages in chamber.staged():
        valid = set(zip(stages.valid.bearings.tolist(), stages.valid.ranges.tolist(), strict=True))
        assert set(zip(stages.kept.bearings.tolist(), stages.kept.ranges.tolist(), strict=True)) < valid


def test_every_object_of_the_room_is_a_cluster_in_order_around_the_hub() -> None:
    wall, column, edge = FeatureClass.WALL, FeatureClass.CYLINDER, FeatureClass.CORNER
    for stages in chamber.staged():
        assert classes(stages) == [wall, wall, wall, column, wall, edge]
        assert (np.diff([turned_to(each) for each in stages.located]) > 0).all()


def test_objects_are_located_where_they_are() -> None:
    for hub, stages in zip(HUBS, chamber.staged(), strict=True):
        points = [each.point for each in stages.observations]
        for normal, offset in LINES:
            distances = [each.distance for each in points if abs(wrap(each.bearing - normal)) < np.radians(0.5)]
            assert distances == [pytest.approx(offset - directions(normal) @ np.array(hub), abs=1e-6)]
        column = np.hypot(*(np.array(COLUMN[:2]) - hub)) - COLUMN[2]
        assert points[3].distance == pytest.approx(column, abs=2e-3)
        assert points[5].distance == pytest.approx(np.hypot(*(np.array(EDGE[:2]) - hub)), abs=2e-3)


def test_the_stages_agree_with_the_detections_of_the_mapper_itself() -> None:
    mapper, sweeps = chamber.mapped()
    again = [each for sweep in sweeps for each in sweep_stages(mapper, sweep).observations]
    assert len(again) == len(mapper.observations) == 12
    for one, other in zip(again, mapper.observations, strict=True):
        assert (one.sweep, one.pings, one.point.bearing, one.point.distance) == (
            other.sweep,
            other.pings,
            other.point.bearing,
            other.point.distance,
        )
        np.testing.assert_array_equal(one.degrees, other.degrees)


def test_looking_at_the_stages_changes_nothing_in_the_mapper() -> None:
    mapper = MdpFuzzyMapper(scenes.rig())
    sweep = chamber.recorded((0.0, 0.0))
    mapper.add(sweep)
    before = len(mapper.observations)
    sweep_stages(mapper, sweep)
    assert len(mapper.observations) == before


def test_a_silent_sweep_has_stages_of_nothing() -> None:
    stages = sweep_stages(MdpFuzzyMapper(scenes.rig()), scenes.sweep_of(np.full(360, np.inf)))
    assert len(stages.valid) == len(stages.kept) == len(stages.stray) == 0
    assert stages.located == ()
    assert stages.observations == ()


def test_every_echo_is_stray_or_in_one_cluster() -> None:
    for stages in chamber.staged():
        assert len(stages.stray) + sum(len(each.cluster.pings) for each in stages.located) == len(stages.valid)


def test_the_false_echo_is_in_no_cluster() -> None:
    for stages in chamber.staged():
        stray = np.degrees(stages.stray.bearings).round(6) % 360
        assert chamber.STRAY in stray.tolist()
        assert len(stray) <= 3


def test_echoes_of_two_sensors_in_one_direction_are_two_echoes() -> None:
    pings = replace(scenes.pings(np.array([0.1, 0.1]), np.array([1.0, 1.0])), sensors=np.array([0, 1]))
    first = Located(cluster=scenes.cluster(np.array([0.1]), np.array([1.0])), observation=None)
    stray = SweepStages(index=0, valid=pings, kept=pings, located=(first,)).stray
    assert stray.sensors.tolist() == [1]


def test_a_cluster_that_shows_no_nearest_point_has_no_class_and_no_observation() -> None:
    blank = replace(at_wall(), observation=None)
    pings = blank.cluster.pings
    assert blank.feature_class is None
    assert SweepStages(index=0, valid=pings, kept=pings, located=(blank,)).observations == ()


def test_the_class_of_a_cluster_is_that_of_its_largest_membership() -> None:
    detection = observed((0.0, 0.0), bearing=0.3, distance=1.0, degrees=(0.2, 0.9, 0.4))
    assert replace(at_wall(), observation=detection).feature_class is FeatureClass.CYLINDER


def test_the_fit_of_a_wall_is_its_distance_with_what_the_arm_added_taken_out() -> None:
    fitted = fitted_cluster(at_wall(normal=0.3, distance=1.0))
    assert fitted is not None
    turns = fitted.cluster.bearings - 0.3
    np.testing.assert_allclose(fitted.distances, 1.0 + LATENESS * turns**2, atol=1e-12)


def test_the_polynomial_of_a_fit_goes_through_distances_that_are_one() -> None:
    fitted = fitted_cluster(at_wall(normal=0.3))
    assert fitted is not None
    np.testing.assert_allclose(fitted.parabola.vertex, [0.3, 1.0], atol=1e-9)
    assert fitted.parabola.coefficients[2] == pytest.approx(LATENESS)
    assert fitted.point.distance == 1.0


def test_a_fit_can_suppose_a_cylinder() -> None:
    located = at_wall()
    flat, bent = fitted_cluster(located), fitted_cluster(located, radius=0.05)
    assert flat is not None
    assert bent is not None
    expected = compensated_distances(located.cluster, normal=0.3, depth=1.0 - ARM, radius=0.05)
    np.testing.assert_allclose(bent.distances, expected)
    assert not np.allclose(bent.distances, flat.distances)


def test_what_was_not_located_cannot_be_fitted() -> None:
    assert fitted_cluster(replace(at_wall(), observation=None)) is None


def test_what_has_two_directions_cannot_be_fitted() -> None:
    two = cluster(np.array([0.0, 0.1, 0.1]), np.array([1.0, 1.0, 1.0]))
    assert fitted_cluster(replace(at_wall(), cluster=two)) is None


def test_a_fit_has_a_distance_for_each_echo() -> None:
    fitted = fitted_cluster(at_wall())
    assert fitted is not None
    with pytest.raises(InvalidValueError, match="distances must have shape"):
        Fitted(cluster=fitted.cluster, point=fitted.point, distances=np.ones(3), parabola=fitted.parabola)


def test_a_profile_holds_distances_against_the_wall_that_gave_them() -> None:
    normal, distance = 0.3, 1.0
    profile = wall_profile(at_wall(normal=normal, distance=distance), np.array([[normal, distance]]))
    assert profile is not None
    assert profile.distance == pytest.approx(distance)
    np.testing.assert_allclose(profile.angles, around(0.0, 0.35), atol=1e-9)
    late = LATENESS * profile.angles**2
    np.testing.assert_allclose(profile.measured, distance + ARM * (1 - np.cos(profile.angles)) + late)
    np.testing.assert_allclose(profile.compensated, distance + late)


def test_a_profile_does_not_depend_on_the_sense_of_the_line() -> None:
    located = at_wall()
    there, back = (wall_profile(located, np.array([line])) for line in ([0.3, 1.0], [0.3 + np.pi, -1.0]))
    assert there is not None
    assert back is not None
    np.testing.assert_allclose(back.angles, there.angles, atol=1e-9)
    np.testing.assert_allclose(back.compensated, there.compensated)
    assert back.distance == pytest.approx(there.distance)


def test_a_profile_shows_the_distance_of_the_wall_not_of_what_was_located() -> None:
    profile = wall_profile(at_wall(distance=1.02), np.array([[0.3, 1.0]]))
    assert profile is not None
    assert profile.distance == pytest.approx(1.0)
    np.testing.assert_allclose(profile.compensated.min(), 1.02, atol=1e-9)


@pytest.mark.parametrize("hub", HUBS)
def test_of_many_walls_a_profile_takes_the_one_that_was_detected(hub: tuple[float, float]) -> None:
    stages = chamber.staged()[HUBS.index(hub)]
    for located in stages.located:
        if located.feature_class is FeatureClass.WALL:
            profile = wall_profile(located, LINES)
            nearest = int(np.argmin(np.abs(wrap(LINES[:, 0] - turned_to(located)))))
            assert profile is not None
            assert profile.distance == pytest.approx(LINES[nearest, 1] - directions(LINES[nearest, 0]) @ np.array(hub))


def test_a_wall_through_the_point_but_across_the_beam_is_not_taken() -> None:
    # The first line runs through the located point (1, 0) along the beam, the second is 5 cm off but square to it.
    profile = wall_profile(at_wall(normal=0.0), np.array([[np.pi / 2, 0.0], [0.0, 1.05]]))
    assert profile is not None
    assert profile.distance == pytest.approx(1.05)


def test_a_wall_of_the_other_sense_is_as_near_as_one_of_this() -> None:
    profile = wall_profile(at_wall(normal=0.3), np.array([[0.3, 1.05], [0.3 + np.pi, -1.0]]))
    assert profile is not None
    assert profile.distance == pytest.approx(1.0)


@pytest.mark.parametrize(("away", "chosen"), [(0.45, 1.45), (0.55, np.cos(np.radians(30)))])
def test_a_wall_that_leans_is_as_bad_as_one_that_is_off_by_as_much_at_its_distance(away: float, chosen: float) -> None:
    # A wall through the point (1, 0) that leans by 30 degrees is as bad as one half a metre behind it.
    lean = np.radians(30)
    profile = wall_profile(at_wall(normal=0.0), np.array([[lean, np.cos(lean)], [0.0, 1.0 + away]]))
    assert profile is not None
    assert profile.distance == pytest.approx(chosen)


def test_without_a_wall_or_without_a_place_there_is_no_profile() -> None:
    assert wall_profile(at_wall(), np.zeros((0, 2))) is None
    assert wall_profile(replace(at_wall(), observation=None), LINES) is None


def test_a_profile_has_both_distances_for_each_angle() -> None:
    with pytest.raises(InvalidValueError, match="compensated must have shape"):
        WallProfile(angles=np.zeros(2), measured=np.ones(2), compensated=np.ones(3), distance=1.0)


def test_the_example_of_a_class_is_the_one_nearest_to_a_metre() -> None:
    found = example(chamber.staged(), FeatureClass.WALL)
    assert found is not None
    assert found.observation is not None
    assert found.observation.point.distance == pytest.approx(1.0)
    assert found.observation.sweep == 3


@pytest.mark.parametrize(("distance", "sweep", "found"), [(0.5, 5, 0.55), (0.86, 5, 0.85), (2.0, 5, 1.3)])
def test_an_example_at_another_distance_is_another_one(distance: float, sweep: int, found: float) -> None:
    chosen = example(chamber.staged(), FeatureClass.WALL, distance=distance)
    assert chosen is not None
    assert chosen.observation is not None
    assert chosen.observation.sweep == sweep
    assert chosen.observation.point.distance == pytest.approx(found)


def test_of_two_examples_alike_the_first_is_taken() -> None:
    (first, _) = stages = chamber.staged()
    chosen = example([first, first, *stages], FeatureClass.CYLINDER)
    assert chosen is first.located[3]


def test_a_class_that_was_not_detected_has_no_example() -> None:
    only_walls = replace(chamber.staged()[0], located=chamber.staged()[0].located[:3])
    assert example([only_walls], FeatureClass.CYLINDER) is None
    assert example([], FeatureClass.WALL) is None
