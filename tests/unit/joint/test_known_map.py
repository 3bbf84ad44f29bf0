from dataclasses import replace

import numpy as np
import pytest

from echoplan.acoustics.predicted_echo import Kind
from echoplan.joint.known_map import known_landmarks, prior_of_map, resumed, views_of, without_walls
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.ping_scores import NO_PING_SCORES
from echoplan.joint.likelihood.track_history import LineEvidence, TrackHistory
from echoplan.joint.map_extraction.endpoint_views import OFFSETS
from echoplan.joint.map_extraction.segments import SegmentSettings
from echoplan.joint.marginal_prior import MarginalPrior
from echoplan.joint.optimisation.factors import InformationPrior
from echoplan.joint.optimisation.layout import SONAR_UNKNOWNS
from echoplan.model import CornerKind
from helpers import maps

COVARIANCE = np.diag([2e-3, 1e-3]) ** 2


def test_walls_on_one_line_are_one_landmark() -> None:
    left = maps.wall([0.0, 2.0], [1.0, 2.0], covariance=COVARIANCE)
    right = replace(left, endpoints_xy=left.endpoints_xy + np.array([1.9, 0.0]))
    (wall,), (covariance,) = known_landmarks(maps.drawn(left, right))
    assert wall.kind is Kind.WALL
    places = sorted(wall.ends_xy[:, 0].tolist())
    assert places == pytest.approx([0.0, 2.9])
    assert np.array_equal(covariance, COVARIANCE)


def test_parallel_walls_are_separate_landmarks() -> None:
    front, back = maps.wall([0.0, 2.0], [1.0, 2.0]), maps.wall([0.0, 2.1], [1.0, 2.1])
    opposite = maps.wall([1.0, 2.0], [0.0, 2.0])
    landmarks, _ = known_landmarks(maps.drawn(front, back, opposite))
    assert [each.reflector[1:3].round(6).tolist() for each in landmarks] == [
        [round(wall.normal_angle, 6), round(wall.offset, 6)] for wall in (front, back, opposite)
    ]


def test_the_extent_of_a_wall_is_that_of_all_its_parts_whatever_their_direction() -> None:
    # Three parts of an oblique line, from -2 to 0, from 0.5 to 1 and from 3 to 4 m along it.
    along, foot = np.array([0.6, 0.8]), np.array([1.0, -2.0])
    first = maps.wall(foot - 2.0 * along, foot)
    parts = [replace(first, endpoints_xy=foot + np.outer(ends, along)) for ends in ([4.0, 3.0], [0.5, 1.0])]
    (wall,), _ = known_landmarks(maps.drawn(parts[0], first, parts[1]))
    assert np.sort(wall.ends_xy, axis=0) == pytest.approx(np.sort([foot - 2.0 * along, foot + 4.0 * along], axis=0))


def test_a_landmark_is_as_soft_as_its_wall() -> None:
    (wall,), _ = known_landmarks(maps.drawn(replace(maps.wall([0.0, 2.0], [1.0, 2.0]), reflection_loss=6.0)))
    assert wall.reflector[3] == 6.0


def test_a_convex_corner_is_an_edge() -> None:
    convex = replace(maps.corner([1.0, 1.0]), kind=CornerKind.CONVEX, pings=1)
    (edge,), _ = known_landmarks(maps.drawn(convex))
    assert edge.kind is Kind.EDGE


def test_a_cylinder_has_its_centre_radius_and_covariance() -> None:
    covariance = np.diag([1e-3, 2e-3, 3e-3]) ** 2
    column = replace(maps.cylinder([0.5, -1.5], 0.1), covariance=covariance)
    (landmark,), (own,) = known_landmarks(maps.drawn(column))
    assert landmark.reflector.tolist() == [Kind.CYLINDER, 0.5, -1.5, 0.1]
    assert np.array_equal(own, covariance)


def test_a_map_without_features_has_no_landmarks() -> None:
    assert known_landmarks(maps.drawn(maps.corner([1.0, 1.0]))) == ([], [])


def test_corners_count_only_if_they_were_detected() -> None:
    crossing, detected = maps.corner([1.0, 1.0]), replace(maps.corner([2.0, 1.0]), pings=7)
    landmarks, _ = known_landmarks(maps.drawn(crossing, detected, maps.cylinder([0.5, 0.5], 0.1)))
    assert [each.kind for each in landmarks] == [Kind.CORNER, Kind.CYLINDER]
    assert landmarks[0].reflector[1:3].tolist() == [2.0, 1.0]
    assert all(each.is_known for each in landmarks)


