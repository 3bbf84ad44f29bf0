from dataclasses import replace

import numpy as np
import pytest

from echoplan.acoustics.predicted_echo import Kind
from echoplan.joint.known_map import known_landmarks, prior_of_map
from echoplan.joint.optimisation.layout import SONAR_UNKNOWNS
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
