"""Covariances of estimated landmarks, compared with simulated errors."""

from dataclasses import replace

import numpy as np
import pytest

from echoplan.acoustics import typical_transducer
from echoplan.acoustics.predicted_echo import EchoModel, Kind
from echoplan.arrays import FloatArray
from echoplan.joint.optimisation.layout import SONAR_UNKNOWNS, Layout
from echoplan.joint.optimisation.solution import Solution
from helpers import scenes

UNKNOWNS = Layout(kinds=np.array([Kind.WALL, Kind.CYLINDER], dtype=np.int64), poses=0)
FEATURES = slice(0, UNKNOWNS.sonar)
RNG = np.random.default_rng(3)
# Jacobian of 40 readings of sigma 1, their information, and that of the priors.
SLOPES = RNG.normal(size=(40, UNKNOWNS.size))
MEASURED, HELD = SLOPES.T @ SLOPES, np.diag(RNG.uniform(2.0, 20.0, UNKNOWNS.size))


def solution(share: float) -> Solution:
    """Return a solution whose readings have a share of their full weight."""
    nothing = np.zeros(0)
    return Solution(
        reflectors=np.zeros((2, 4)),
        model=EchoModel.of(typical_transducer(scenes.rig().sensors[0])),
        latency=0.0,
        poses=np.zeros((0, 3)),
        layout=UNKNOWNS,
        information=share * MEASURED + HELD,
        measurement_information=share * MEASURED,
        information_inflation=1.0 / share,
        extents=np.zeros((2, 2)),
        owners=nothing.astype(np.int64),
        residuals=nothing,
        excesses=nothing,
        newton_decrement=0.0,
    )


def simulated_errors(share: float, draws: int) -> FloatArray:
    """Return simulated errors of landmarks with a known sonar, shape (draws, u)."""
    truths = RNG.normal(size=(draws, UNKNOWNS.sonar)) / np.sqrt(np.diag(HELD)[FEATURES])
    jacobian = SLOPES[:, FEATURES]
    readings = truths @ jacobian.T + RNG.normal(size=(draws, len(jacobian)))
    information = share * jacobian.T @ jacobian + HELD[FEATURES, FEATURES]
    return np.linalg.solve(information, share * jacobian.T @ readings.T).T - truths


def test_at_full_weight_the_covariance_is_the_inverse_information() -> None:
    assert solution(1.0).covariance == pytest.approx(np.linalg.inv(MEASURED + HELD))


def test_the_sandwich_covariance_agrees_with_simulated_errors() -> None:
    found = solution(0.25)
    known = np.diag(np.where(np.arange(UNKNOWNS.size) < UNKNOWNS.sonar, 0.0, 1e12))
    held = replace(found, information=found.information + known)
    errors = simulated_errors(0.25, 160_000)
    assert held.covariance[FEATURES, FEATURES] == pytest.approx(np.cov(errors.T), rel=0.05, abs=3e-4)


def test_sigmas_of_the_sonar_are_not_reduced_by_the_inflation() -> None:
    found = solution(0.25)
    sigmas = np.sqrt(np.diag(np.linalg.inv(found.information))[UNKNOWNS.sonar :])
    assert list(found.sonar_sigmas().values()) == pytest.approx(sigmas)
    assert len(sigmas) == len(SONAR_UNKNOWNS)


def test_the_sandwich_covariance_is_positive_definite_and_between_its_limits() -> None:
    full, quarter = solution(1.0).covariance, solution(0.25).covariance
    assert np.linalg.eigvalsh(quarter).min() > 0.0
    lone = replace(solution(0.25), information_inflation=1.0).covariance
    assert (np.diag(quarter)[FEATURES] < np.diag(lone)[FEATURES]).all()
    assert (np.diag(quarter)[FEATURES] > np.diag(full)[FEATURES]).all()


def test_the_covariance_of_landmarks_includes_the_floor_of_the_range_offset() -> None:
    free = solution(1.0)
    known = replace(free, offset_sigma=0.9)
    offset = UNKNOWNS.sonar
    assert known.sonar_sigmas()["range_offset"] == pytest.approx(0.9)
    # The part that is proportional to the offset grows; the covariance given the offset is unchanged.
    jacobian = free.covariance[:, offset] / free.covariance[offset, offset]
    rest = free.covariance - free.covariance[offset, offset] * np.outer(jacobian, jacobian)
    assert known.covariance == pytest.approx(rest + 0.81 * np.outer(jacobian, jacobian))
    assert replace(free, offset_sigma=1e-9).covariance == pytest.approx(free.covariance)


def test_the_covariance_of_landmarks_includes_the_model_error() -> None:
    free = replace(solution(1.0), extents=np.array([[-1.0, 3.0], [0.0, 0.0]]))
    added = replace(free, model_error=0.5).covariance - free.covariance
    wall, cylinder = UNKNOWNS.feature(0), UNKNOWNS.feature(1)
    assert added[cylinder, cylinder] == pytest.approx(0.25 * np.eye(3))
    ends = np.array([[1.0, 1.0], [-3.0, 1.0]])
    assert ends @ added[wall, wall] @ ends.T == pytest.approx(0.25 * np.eye(2))
    point = replace(free, model_error=0.5, extents=np.zeros((2, 2))).covariance
    assert np.isfinite(point).all()