def test_the_prior_has_the_landmarks_and_the_first_pose() -> None:
    wall = maps.wall([0.0, 2.0], [1.0, 2.0], covariance=COVARIANCE)
    pose = np.array([0.5, 1.0, 0.2])
    prior = prior_of_map(maps.drawn(wall), pose, noise=0.004)
    assert prior.rest == len(SONAR_UNKNOWNS) + 3
    assert np.linalg.inv(prior.summary.information[:2, :2]) == pytest.approx(COVARIANCE, abs=2e-8)
    # Nothing is known about the sonar.
    assert not prior.summary.information[2:-3].any()
    mean = np.linalg.solve(prior.summary.information[-3:, -3:], prior.summary.vector[-3:])
    assert mean == pytest.approx(pose)
    assert prior.poses.tolist() == [pose.tolist()]


def test_a_map_without_uncertainties_is_not_exact() -> None:
    wall = maps.wall([0.0, 2.0], [1.0, 2.0], covariance=np.zeros((2, 2)))
    information = prior_of_map(maps.drawn(wall), np.zeros(3), noise=0.004).summary.information
    assert np.isfinite(information).all()


def whole_prior() -> MarginalPrior:
    """The prior of a map of two walls, a detected corner and a cylinder."""
    features = (
        maps.wall([0.0, 2.0], [1.0, 2.0], covariance=[[4e-6, 1e-6], [1e-6, 1e-6]]),
        maps.wall([3.0, 0.0], [3.0, 2.0], covariance=COVARIANCE),
        replace(maps.corner([2.0, 1.0], sigma=0.003), pings=7),
        maps.cylinder([0.5, 0.5], 0.1, sigma=0.004),
    )
    return prior_of_map(maps.drawn(*features), np.array([0.5, 1.0, 0.2]), noise=0.004)


def correlated(prior: MarginalPrior) -> MarginalPrior:
    """The same landmarks and first pose, all correlated with each other and with the sonar, as after a recording."""
    size = len(prior.summary.columns)
    root = np.random.default_rng(3).normal(size=(size, size + 3))
    information = root @ root.T
    return replace(prior, summary=InformationPrior(np.arange(size), information, information @ np.arange(size)))


def test_the_prior_is_the_map_with_its_uncertainties() -> None:
    prior = whole_prior()
    landmarks, covariances = prior.features, [np.array([[4e-6, 1e-6], [1e-6, 1e-6]]), COVARIANCE]
    covariances += [0.003**2 * np.eye(2), 0.004**2 * np.eye(3)]
    information, start = prior.summary.information, 0
    for landmark, covariance in zip(landmarks, covariances, strict=True):
        own = slice(start, start + len(covariance))
        assert np.linalg.inv(information[own, own]) == pytest.approx(covariance, abs=2e-8)
        assert np.linalg.solve(information[own, own], prior.summary.vector[own]) == pytest.approx(landmark.parameters)
        # Covariances between landmarks are not in a map.
        assert np.count_nonzero(information[own]) == np.count_nonzero(information[own, own])
        start = own.stop
    assert start == 9
    assert prior.is_known_map


def test_each_landmark_of_the_prior_has_a_number_of_its_own() -> None:
    prior = whole_prior()
    numbers = [each.history.number for each in prior.features]
    assert len(set(numbers)) == len(numbers) == 4
    # A new landmark gets the next number.
    assert max(numbers) <= prior.issued


def test_another_recording_goes_on_with_the_joint_information_about_the_landmarks() -> None:
    prior, pose = correlated(whole_prior()), np.array([2.0, 0.5, -1.0])
    after = resumed(prior, pose, SegmentSettings())
    information, covariance = after.summary.information, np.linalg.inv(prior.summary.information)
    assert np.linalg.inv(information[:9, :9]) == pytest.approx(covariance[:9, :9], rel=1e-6)
    assert np.linalg.solve(information[:9, :9], after.summary.vector[:9]) == pytest.approx(np.arange(9.0), abs=1e-6)
    assert [each.history.number for each in after.features] == [each.history.number for each in prior.features]


