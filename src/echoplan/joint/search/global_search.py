"""Global scan matching: the poses at which a sweep fits a map, without any guess."""

import math

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.geometry import wrap
from echoplan.joint.search.scan_matching import LandmarkMap, LocalisationSettings, LocalScan, locate, score_poses

__all__ = ["SAME_PLACE", "SAME_POSE", "apart", "find_poses", "pose_grid"]

# Steps of the grid of poses [m, rad].
_STEP, _TURN = 0.15, math.radians(6.0)
# Standard deviations of depths and normals on the grid [m, rad]: the nearest pose of the grid is off by as much.
_TOLERANCES = (0.08, math.radians(4.0))
# Standard deviations in which a pose of the grid is refined [m, m, rad]: three of them reach the next one.
_STEP_SIGMAS = np.array([_STEP / 3.0, _STEP / 3.0, _TURN / 3.0])
# Poses nearer to each other than this are the same [m, rad]: the two faces of a partition are farther apart, and a
# station may fit either. Such poses, however, are at one place.
SAME_POSE, SAME_PLACE = (0.05, math.radians(5.0)), (0.3, math.radians(15.0))
# Number of poses that are refined, and that are kept.
_MAX_REFINED, _MAX_FOUND = 240, 120
# Number of poses that are compared in some ten seconds: in 1500 square metres.
_MAX_GRID = 4_000_000


def pose_grid(points_xy: FloatArray) -> FloatArray:
    """Return poses all over the rectangle about some points, in all directions, shape (p, 3) [m, m, rad].

    The rectangle is empty if they would be too many.
    """
    low, high = points_xy.min(axis=0), points_xy.max(axis=0)
    axes = [np.arange(first, last + _STEP, _STEP) for first, last in zip(low, high, strict=True)]
    turns = np.arange(-math.pi, math.pi, _TURN)
    if len(axes[0]) * len(axes[1]) * len(turns) > _MAX_GRID:
        return np.zeros((0, 3))
    return np.stack(np.meshgrid(*axes, turns, indexing="ij"), axis=-1).reshape(-1, 3)


def find_poses(
    scan: LocalScan, landmark_map: LandmarkMap, *, grid: FloatArray, settings: LocalisationSettings
) -> tuple[FloatArray, FloatArray]:
    """Return poses that fit, shape (h, 3) [m, m, rad], the best first, and their log-likelihoods, shape (h,) [nats].

    They are the best ones of a grid of shape (p, 3), each refined.
    """
    scores = score_poses(scan, landmark_map, poses=grid, tolerances=_TOLERANCES, settings=settings)
    coarse = [each for each in apart(grid, scores, most=_MAX_REFINED) if scores[each] > 0.0]
    if not coarse:
        return np.zeros((0, 3)), np.zeros(0)
    found = [locate(scan, landmark_map, grid[each], _STEP_SIGMAS, settings) for each in coarse]
    poses, refined = np.array([pose for pose, _ in found]), np.array([score for _, score in found])
    kept = apart(poses, refined, most=_MAX_FOUND)
    return poses[kept], refined[kept]


def apart(poses: FloatArray, scores: FloatArray, *, most: int, same: tuple[float, float] = SAME_POSE) -> list[int]:
    """Return the indices of the best poses that differ from all better ones, the best first; at most ``most``.

    Those nearer to each other than ``same`` [m, rad] do not differ.
    """
    kept: list[int] = []
    for index in np.argsort(-scores, kind="stable"):
        if len(kept) == most:
            break
        away = poses[kept] - poses[index]
        near = np.hypot(away[:, 0], away[:, 1]) < same[0]
        if not (near & (np.abs(wrap(away[:, 2])) < same[1])).any():
            kept.append(int(index))
    return kept
