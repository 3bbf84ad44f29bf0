"""Maps and truths by hand, for tests."""

import numpy as np
from numpy.typing import ArrayLike

from echoplan.arrays import FloatArray
from echoplan.geometry import lines_through
from echoplan.model import Corner, CornerKind, Cylinder, FeatureMap, Truth, Wall

# An L of six walls, wider than deep, with a column that stands off its centre; few stations detect the last wall.
ROOM = Truth(
    walls_xy=np.array(
        [
            [[0.0, 0.0], [5.0, 0.0]],
            [[5.0, 0.0], [5.0, 1.5]],
            [[5.0, 1.5], [2.0, 1.5]],
            [[2.0, 1.5], [2.0, 3.0]],
            [[2.0, 3.0], [0.0, 3.0]],
            [[0.0, 3.0], [0.0, 0.0]],
        ]
    ),
    walls_detected_by=np.array([9, 4, 3, 2, 5, 1]),
    cylinders=np.array([[3.5, 0.6, 0.1], [1.0, 2.2, 0.05]]),
    cylinders_detected_by=np.array([6, 0]),
    poses=np.array([[1.0, 1.0, 0.0], [1.0, 2.0, 3.0]]),
    given=np.array([[1.0, 1.0, 0.0], [1.0, 2.0, 3.0]]),
)
NOWHERE = Truth(walls_xy=np.zeros((0, 2, 2)), walls_detected_by=np.zeros(0, dtype=np.int64))


def wall(start: ArrayLike, end: ArrayLike, *, covariance: ArrayLike = ((1e-4, 0.0), (0.0, 1e-4))) -> Wall:
    """A wall between two points, its line through both."""
    angle, offset = lines_through(start, end)
    return Wall(
        normal_angle=float(angle),
        offset=float(offset),
        endpoints_xy=np.array([start, end], dtype=np.float64),
        covariance=np.array(covariance),
    )


def corner(position_xy: ArrayLike, *, sigma: float = 0.01) -> Corner:
    """A corner at a point."""
    return Corner(position_xy=np.array(position_xy), kind=CornerKind.CONCAVE, covariance=sigma**2 * np.eye(2))


def cylinder(center_xy: ArrayLike, radius: float, *, sigma: float = 0.01) -> Cylinder:
    """A cylinder about a point."""
    return Cylinder(center_xy=np.array(center_xy), radius=radius, covariance=sigma**2 * np.eye(3))


def drawn(*features: Wall | Corner | Cylinder, poses: ArrayLike = ()) -> FeatureMap:
    """A map of some features."""
    rows: FloatArray = np.reshape(np.array(poses, dtype=np.float64), (-1, 3))
    return FeatureMap(
        method="by hand",
        walls=tuple(each for each in features if isinstance(each, Wall)),
        corners=tuple(each for each in features if isinstance(each, Corner)),
        cylinders=tuple(each for each in features if isinstance(each, Cylinder)),
        sweeps=np.arange(len(rows)),
        poses=rows,
    )


def spoilt(truth: Truth, rng: np.random.Generator) -> FeatureMap:
    """A map of a room with all that can be wrong: noise, pieces, gaps, doubles and ghosts."""
    return drawn(
        *_spoilt_walls(truth, rng),
        *_spoilt_cylinders(truth, rng),
        *_spoilt_corners(truth, rng),
        poses=truth.poses + rng.normal(0, 0.05, size=truth.poses.shape) + [0, 0, 2 * np.pi],
    )


def _spoilt_walls(truth: Truth, rng: np.random.Generator) -> list[Wall]:
    walls = []
    for start, end in truth.walls_xy:
        for _ in range(rng.choice([0, 1, 1, 1, 2])):
            low, high = sorted(rng.uniform(-0.1, 1.1, size=2))
            ends = [start + share * (end - start) + rng.normal(0, 0.04, size=2) for share in (low, high)]
            walls.append(wall(*(ends if rng.random() < 0.5 else ends[::-1])))
    return [*walls, *(wall(*rng.uniform(-4, 4, size=(2, 2))) for _ in range(2))]


def _spoilt_cylinders(truth: Truth, rng: np.random.Generator) -> list[Cylinder]:
    true = [circle for circle in truth.cylinders for _ in range(rng.choice([0, 1, 1, 2]))]
    near = [cylinder(xy + rng.normal(0, 0.08, size=2), radius * rng.uniform(0.5, 2)) for *xy, radius in true]
    return [*near, *(cylinder(rng.uniform(-4, 4, size=2), 0.2) for _ in range(rng.integers(3)))]


def _spoilt_corners(truth: Truth, rng: np.random.Generator) -> list[Corner]:
    ends = truth.walls_xy.reshape(-1, 2)
    near = (ends + rng.normal(0, 0.08, size=ends.shape))[rng.random(len(ends)) < 0.4]
    return [corner(xy) for xy in [*near, *rng.uniform(-4, 4, size=(2, 2))]]
