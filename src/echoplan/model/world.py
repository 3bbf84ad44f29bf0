"""Worlds to be simulated, ways through them and the truth that a map is compared with."""

from dataclasses import dataclass, field

import numpy as np

from echoplan.arrays import FloatArray, IntArray, checked_floats, checked_integers, checked_number, store
from echoplan.errors import InvalidValueError

__all__ = ["EVERYWHERE", "Pillar", "Polyline", "Route", "Truth", "World"]

_NOWHERE = np.zeros((0, 3))


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Polyline:
    """Flat faces joined end to end.

    Parameters
    ----------
    points_xy : ndarray, shape (n, 2)
        Vertices [m], at least two and no two neighbours alike.
    closed : bool, optional
        Whether the last vertex joins the first.
    material : str, optional
        What the faces are made of.

    Raises
    ------
    InvalidValueError
        If there are too few vertices or two neighbours coincide.
    """

    points_xy: FloatArray
    closed: bool = False
    material: str = "hard"

    def __post_init__(self) -> None:
        points = checked_floats(self.points_xy, name="points", shape=(None, 2))
        fewest = 3 if self.closed else 2
        if len(points) < fewest:
            raise InvalidValueError(f"points must be at least {fewest}, not {len(points)}")
        store(self, points_xy=points)
        lengths = np.hypot(*np.moveaxis(self.segments_xy[:, 1] - self.segments_xy[:, 0], -1, 0))
        if (lengths == 0).any():
            raise InvalidValueError(
                f"points must differ from their neighbours; {points[lengths.argmin()].tolist()} occurs twice"
            )

    @property
    def segments_xy(self) -> FloatArray:
        """Faces as (m, 2, 2): item, start or end, x or y [m]."""
        ends = np.roll(self.points_xy, -1, axis=0)
        segments = np.stack([self.points_xy, ends], axis=1)
        return segments if self.closed else segments[:-1]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Pillar:
    """A cylinder that stands in a world.

    Parameters
    ----------
    center_xy : ndarray, shape (2,)
        Axis [m].
    radius : float
        Radius [m].
    material : str, optional
        What it is made of.

    Raises
    ------
    InvalidValueError
        If the radius is not positive.
    """

    center_xy: FloatArray
    radius: float
    material: str = "hard"

    def __post_init__(self) -> None:
        checked_number(self.radius, name="radius", above=0.0)
        store(self, center_xy=checked_floats(self.center_xy, name="center", shape=(2,)))


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class World:
    """What stands in a room.

    Parameters
    ----------
    name : str
        What people call it.
    polylines : tuple of Polyline
        The walls, boxes and boards.
    pillars : tuple of Pillar, optional
        The cylinders.
    """

    name: str
    polylines: tuple[Polyline, ...]
    pillars: tuple[Pillar, ...] = ()

    @property
    def segments_xy(self) -> FloatArray:
        """All faces as (m, 2, 2): item, start or end, x or y [m]."""
        return np.concatenate([np.zeros((0, 2, 2)), *(polyline.segments_xy for polyline in self.polylines)])

    @property
    def discs(self) -> FloatArray:
        """All cylinders as (k, 3): x, y, radius [m]."""
        return np.array([[*pillar.center_xy, pillar.radius] for pillar in self.pillars]).reshape(-1, 3)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Route:
    """The way of a robot: stations at which it stands, or stamped poses between which it moves.

    Parameters
    ----------
    map_from_base : ndarray, shape (n, 3)
        Poses [m, m, rad].
    stamps_ns : ndarray of int, shape (n,), optional
        Time of each pose [ns], increasing; None for stations.

    Raises
    ------
    InvalidValueError
        If the route is empty or its times do not increase.
    """

    map_from_base: FloatArray
    stamps_ns: IntArray | None = None

    def __post_init__(self) -> None:
        poses = checked_floats(self.map_from_base, name="poses", shape=(None, 3))
        if not len(poses):
            raise InvalidValueError("a route must have at least one pose")
        store(self, map_from_base=poses)
        if self.stamps_ns is None:
            return
        stamps = checked_integers(self.stamps_ns, name="stamps_ns", shape=(len(poses),))
        if (np.diff(stamps) <= 0).any():
            raise InvalidValueError("the times of a route must increase")
        store(self, stamps_ns=stamps)


# Number of stations that detect something whose number is not specified.
EVERYWHERE = 2**31 - 1


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Truth:
    """What a map of a recording should say.

    Parameters
    ----------
    walls_xy : ndarray, shape (m, 2, 2)
        Faces: item, start or end, x or y [m].
    walls_detected_by : ndarray of int, shape (m,)
        Number of stations that can detect each wall; ``EVERYWHERE`` where it is not specified.
    cylinders : ndarray, shape (k, 3), optional
        ``(x, y, radius)`` [m].
    cylinders_detected_by : ndarray of int, shape (k,), optional
        Number of stations that can detect each cylinder.
    poses : ndarray, shape (s, 3), optional
        True pose of each sweep [m, m, rad].
    given : ndarray, shape (s, 3), optional
        Pose of each sweep as the recording gives it [m, m, rad]; none where that is unknown.
    temperature : float, optional
        Temperature of the air [degrees Celsius].

    Raises
    ------
    InvalidValueError
        If lengths differ.
    """

    walls_xy: FloatArray
    walls_detected_by: IntArray
    cylinders: FloatArray = field(default_factory=_NOWHERE.copy)
    cylinders_detected_by: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    poses: FloatArray = field(default_factory=_NOWHERE.copy)
    given: FloatArray = field(default_factory=_NOWHERE.copy)
    temperature: float | None = None

    def __post_init__(self) -> None:
        walls = checked_floats(self.walls_xy, name="walls", shape=(None, 2, 2))
        cylinders = checked_floats(self.cylinders, name="cylinders", shape=(None, 3))
        poses = checked_floats(self.poses, name="poses", shape=(None, 3))
        given = checked_floats(self.given, name="given", shape=(len(poses) if len(self.given) else 0, 3))
        store(
            self,
            walls_xy=walls,
            walls_detected_by=checked_integers(self.walls_detected_by, name="walls_heard", shape=(len(walls),)),
            cylinders=cylinders,
            cylinders_detected_by=checked_integers(
                self.cylinders_detected_by, name="cylinders_heard", shape=(len(cylinders),)
            ),
            poses=poses,
            given=given,
        )
