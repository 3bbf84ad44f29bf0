import itertools
from dataclasses import replace
from unittest.mock import patch

import numpy as np
import pytest

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import FloatArray
from echoplan.joint.likelihood import multipath
from echoplan.joint.likelihood.crosstalk import emissions_of
from echoplan.joint.likelihood.double_bounces import ghosts_of_walls
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.hypothesis_scores import Occluders, rescore
from echoplan.joint.likelihood.ping_likelihood import PingLikelihood
from echoplan.joint.likelihood.ping_scores import NO_ECHO
from helpers.expectations import (
    NOISE,
    REACH,
    ROOM,
    SONAR,
    corner,
    cylinder,
    feature,
    likelihood,
    listening,
    pings_of,
    rescored,
    wall,
)
from helpers.multipath_log_densities import ghosts_of_cylinder

POST = cylinder(0.3, 0.9, 0.1)


@pytest.fixture(scope="module")
def room() -> PingLikelihood:
    """Return the likelihood of a room with a post, with a little noise."""
    measurements = pings_of(listening(), [*ROOM, POST], noise=0.001, rng=np.random.default_rng(6))
    return likelihood(measurements)


@pytest.fixture(scope="module")
def walls(room: PingLikelihood) -> list[Hypothesis]:
    """Return the walls of the room, each scored alone."""
    return rescored(room, ROOM)


@pytest.fixture(scope="module")
def post(room: PingLikelihood) -> Hypothesis:
    """Return the post, scored alone."""
    return rescored(room, [POST])[0]


def bare(room: PingLikelihood) -> FloatArray:
    """Return the log densities without any landmark."""
    return np.full(len(room.measurements.readings), room.floor)


def test_clutter_has_a_probability_of_one_in_25(room: PingLikelihood) -> None:
    assert np.exp(room.floor) * REACH == pytest.approx(0.04)


def test_a_hypothesis_has_a_kind_and_parameters() -> None:
    plane, round_, point = (feature(each) for each in (wall(0.5, 1.2), POST, corner(1.0, 2.0)))
    assert (plane.kind, round_.kind, point.kind) == (Kind.WALL, Kind.CYLINDER, Kind.CORNER)
    assert [each.is_wall for each in (plane, round_, point)] == [True, False, False]
    assert plane.line.tolist() == plane.parameters.tolist() == [0.5, 1.2]
    assert round_.parameters.tolist() == [0.3, 0.9, 0.1]
    assert point.parameters.tolist() == [1.0, 2.0]


def test_hypotheses_differ_by_kind_place_and_extent() -> None:
    hypotheses = [
        feature(corner(1.0, 2.0)),
        feature(cylinder(1.0, 2.0, 0.0)),
        feature(corner(1.0, 2.1)),
        feature(wall(1.0, 2.0)),
    ]
    stretched = feature(wall(1.0, 2.0), extent=(0.0, 1.0))
    assert len({each.key for each in (*hypotheses, stretched)}) == 5
    assert stretched.key == feature(wall(1.0, 2.0), extent=(0.0, 1.0), llr_by_station=(3.0,)).key


def test_a_proposed_hypothesis_has_no_ratio_yet(room: PingLikelihood) -> None:
    proposed = room.score(ROOM[0])
    assert proposed.llr == 0.0
    assert not proposed.llr_by_station.any()
    assert len(proposed.ping_scores.pings) > 0


def test_the_score_is_stored_in_the_hypothesis(room: PingLikelihood, walls: list[Hypothesis]) -> None:
    nothing = Occluders(np.zeros((0, 4)), np.zeros((0, 2)))
    verdict = rescore(room.measurements, ROOM[1], walls[1].ping_scores, bare(room), nothing)
    assert walls[1].llr == verdict.llr > 20.0
    assert walls[1].extent == (verdict.low, verdict.high)
    assert walls[1].llr_by_station == pytest.approx(verdict.llr_by_station)


def test_scoring_one_by_one_equals_scoring_together(
    room: PingLikelihood, walls: list[Hypothesis], post: Hypothesis
) -> None:
    log_densities = room.log_densities([walls[0], post])
    together = room.score_all(walls[1:], log_densities, [walls[0], post])
    single = [room.rescored(each, log_densities, [walls[0], post]) for each in walls[1:]]
    assert [each.llr for each in together] == [each.llr for each in single]