def test_another_recording_begins_with_its_own_pose_and_an_unknown_sonar() -> None:
    pose = np.array([2.0, 0.5, -1.0])
    after = resumed(correlated(whole_prior()), pose, SegmentSettings())
    information, vector = after.summary.information, after.summary.vector
    assert after.rest == len(SONAR_UNKNOWNS) + 3
    assert not information[9:-3].any()
    assert not information[-3:, :-3].any()
    assert np.linalg.solve(information[-3:, -3:], vector[-3:]) == pytest.approx(pose)
    assert after.poses.tolist() == [pose.tolist()]


def line(extent: tuple[float, float], *, walls: tuple[tuple[float, float], ...], number: int) -> Hypothesis:
    """Return a line along y at x = 2 that stations detected where it is wall, and missed elsewhere."""
    feet = np.linspace(*extent, 21)
    is_wall = np.any([(low <= feet) & (feet <= high) for low, high in walls], axis=0)
    # It is decided by a wall at the foot, which ends behind it.
    ratios = np.where(is_wall, 50.0, -12.0)[:, None, None] * np.where(OFFSETS < 0.0, np.ones((2, 1)), 0.0)
    evidence = LineEvidence(feet, np.column_stack([np.zeros(len(feet)), feet]), ratios)
    history = TrackHistory(number=number, llr=900.0, best_llr=100.0, supporting=8, extent=extent, line=evidence)
    return Hypothesis(
        reflector=np.array([Kind.WALL, 0.0, 2.0, 0.0]),
        ping_scores=NO_PING_SCORES,
        llr_by_station=np.zeros(0),
        llr=900.0,
        extent=extent,
        history=history,
    )


@pytest.mark.parametrize(
    ("walls", "movable"),
    [(((0.0, 2.0),), True), (((0.0, 0.7), (1.5, 2.0)), False), (((0.3, 1.7),), True), (((0.0, 1.4),), False)],
)
def test_what_is_one_piece_may_have_been_moved_since_another_recording(
    walls: tuple[tuple[float, float], ...], *, movable: bool
) -> None:
    known, path_xy = InformationPrior(np.arange(2), np.eye(2), np.zeros(2)), np.array([[0.0, 0.0], [0.0, 2.0]])
    prior = MarginalPrior(features=[line((0.0, 2.0), walls=walls, number=1)], summary=known, path_xy=path_xy)
    (after,) = resumed(prior, np.zeros(3), SegmentSettings()).features
    assert (after.llr < 900.0) is movable
    # Two stations that miss it remove it, one does not.
    assert not movable or after.llr - 24.0 <= 12.0 < after.llr - 12.0
    assert after.history.llr == after.llr


def test_lines_of_sight_end_at_the_walls_that_they_detected() -> None:
    views = views_of(replace(whole_prior(), features=[line((0.0, 2.0), walls=((0.0, 2.0),), number=1)]))
    assert np.allclose(views[:, 0, 0], 0.0)
    assert np.allclose(views[:, 1, 0], 2.0)
    assert np.allclose(views[:, 0, 1], views[:, 1, 1])
    assert len(views) == 21


@pytest.mark.parametrize(
    ("ends", "left", "llr"),
    [
        # One of two walls on the line, both, one on another line, and one behind it.
        (([2.0, 0.0], [2.0, 0.7]), [(1.5, 2.0)], 900.0),
        (([2.0, 0.0], [2.0, 2.0]), [], 0.0),
        (([2.1, 0.0], [2.1, 2.0]), [(0.0, 0.7), (1.5, 2.0)], 900.0),
        (([2.0, 2.0], [2.0, 0.0]), [(0.0, 0.7), (1.5, 2.0)], 900.0),
    ],
)
def test_what_was_detected_of_a_wall_can_be_forgotten(
    ends: tuple[list[float], list[float]], left: list[tuple[float, float]], llr: float
) -> None:
    landmark = line((0.0, 2.0), walls=((0.0, 0.7), (1.5, 2.0)), number=1)
    landmark = replace(landmark, history=replace(landmark.history, feet=np.array([0.1, 0.6, 1.6, 1.9])))
    prior = replace(whole_prior(), features=[landmark, *whole_prior().features])
    after, *others = without_walls(prior, [maps.wall(*ends)]).features
    assert (after.llr, after.history.llr) == (llr, llr)
    detected = after.history.line.feet[after.history.line.log_ratios[:, 0, 0] > 0.0]
    for places in (detected, after.history.feet):
        within = np.array([(low <= places) & (places <= high) for low, high in left]).reshape(len(left), len(places))
        assert within.any(axis=0).all()
        assert within.any(axis=1).all()
    assert [each.reflector.tolist() for each in others] == [each.reflector.tolist() for each in whole_prior().features]
