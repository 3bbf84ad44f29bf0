from typing import Any

import numpy as np
import pytest

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import FloatArray, IntArray
from echoplan.geometry import directions, wrap
from echoplan.joint.likelihood.proposals import ArcMeasurements, CandidateSettings, propose_hypotheses
from helpers.expectations import corner, cylinder, round_wall, wall

SETTINGS = CandidateSettings()
STATIONS = np.array([[0.0, 0.0], [0.6, -0.3], [0.2, 0.7]])


def simulated_arcs(
    reflectors: list[FloatArray], *, stations: FloatArray = STATIONS, turn: float = 0.0, late: float = 0.0
) -> ArcMeasurements:
    """Return arcs of landmarks from each station, with planes that are rotated and shifted."""
    rows = []
    for number, center in enumerate(stations):
        for kind, a, b, radius in reflectors:
            away = np.array([a, b]) - center
            normal = a if kind == Kind.WALL else np.arctan2(away[1], away[0])
            depth = b - center @ directions(a) if kind == Kind.WALL else np.hypot(*away) - radius
            angle = normal + turn * (-1) ** number
            rows.append([number, *center, angle, depth + late + center @ directions(angle)])
    table = np.array(rows)
    numbers: IntArray = table[:, 0].astype(np.int64)
    return ArcMeasurements(stations=numbers, centers=table[:, 1:3], planes=table[:, 3:], pings=np.full(len(table), 9))


def proposals(arc_measurements: ArcMeasurements, *, fresh: list[bool] | None = None, **settings: Any) -> FloatArray:
    """Return the proposals, by default with all arcs new."""
    new = np.ones(len(arc_measurements.stations), dtype=bool) if fresh is None else np.array(fresh)
    return propose_hypotheses(arc_measurements, new, CandidateSettings(**settings))


def distance(candidates: FloatArray, reflector: FloatArray) -> float:
    """Return the distance of the nearest proposal of the same class from a landmark [rad and m together]."""
    alike = candidates[candidates[:, 0] == reflector[0]]
    difference = alike[:, 1:] - reflector[1:]
    if reflector[0] == Kind.WALL:
        difference[:, 0] = wrap(difference[:, 0])
    return float(np.abs(difference).max(axis=1).min(initial=np.inf))


def kinds(candidates: FloatArray) -> set[Kind]:
    """Return the classes of the proposals."""
    return {Kind(int(kind)) for kind in candidates[:, 0]}


@pytest.mark.parametrize(
    "reflector",
    [
        wall(0.4, 1.5),
        wall(-2.8, 2.0),
        wall(np.pi - 0.01, 1.0),
        corner(1.5, 1.0),
        corner(-1.0, 0.4),
        cylinder(1.2, 1.4, 0.12),
    ],
)
@pytest.mark.parametrize("turn", [0.0, 0.05])
def test_arcs_of_two_stations_propose_their_landmark(reflector: FloatArray, turn: float) -> None:
    arc_measurements = simulated_arcs([reflector], stations=STATIONS[:2], turn=turn)
    assert distance(proposals(arc_measurements), reflector) < 1e-6


def test_arcs_of_several_landmarks_propose_each_of_them() -> None:
    reflectors = [wall(0.4, 1.5), wall(2.2, 1.9), corner(-1.5, -1.0), cylinder(0.5, -1.3, 0.08)]
    candidates = proposals(simulated_arcs(reflectors))
    assert [distance(candidates, each) < 0.02 for each in reflectors] == [True] * 4


def test_a_single_arc_proposes_only_its_plane() -> None:
    candidates = proposals(simulated_arcs([wall(0.4, 1.5)], stations=STATIONS[:1]))
    assert candidates == pytest.approx(wall(0.4, 1.5)[None])


def test_a_common_tangent_is_nearer_to_the_wall_than_the_planes_of_arcs() -> None:
    arc_measurements = simulated_arcs([wall(0.4, 1.5)], stations=STATIONS[:2], turn=0.08)
    own = np.abs(wrap(arc_measurements.planes[:, 0] - 0.4))
    assert own.min() > 0.07
    assert distance(proposals(arc_measurements), wall(0.4, 1.5)) < 1e-6


def test_arcs_of_too_different_directions_propose_no_tangent() -> None:
    arc_measurements = simulated_arcs([wall(0.4, 1.5)], stations=STATIONS[:2], turn=np.radians(12))
    assert distance(proposals(arc_measurements), wall(0.4, 1.5)) > 0.1
    assert distance(proposals(arc_measurements, wall_angle_gate=np.radians(25)), wall(0.4, 1.5)) < 1e-6


def test_arcs_of_one_station_propose_nothing_together() -> None:
    arc_measurements = simulated_arcs([wall(0.4, 1.5), wall(0.5, 1.5)], stations=STATIONS[:1])
    assert kinds(proposals(arc_measurements)) == {Kind.WALL}
    assert len(proposals(arc_measurements)) == 2


def test_stations_close_together_propose_no_points() -> None:
    near, far = (
        simulated_arcs([corner(1.5, 0.0)], stations=np.array([[0.0, 0.0], [0.0, apart]])) for apart in (0.04, 0.06)
    )
    assert Kind.CORNER not in kinds(proposals(near))
    assert Kind.CORNER in kinds(proposals(far))


