"""GTSAM as reference: the same factors in another program have the same minimum and covariances."""

from typing import Any

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.geometry import compose, directions, invert, wrap
from echoplan.joint.optimisation.factors import LinearFactor, normal_equations
from echoplan.joint.optimisation.pose_factors import PoseSettings, odometry_prior, pose_factors
from echoplan.joint.optimisation.solver import solve

TRUE = np.array([[0.0, 0, 0], [0.8, 0.1, 0.6], [1.3, 0.8, 1.7], [0.9, 1.6, 2.9], [0.1, 1.4, -2.2], [0.2, 0.5, -1.0]])
WALLS = np.array([[0.0, 2.5], [np.pi / 2, 2.2], [np.pi, 1.0], [-1.4, 0.9]])
DEPTH, NORMAL = 0.005, np.radians(0.5)
POSES, FIRST = len(TRUE), 2 * len(WALLS)
_KEYS = range(100, 100 + POSES)


def measured_poses() -> FloatArray:
    """Return poses by noisy dead reckoning."""
    rng, poses = np.random.default_rng(5), [TRUE[0]]
    for step in compose(invert(TRUE[:-1]), TRUE[1:]):
        poses.append(compose(poses[-1], step + rng.normal(0.0, [0.02, 0.01, 0.05])))
    return np.array(poses)


PRIORS = odometry_prior(measured_poses(), PoseSettings())


def arc_measurements() -> FloatArray:
    """Return depth [m] and direction [rad] of each wall from each pose, shape (poses, walls, 2)."""
    rng = np.random.default_rng(6)
    exact = np.array([[expected(pose, wall) for wall in WALLS] for pose in TRUE])
    seen: FloatArray = exact + rng.normal(0.0, [DEPTH, NORMAL], exact.shape)
    return seen


def expected(pose: FloatArray, wall: FloatArray) -> FloatArray:
    return np.array([wall[1] - pose[:2] @ directions(wall[0]), wrap(wall[0] - pose[2])])