def test_other_landmarks_occlude_the_view() -> None:
    stations = [(0.0, 0.0), (1.5, 0.05), (1.5, 0.5)]
    target = cylinder(2.0, 0.0, 0.1)
    measurements = pings_of(listening(stations), [target])
    deaf = measurements._replace(readings=np.where(measurements.stations == 0, np.inf, measurements.readings))
    room = likelihood(deaf)
    screen = feature(wall(0.0, 1.0), extent=(-0.3, 0.3))
    seen = room.rescored(room.score(target), bare(room), [])
    hidden = room.rescored(room.score(target), bare(room), [screen])
    assert seen.llr_by_station[0] < 0.0
    assert hidden.llr_by_station[0] == 0.0


def test_landmarks_explain_their_echoes(room: PingLikelihood, walls: list[Hypothesis], post: Hypothesis) -> None:
    detected = np.isfinite(room.measurements.readings)
    explained = room.log_densities([*walls, post]) > room.floor + 3.0
    assert explained[detected].mean() > 0.9
    assert not explained[~detected].any()


def test_the_log_density_is_the_maximum_over_associations(
    room: PingLikelihood, walls: list[Hypothesis], post: Hypothesis
) -> None:
    features = [*walls, post]
    parts = [room.log_densities_of(each) for each in features]
    best = np.max([bare(room), room.multipath_log_densities(features), *parts], axis=0)
    assert room.log_densities(features).tolist() == best.tolist()


def test_a_duplicate_wall_has_no_ratio(room: PingLikelihood, walls: list[Hypothesis]) -> None:
    again = room.rescored(room.score(ROOM[0]), room.log_densities([walls[0]]), [walls[0]])
    assert walls[0].llr > 20.0
    assert again.llr <= 0.0
    near = room.score(ROOM[0] + np.array([0.0, 0.002, 0.001, 0.0]))
    assert room.rescored(near, room.log_densities([walls[0]]), [walls[0]]).llr < 0.1 * walls[0].llr


def test_without_features_nothing_is_explained(room: PingLikelihood) -> None:
    assert (room.log_densities([]) == room.floor).all()
    assert (room.multipath_log_densities([]) == NO_ECHO).all()


def test_a_wall_explains_pings_only_within_its_extent(room: PingLikelihood, walls: list[Hypothesis]) -> None:
    east = walls[0]
    evidence = east.ping_scores
    middle = float(np.median(evidence.feet))
    short = Hypothesis(
        reflector=east.reflector,
        ping_scores=evidence,
        llr_by_station=east.llr_by_station,
        extent=(middle - 0.1, middle + 0.1),
    )
    inside = np.abs(evidence.feet - middle) < 0.2
    log_densities = room.log_densities_of(short)
    assert log_densities[evidence.pings[inside]].tolist() == evidence.densities[inside].tolist()
    assert (log_densities[evidence.pings[~inside]] == NO_ECHO).all()
    assert (evidence.densities[~inside] > NO_ECHO).any()


def test_a_cylinder_explains_pings_from_everywhere(room: PingLikelihood, post: Hypothesis) -> None:
    log_densities = room.log_densities_of(post)
    assert log_densities[post.ping_scores.pings].tolist() == post.ping_scores.densities.tolist()


def test_multipath_is_that_of_each_pair_of_walls_and_each_cylinder() -> None:
    room = likelihood(pings_of(listening(), [*ROOM, corner(2.0, 1.5)]))
    # The post is between the robot and a wall, as a sensor detects nothing behind it.
    scene, walls, post = (room.measurements, room.tables), rescored(room, ROOM), feature(cylinder(-1.2, -0.6, 0.1))
    pairs = [room.pair_log_densities(one, other) for one, other in itertools.combinations(walls, 2)]
    posts = [ghosts_of_cylinder(scene, each.reflector, post.reflector, NOISE) for each in walls]
    expected = np.max([*pairs, *posts], axis=0)
    assert room.multipath_log_densities([post, *walls]) == pytest.approx(expected)
    assert all(each.max() > NO_ECHO for each in (np.array(pairs), np.array(posts)))


def test_multipath_of_a_pair_does_not_depend_on_earlier_pairs() -> None:
    room = likelihood(pings_of(listening(), [*ROOM, corner(2.0, 1.5)]))
    features = [*rescored(room, ROOM), feature(cylinder(-1.2, -0.6, 0.1))]
    parts = room.multipath.parts(features)
    assert len({part.owners for part in parts}) > 2
    for part in parts:
        own = [features[number] for number in dict.fromkeys(part.owners)]
        (alone,) = (
            each for each in likelihood(room.measurements).multipath.parts(own) if len(set(each.owners)) == len(own)
        )
        assert part.pings.tolist() == alone.pings.tolist()
        assert part.log_densities.tolist() == alone.log_densities.tolist()


