"""Shared errors of the readings of one landmark from one station are estimated from residuals."""

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.joint.optimisation.factors import LinearFactor, normal_equations
from echoplan.joint.optimisation.solver import solve
from echoplan.joint.optimisation.variance_components import map_scale_factor
from echoplan.joint.pose_correction.random_effects import common_squares

NOISE, GUESS, SPREAD = 0.002, 0.012, 1.15
FEATURES, STATIONS, READINGS = 6, 30, 10


def detected(common: float, seed: int) -> LinearFactor:
    """Return range factors of walls and stations with two coordinates, with independent and shared errors."""
    rng = np.random.default_rng(seed)
    feature, station = (each.repeat(READINGS) for each in np.indices((FEATURES, STATIONS)).reshape(2, -1))
    shared = common * rng.standard_normal(FEATURES * STATIONS).repeat(READINGS)
    angles = feature * 2.0 * np.pi / FEATURES
    places = FEATURES + 2 * station
    jacobian = np.column_stack([np.ones(len(feature)), np.cos(angles), np.sin(angles)])
    residuals = shared + NOISE * rng.standard_normal(len(feature))
    columns = np.column_stack([feature, places, places + 1])
    return LinearFactor(columns, jacobian, residuals, np.full(len(feature), NOISE**-2.0))


def solution(rows: LinearFactor, common: float) -> tuple[LinearFactor, FloatArray]:
    """Return the residuals after the solution of landmarks and poses, which have priors of 1 m, and the covariance."""
    capped = rows._replace(weights=rows.weights / (1.0 + READINGS * NOISE**-2.0 * common**2))
    size = FEATURES + 2 * STATIONS
    information, right = normal_equations([capped], size)
    covariance = solve(information + np.eye(size), np.eye(size))
    step = covariance @ right
    left = rows.residuals - np.sum(rows.jacobian * step[rows.columns], axis=1)
    return rows._replace(residuals=left), covariance


def estimated_sigma(common: float, seed: int = 1) -> float:
    rows, sigma = detected(common, seed), GUESS
    for _ in range(30):
        squares, count = common_squares(*solution(rows, sigma), common=sigma)
        sigma = GUESS * float(map_scale_factor(squares / GUESS**2, count, SPREAD))
    return sigma


@pytest.mark.parametrize("common", [0.003, 0.012, 0.03])
def test_shared_errors_are_estimated_although_poses_absorb_part_of_them(common: float) -> None:
    assert np.mean([estimated_sigma(common, seed) for seed in range(4)]) == pytest.approx(common, rel=0.1)


def test_independent_errors_are_not_taken_for_shared_ones() -> None:
    assert estimated_sigma(0.0) < 0.3 * NOISE


def test_an_effect_that_nothing_absorbs_is_shrunk_by_its_share_of_the_variance() -> None:
    rows = detected(0.01, 2)
    squares, count = common_squares(rows, np.zeros((FEATURES + 2 * STATIONS,) * 2), common=0.01)
    effects = FEATURES * STATIONS
    # Ten readings determine all but about one hundredth of an effect that is five times their noise.
    share = 0.01**2 / (0.01**2 + NOISE**2 / READINGS)
    assert count == pytest.approx(effects * share)
    means = rows.residuals.reshape(effects, READINGS).mean(axis=1)
    assert squares == pytest.approx(share**2 * float(means @ means))


def test_an_effect_that_poses_absorb_does_not_count() -> None:
    # One landmark per station, and two coordinates of the station that absorb its residual.
    rows = detected(0.01, 3)
    own = rows.columns[:, 0] == 0
    single = LinearFactor(rows.columns[own], rows.jacobian[own], rows.residuals[own], rows.weights[own])
    _, count = common_squares(*solution(single, 0.01), common=0.01)
    assert count == pytest.approx(0.0, abs=1e-3 * STATIONS)