def jacobian(pose: FloatArray, wall: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the derivatives of depth and direction by the wall and by the pose."""
    normal, along = directions(wall[0]), directions(wall[0] + np.pi / 2)
    by_wall = np.array([[-pose[:2] @ along, 1.0], [1.0, 0.0]])
    return by_wall, np.array([[-normal[0], -normal[1], 0.0], [0.0, 0.0, -1.0]])


def own_solution() -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return walls, poses and covariance by the factors and the solver of the project."""
    walls, poses, seen = WALLS.copy(), PRIORS.measured_poses.copy(), arc_measurements()
    for _ in range(20):
        rows = [pose_factors(PRIORS, poses, FIRST)]
        for k, pose in enumerate(poses):
            for j, wall in enumerate(walls):
                residuals = seen[k, j] - expected(pose, wall)
                residuals[1] = wrap(residuals[1])
                columns = np.concatenate([2 * j + np.arange(2), FIRST + 3 * k + np.arange(3)])
                derivatives = np.concatenate(jacobian(pose, wall), axis=1)
                rows.append(
                    LinearFactor(np.tile(columns, (2, 1)), derivatives, residuals, np.array([DEPTH, NORMAL]) ** -2)
                )
        information, right = normal_equations(rows, FIRST + 3 * POSES)
        step = solve(information, right)
        walls, poses = walls + step[:FIRST].reshape(-1, 2), poses + step[FIRST:].reshape(-1, 3)
    covariance: FloatArray = np.linalg.inv(information).astype(np.float64)
    return walls, poses, covariance


def gtsam_solution(gtsam: Any) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the same by GTSAM, with custom factors; poses and walls are vectors."""
    graph, start = gtsam.NonlinearFactorGraph(), gtsam.Values()
    for j, wall in enumerate(WALLS):
        start.insert(j, wall)
    for k, pose in enumerate(PRIORS.measured_poses):
        start.insert(100 + k, pose)
        noise = gtsam.noiseModel.Diagonal.Sigmas(PRIORS.sigmas[k])
        graph.add(gtsam.CustomFactor(noise, [100] if k == 0 else [99 + k, 100 + k], pose_factor_error(k)))
        for j in range(len(WALLS)):
            noise = gtsam.noiseModel.Diagonal.Sigmas(np.array([DEPTH, NORMAL]))
            graph.add(gtsam.CustomFactor(noise, [j, 100 + k], arc_factor_error(arc_measurements()[k, j])))
    parameters = gtsam.LevenbergMarquardtParams()
    parameters.setRelativeErrorTol(1e-14)
    parameters.setAbsoluteErrorTol(1e-14)
    found = gtsam.LevenbergMarquardtOptimizer(graph, start, parameters).optimize()
    marginals = gtsam.Marginals(graph, found)
    walls, poses = (
        [found.atVector(first + k) for k in range(count)] for first, count in ((0, len(WALLS)), (100, POSES))
    )
    return np.array(walls), np.array(poses), np.array([marginals.marginalCovariance(100 + k) for k in range(POSES)])


def pose_factor_error(k: int) -> Any:
    def error(_: Any, values: Any, jacobians: list[FloatArray] | None) -> FloatArray:
        poses = np.array([values.atVector(100 + each) for each in ([0] if k == 0 else [k - 1, k])])
        if k == 0:
            return with_numeric_jacobian(lambda own: own[0] - PRIORS.measured_poses[0], poses, jacobians)
        measured = compose(invert(PRIORS.measured_poses[k - 1]), PRIORS.measured_poses[k])
        # Along and across the direction of travel, whatever the heading.
        x, y = measured[:2] / np.hypot(measured[0], measured[1])
        axes = np.array([[x, y, 0.0], [-y, x, 0.0], [0.0, 0.0, 1.0]])
        return with_numeric_jacobian(
            lambda both: axes @ wrapped(compose(invert(both[0]), both[1]) - measured), poses, jacobians
        )

    return error


def arc_factor_error(seen: FloatArray) -> Any:
    def error(factor: Any, values: Any, jacobians: list[FloatArray] | None) -> FloatArray:
        wall, pose = (values.atVector(key) for key in [*factor.keys()])
        if jacobians is not None:
            jacobians[0], jacobians[1] = jacobian(pose, wall)
        off = expected(pose, wall) - seen
        off[1] = wrap(off[1])
        return off

    return error


def with_numeric_jacobian(function: Any, poses: FloatArray, jacobians: list[FloatArray] | None) -> FloatArray:
    """Return a residual, with a numeric Jacobian that does not depend on the code under test."""
    if jacobians is not None:
        for which in range(len(poses)):
            columns = []
            for axis in range(3):
                step = np.zeros_like(poses)
                step[which, axis] = 1e-6
                columns.append((function(poses + step) - function(poses - step)) / 2e-6)
            jacobians[which] = np.column_stack(columns)
    error: FloatArray = function(poses)
    return error


def wrapped(step: FloatArray) -> FloatArray:
    return np.array([step[0], step[1], float(wrap(step[2]))])


def test_the_same_factors_have_the_same_minimum_and_covariances() -> None:
    gtsam = pytest.importorskip("gtsam", reason="gtsam is not installed")
    walls, poses, covariance = own_solution()
    their_walls, their_poses, their_covariances = gtsam_solution(gtsam)
    assert walls == pytest.approx(their_walls, abs=1e-6)
    assert np.abs(poses[:, :2] - their_poses[:, :2]).max() < 1e-6
    assert np.abs(wrap(poses[:, 2] - their_poses[:, 2])).max() < 1e-6
    blocks = [covariance[k : k + 3, k : k + 3] for k in range(FIRST, FIRST + 3 * POSES, 3)]
    for own, their in zip(blocks, their_covariances, strict=True):
        assert own == pytest.approx(their, rel=1e-4, abs=1e-12)