def test_corners_cause_no_multipath(room: PingLikelihood, walls: list[Hypothesis]) -> None:
    point = feature(corner(2.0, 1.5))
    assert room.multipath_log_densities([walls[0], point]).tolist() == room.multipath_log_densities([walls[0]]).tolist()


def test_leaving_one_landmark_out_equals_using_all_others(
    room: PingLikelihood, walls: list[Hypothesis], post: Hypothesis
) -> None:
    features = [*walls, post]
    left_out = room.log_densities_without(features)
    for place, log_densities in enumerate(left_out):
        others = [*features[:place], *features[place + 1 :]]
        assert log_densities.tolist() == room.log_densities(others).tolist()
    assert any(log_densities.tolist() != room.log_densities(features).tolist() for log_densities in left_out)
    assert room.log_densities_without([]) == []


@pytest.mark.parametrize(("what", "again"), [("moved", 0), ("warmer", 1), ("fainter", 1), ("others", 1)])
def test_crosstalk_sources_are_computed_again_only_if_they_change(room: PingLikelihood, what: str, again: int) -> None:
    # The travel of bursts does not depend on the poses.
    measurements, sonar = room.measurements, SONAR
    sonars = {
        "warmer": replace(sonar, range_scale=sonar.range_scale + 0.01),
        "fainter": replace(sonar, figure_of_merit=sonar.figure_of_merit - 3.0),
    }
    changed = {
        "moved": measurements._replace(x=measurements.x + 0.1),
        "others": measurements._replace(readings=measurements.readings.copy()),
    }
    first = likelihood(measurements)
    walls = rescored(first, ROOM)
    first.multipath_log_densities(walls)
    later = PingLikelihood(changed.get(what, measurements), sonars.get(what, sonar).tabulated(), NOISE, before=first)
    afresh = PingLikelihood(later.measurements, later.tables, NOISE).multipath_log_densities(walls)
    with patch.object(multipath, "emissions_of", wraps=emissions_of) as listed:
        assert later.multipath_log_densities(walls).tolist() == afresh.tolist()
    assert listed.call_count == again


def test_multipath_is_computed_once(room: PingLikelihood, walls: list[Hypothesis]) -> None:
    room.multipath_log_densities(walls)
    with patch.object(multipath, "_cast") as anew:
        room.multipath_log_densities(walls)
    assert not anew.called


@pytest.mark.parametrize(
    ("extent", "reflecting"),
    [
        # The north wall crosses the east wall at 1.5 m along it.
        ((-0.5, 0.5), (-0.9, 1.55)),
        ((1.0, 1.8), (0.6, 2.2)),
        ((-2.5, -1.0), (-2.9, -0.6)),
        ((3.0, 3.2), (1.45, 3.6)),
        ((4.0, 4.2), (3.6, 4.6)),
    ],
)
def test_walls_reflect_multipath_up_to_a_near_crossing(
    room: PingLikelihood, extent: tuple[float, float], reflecting: tuple[float, float]
) -> None:
    east, north = feature(ROOM[0], extent=extent), feature(ROOM[1], extent=(-2.5, 0.0))
    # Along the north wall the east wall is crossed at -2 m.
    ends = (reflecting, (-2.9, 0.4))
    truth = ghosts_of_walls(room.measurements, room.tables, (ROOM[0], ROOM[1]), ends, NOISE)
    assert room.pair_log_densities(east, north).tolist() == truth.tolist()


def test_nearly_parallel_walls_reflect_multipath_a_little_beyond_their_extent(room: PingLikelihood) -> None:
    tilted = wall(np.pi - 0.05, 2.0)
    east, west = feature(ROOM[0], extent=(-0.2, 0.2)), feature(tilted, extent=(-0.3, 0.1))
    ends = ((-0.6, 0.6), (-0.7, 0.5))
    truth = ghosts_of_walls(room.measurements, room.tables, (ROOM[0], tilted), ends, NOISE)
    assert room.pair_log_densities(east, west).tolist() == truth.tolist()


def test_a_corner_gains_little_once_multipath_of_its_walls_explains_it() -> None:
    # In a right angle, the double echo equals that of a point at the crossing.
    measurements = pings_of(listening([(0.1, 0.0), (0.4, 0.0)]), [corner(1.2, 0.9)])
    room = likelihood(measurements)
    east, north = (
        feature(wall(0.0, 1.2), extent=(-0.5, 0.5)),
        feature(wall(np.pi / 2, 0.9), extent=(-1.0, 0.0)),
    )
    alone = room.rescored(room.score(corner(1.2, 0.9)), bare(room), [])
    known = room.rescored(room.score(corner(1.2, 0.9)), room.log_densities([east, north]), [east, north])
    assert alone.llr > 50.0
    assert known.llr < 0.25 * alone.llr
