"""Scan matching: register the arcs of a sweep to known landmarks."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from echoplan.acoustics.predicted_echo import Kind, Shape, SonarTables, shape_of
from echoplan.arrays import BoolArray, FloatArray
from echoplan.compiled import compiled, inlined
from echoplan.geometry import compose, directions, wrap
from echoplan.joint.arcs import Arc, arc_planes
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.search.refinement import refine
from echoplan.preprocessing.measurements import Measurements

__all__ = ["LandmarkMap", "LocalScan", "LocalisationSettings", "best_score", "local_scans", "locate", "score_poses"]

_WALL, _ROUND = int(Kind.WALL), int(Kind.ROUND)
# A full turn [rad].
_CIRCLE = 2.0 * math.pi
# A wall may be detected up to this far beyond its extent [m].
_BESIDE = 0.5
# Gate on the depth and normal of an arc in standard deviations.
_FAR = 8.0
# Least standard deviation of a normal [rad].
_LEAST_TURN = math.radians(0.7)
# Greatest number of heading steps to either side, however long the lever arm: half a turn in steps of the above.
_MOST_TURNS = 256


class LocalisationSettings(NamedTuple):
    """Search for a pose by scan matching."""

    # Half width of the search for a pose, in standard deviations of odometry.
    search_sigmas: float = 3.0
    # Factor by which the search is wider where the wheels may have slipped.
    slip_inflation: float = 2.0
    # Number of grid steps to either side in each direction; far turns take more.
    steps: int = 7
    # Standard deviation of the depth of an arc at the coarsest level [m].
    depth_sigma: float = 0.025
    # Standard deviation of the normal of an arc at the coarsest level [rad].
    normal_sigma: float = np.radians(2.0)
    # Number of finer levels of the grid; each after the first halves the step.
    levels: int = 3
    # Likelihood of an arc that no landmark explains, relative to a perfect match.
    outlier_likelihood: float = 0.05


class LocalScan(NamedTuple):
    """Arcs of one sweep in the frame of the robot."""

    # Mean sensor position of each arc [m], shape (a, 2).
    origins_xy: FloatArray
    # Normal angles of the planes that explain the arcs [rad], shape (a,).
    normals: FloatArray
    # Distances of these planes [m], shape (a,).
    depths: FloatArray
    # Weights of the arcs, at most 1, shape (a,).
    weights: FloatArray


class LandmarkMap(NamedTuple):
    """Landmarks to which arcs are registered."""

    # Kind and parameters in the ``map`` frame, shape (f, 4).
    reflectors: FloatArray
    # Weights of the landmarks, at most 1, shape (f,).
    weights: FloatArray
    # Ends of walls along their lines [m], shape (f, 2).
    extents: FloatArray
    # Middle and half of the width of the directions from which each can be detected [rad], shape (f, 2).
    fronts: FloatArray

    @classmethod
    def of(cls, features: Sequence[Hypothesis], centers_xy: FloatArray) -> "LandmarkMap":
        """Return the map of landmarks, all of weight 1; ``centers_xy`` are those of the stations [m], shape (s, 2)."""
        return cls(
            np.array([each.reflector for each in features]).reshape(-1, 4),
            np.ones(len(features)),
            np.array([each.extent for each in features]).reshape(-1, 2),
            np.array([each.front(centers_xy) for each in features]).reshape(-1, 2),
        )


def local_scans(arcs: list[Arc], measurements: Measurements, tables: SonarTables, pose: FloatArray) -> LocalScan:
    """Return the arcs of one sweep as planes in the frame of the robot.

    ``pose`` is the one from which ``measurements`` were computed: (x, y, yaw) [m, m, rad].
    """
    if not arcs:
        return LocalScan(np.zeros((0, 2)), np.zeros(0), np.zeros(0), np.zeros(0))
    planes = arc_planes(arcs, measurements, tables)
    normals, depths, origins = np.zeros(len(arcs)), np.zeros(len(arcs)), np.zeros((len(arcs), 2))
    for number, (arc, plane) in enumerate(zip(arcs, planes, strict=True)):
        wall = np.array([Kind.WALL, plane[0], plane[1], 0.0])
        wall = refine(measurements, tables, wall, arc.pings, (0.006, 0.03), 4)
        origins[number] = measurements.x[arc.pings].mean(), measurements.y[arc.pings].mean()
        normals[number] = wall[1]
        depths[number] = wall[2] - origins[number] @ directions(wall[1])
    turned = np.exp(-1j * pose[2]) * ((origins[:, 0] - pose[0]) + 1j * (origins[:, 1] - pose[1]))
    weights = np.minimum(1.0, np.array([measurements.weights[arc.pings].sum() for arc in arcs]) / 8.0)
    return LocalScan(np.column_stack([turned.real, turned.imag]), wrap(normals - pose[2]), depths, weights)


def locate(
    scan: LocalScan,
    landmark_map: LandmarkMap,
    guess: FloatArray,
    sigmas: FloatArray,
    settings: LocalisationSettings,
) -> tuple[FloatArray, float]:
    """Return the pose (x, y, yaw) [m, m, rad] that matches the arcs best to landmarks, and its log-likelihood [nats].

    The pose is searched from coarse to fine about ``guess``, within some ``sigmas`` along, across and in yaw [m, m,
    rad]. Without arcs or landmarks the guess is returned with 0 nats.
    """
    best, score = guess, 0.0
    if not len(scan.depths) or not len(landmark_map.reflectors):
        return best, score
    span, steps = settings.search_sigmas * sigmas, np.full(3, settings.steps)
    # The least change of heading that the arcs resolve, by their normals or their positions.
    lever = math.sqrt(float(np.mean(np.sum(scan.origins_xy**2, axis=1))))
    resolution = min(settings.normal_sigma, settings.depth_sigma / max(lever, 1e-6))
    turns = math.ceil(span[2] / (2.0 * resolution))
    steps[2] = max(settings.steps, min(turns, _MOST_TURNS))
    scale, narrowing = np.ones(3), 1.0
    for turn in range(settings.levels + 1):
        axes = [np.linspace(-1.0, 1.0, 2 * each + 1) for each in (steps if turn == 0 else np.full(3, 3)).tolist()]
        offsets = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3) * (span * scale)
        poses = compose(np.broadcast_to(best, offsets.shape), offsets)
        tolerances = max(settings.depth_sigma * narrowing, 0.008), max(settings.normal_sigma * narrowing, _LEAST_TURN)
        reach = span * scale
        likely = _likely(scan, landmark_map, best, (math.hypot(reach[0], reach[1]), reach[2]), tolerances)
        scores = _scores(scan, landmark_map, poses, likely, tolerances, settings.outlier_likelihood)
        scores -= 0.5 * _misfit(poses, guess, sigmas)
        place = int(np.argmax(scores))
        best, score = poses[place], float(scores[place])
        scale = scale / (steps / 2.0 if turn == 0 else 2.0)
        narrowing /= settings.steps / 2.0 if turn == 0 else 2.0
    return best, score


def score_poses(
    scan: LocalScan,
    landmark_map: LandmarkMap,
    *,
    poses: FloatArray,
    tolerances: tuple[float, float],
    settings: LocalisationSettings,
) -> FloatArray:
    """Return the log-likelihood of the arcs at poses of shape (p, 3) [m, m, rad], shape (p,) [nats].

    ``tolerances`` are the standard deviations of depths [m] and normals [rad].
    """
    every: BoolArray = np.ones((len(scan.depths), len(landmark_map.reflectors)), dtype=bool)
    scores: FloatArray = _scores(scan, landmark_map, poses, every, tolerances, settings.outlier_likelihood)
    return scores


def best_score(scan: LocalScan, settings: LocalisationSettings) -> float:
    """Return the log-likelihood of a perfect match of all arcs in the predicted pose [nats]."""
    return float(scan.weights.sum()) * math.log1p(1.0 / settings.outlier_likelihood)


def _misfit(poses: FloatArray, guess: FloatArray, sigmas: FloatArray) -> FloatArray:
    """Return the squared Mahalanobis distances of poses from the prediction."""
    away = np.exp(-1j * guess[2]) * ((poses[:, 0] - guess[0]) + 1j * (poses[:, 1] - guess[1]))
    turned = wrap(poses[:, 2] - guess[2])
    misfit: FloatArray = (away.real / sigmas[0]) ** 2 + (away.imag / sigmas[1]) ** 2 + (turned / sigmas[2]) ** 2
    return misfit


@compiled
def _likely(
    scan: LocalScan,
    landmark_map: LandmarkMap,
    pose: FloatArray,
    span: tuple[float, float],
    tolerances: tuple[float, float],
) -> BoolArray:
    """Return which arcs may belong to which landmarks anywhere within ``span`` of a pose, shape (a, f)."""
    likely = np.zeros((len(scan.depths), len(landmark_map.reflectors)), np.bool_)
    for arc in range(len(likely)):
        x, y = _sensor_position(scan, arc, (pose[0], pose[1], math.cos(pose[2]), math.sin(pose[2])))
        displacement = span[0] + span[1] * math.hypot(scan.origins_xy[arc, 0], scan.origins_xy[arc, 1])
        bearing = pose[2] + scan.normals[arc]
        for feature in range(len(landmark_map.reflectors)):
            shape = shape_of(landmark_map.reflectors[feature])
            extent = landmark_map.extents[feature, 0] - displacement, landmark_map.extents[feature, 1] + displacement
            if abs(scan.depths[arc] - _depth(shape, extent, x, y)) < _FAR * tolerances[0] + displacement:
                turned = abs(_wrapped(bearing - _direction(shape, x, y)))
                likely[arc, feature] = shape[0] != _WALL or turned < _FAR * tolerances[1] + span[1]
    return likely


@compiled
def _scores(
    scan: LocalScan,
    landmark_map: LandmarkMap,
    poses: FloatArray,
    likely: BoolArray,
    tolerances: tuple[float, float],
    stray: float,
) -> FloatArray:
    """Return the log-likelihood of poses [nats]: each arc belongs to the best of its likely landmarks, or to none."""
    scores, shapes = np.zeros(len(poses)), [shape_of(each) for each in landmark_map.reflectors]
    cosines, sines = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    for arc in range(len(scan.depths)):
        features = np.flatnonzero(likely[arc])
        for number in range(len(poses) if len(features) else 0):
            x, y = _sensor_position(scan, arc, (poses[number, 0], poses[number, 1], cosines[number], sines[number]))
            bearing, best = poses[number, 2] + scan.normals[arc], 0.0
            for feature in features:
                if not _faces(shapes[feature], landmark_map.fronts[feature], x, y):
                    continue
                extent = landmark_map.extents[feature, 0], landmark_map.extents[feature, 1]
                deep = (scan.depths[arc] - _depth(shapes[feature], extent, x, y)) / tolerances[0]
                if abs(deep) < _FAR:
                    aside = _wrapped(bearing - _direction(shapes[feature], x, y)) / tolerances[1]
                    best = max(best, landmark_map.weights[feature] * math.exp(-0.5 * (deep * deep + aside * aside)))
            scores[number] += scan.weights[arc] * math.log1p(best / stray)
    return scores


@inlined
def _sensor_position(scan: LocalScan, arc: int, pose: tuple[float, float, float, float]) -> tuple[float, float]:
    """Return the sensor position of an arc [m] if the robot is at a pose (x, y, cosine and sine of yaw)."""
    x, y, cosine, sine = pose
    ahead, left = scan.origins_xy[arc, 0], scan.origins_xy[arc, 1]
    return x + cosine * ahead - sine * left, y + sine * ahead + cosine * left


@inlined
def _wrapped(angle: float) -> float:
    return angle - _CIRCLE * math.floor(angle / _CIRCLE + 0.5)


@inlined
def _depth(shape: Shape, extent: tuple[float, float], x: float, y: float) -> float:
    """Return the depth of a landmark from a point [m]; infinite beside the extent of a wall."""
    if shape[0] == _WALL:
        facing = extent[0] - _BESIDE < shape[1] * y - shape[2] * x < extent[1] + _BESIDE
        return shape[3] - shape[1] * x - shape[2] * y if facing else math.inf
    # Where the echo of a round wall comes from depends on where the sensor looks.
    return math.inf if shape[0] == _ROUND else math.hypot(shape[1] - x, shape[2] - y) - shape[3]


@inlined
def _faces(shape: Shape, front: FloatArray, x: float, y: float) -> bool:
    """Return True if a landmark can be detected from a position [m]."""
    return bool(front[1] >= math.pi or abs(_wrapped(math.atan2(y - shape[2], x - shape[1]) - front[0])) <= front[1])


@inlined
def _direction(shape: Shape, x: float, y: float) -> float:
    """Return the bearing of the specular point of a landmark from a position [rad]."""
    return math.atan2(shape[2], shape[1]) if shape[0] == _WALL else math.atan2(shape[2] - y, shape[1] - x)