def test_range_circles_with_a_small_gap_propose_a_point_between() -> None:
    # The point lies between the stations; readings 5 mm short leave a gap between the circles.
    stations = np.array([[0.0, 0.0], [2.0, 0.0]])
    arc_measurements = simulated_arcs([corner(1.0, 0.0)], stations=stations, late=-0.005)
    assert distance(proposals(arc_measurements), corner(1.0, 0.0)) < 0.01


def test_range_circles_far_apart_propose_no_point() -> None:
    arc_measurements = simulated_arcs([corner(1.0, 0.0)], stations=np.array([[0.0, 0.0], [2.0, 0.0]]), late=-0.3)
    assert Kind.CORNER not in kinds(proposals(arc_measurements))


def test_points_behind_the_stations_are_not_proposed() -> None:
    # Two range circles meet twice; only the crossing in front of both stations is a candidate.
    candidates = proposals(simulated_arcs([corner(1.0, 1.0)], stations=np.array([[0.0, 0.0], [1.0, 0.0]])))
    corners = candidates[candidates[:, 0] == Kind.CORNER]
    assert corners == pytest.approx(corner(1.0, 1.0)[None])


def test_only_the_given_radii_are_tried() -> None:
    arc_measurements = simulated_arcs([cylinder(1.0, 0.5, 0.1)])
    candidates = propose_hypotheses(arc_measurements, np.ones(3, dtype=bool), CandidateSettings(radii=(0.1, 0.3)))
    assert set(candidates[candidates[:, 0] == Kind.CYLINDER, 3]) <= {0.1, 0.3}
    assert distance(candidates, cylinder(1.0, 0.5, 0.1)) < 1e-6


def test_pairs_without_a_new_arc_are_skipped() -> None:
    arc_measurements = simulated_arcs([corner(1.5, 1.0)])
    assert len(proposals(arc_measurements, fresh=[False] * 3)) == 0
    assert distance(proposals(arc_measurements, fresh=[False, False, True]), corner(1.5, 1.0)) < 1e-6


def test_equal_candidates_are_merged() -> None:
    candidates = proposals(simulated_arcs([wall(0.4, 1.5)]))
    # Three planes and three pairs suggest the same wall.
    assert (candidates[:, 0] == Kind.WALL).sum() == 1


def test_the_candidates_of_most_pairs_are_kept() -> None:
    arc_measurements = simulated_arcs([wall(0.4, 1.5), wall(2.2, 1.9)])
    first = proposals(arc_measurements, fresh=[True, False, True, False, True, False])
    few = proposals(arc_measurements, fresh=[True, True, True, False, True, False], max_candidates=1)
    assert distance(first, wall(0.4, 1.5)) < 1e-6
    assert max((few[:, 0] == kind).sum() for kind in Kind) == 1
    assert distance(few, wall(0.4, 1.5)) < 1e-6


def round_arcs(stations: FloatArray, *, turn: float = 0.0) -> ArcMeasurements:
    """Return the arcs of a round wall of 2 m about (0.3, -0.2): nearest and farthest point from each station."""
    rows = []
    for number, center in enumerate(stations):
        away = center - (0.3, -0.2)
        for side in (1.0, -1.0):
            angle = np.arctan2(side * away[1], side * away[0]) + turn * (-1) ** number
            depth = 2.0 - side * np.hypot(*away)
            rows.append([number, *center, angle, depth + center @ directions(angle)])
    table = np.array(rows)
    return ArcMeasurements(
        stations=table[:, 0].astype(int),
        centers=table[:, 1:3],
        planes=table[:, 3:],
        pings=np.full(len(table), 9),
    )


def test_arcs_of_five_stations_suggest_a_round_wall() -> None:
    stations = np.array([[0.9, 0.4], [-0.6, 0.8], [0.2, -1.4], [1.4, -0.9], [-0.9, -0.5]])
    candidates = proposals(round_arcs(stations, turn=np.radians(4.0)))
    assert distance(candidates, round_wall(0.3, -0.2, 2.0)) < 0.02


def test_arcs_of_four_stations_do_not_suggest_a_round_wall() -> None:
    stations = np.array([[0.9, 0.4], [-0.6, 0.8], [0.2, -1.4], [1.4, -0.9]])
    assert Kind.ROUND not in kinds(proposals(round_arcs(stations)))


def test_a_rectangular_room_suggests_no_round_wall() -> None:
    rng = np.random.default_rng(4)
    room = [
        wall(turn, away) for turn, away in zip(np.radians([0.0, 90.0, 180.0, -90.0]), (2.0, 1.5, 2.0, 1.5), strict=True)
    ]
    assert Kind.ROUND not in kinds(proposals(simulated_arcs(room, stations=rng.uniform(-1.0, 1.0, (12, 2)))))


def test_the_depth_of_a_station_beyond_a_plane_is_bounded() -> None:
    arc_measurements = ArcMeasurements(
        stations=np.array([0, 0]),
        centers=np.array([[0.0, 0.0], [2.0, 0.0]]),
        planes=np.array([[0.0, 1.5], [0.0, 1.5]]),
        pings=np.array([9, 9]),
    )
    assert arc_measurements.depths == pytest.approx([1.5, 0.03])
