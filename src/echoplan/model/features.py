"""What a map is made of: walls, corners, cylinders and openings, each with its uncertainty."""

from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from echoplan.arrays import (
    FloatArray,
    checked_covariance,
    checked_floats,
    checked_number,
    store,
)
from echoplan.errors import InvalidValueError
from echoplan.geometry import directions

__all__ = [
    "HALF_OF_95",
    "ClassProbabilities",
    "Corner",
    "CornerKind",
    "Cylinder",
    "FeatureClass",
    "Opening",
    "UnobservedStretch",
    "Wall",
]

# Half the width of the 95 % interval of a normal distribution, in standard deviations.
HALF_OF_95 = 1.96


class FeatureClass(StrEnum):
    """What a reflector can be."""

    WALL = "wall"
    CORNER = "corner"
    CYLINDER = "cylinder"


class CornerKind(StrEnum):
    """How a corner is seen from the stations that detected it: into it, or around it."""

    CONCAVE = "concave"
    CONVEX = "convex"


@dataclass(frozen=True, slots=True, kw_only=True)
class ClassProbabilities:
    """How likely a feature is of each class.

    Parameters
    ----------
    wall, corner, cylinder : float, optional
        Probabilities that sum to one.

    Raises
    ------
    InvalidValueError
        If one is negative or they do not sum to one.
    """

    wall: float = 0.0
    corner: float = 0.0
    cylinder: float = 0.0

    def __post_init__(self) -> None:
        for name in FeatureClass:
            checked_number(getattr(self, name), name=name, minimum=0.0, maximum=1.0)
        total = self.wall + self.corner + self.cylinder
        if abs(total - 1.0) > 1e-6:
            raise InvalidValueError(f"class probabilities must sum to 1, not {total:.12g}")


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Wall:
    """A flat face: the line ``n . p = offset`` with n = (cos, sin) of its angle, and its ends.

    Parameters
    ----------
    normal_angle : float
        Direction of the normal [rad].
    offset : float
        Distance of the line from the origin along the normal [m].
    endpoints_xy : ndarray, shape (2, 2)
        Start and end [m].
    covariance : ndarray, shape (2, 2)
        Of normal_angle and offset, in that order [rad, m].
    class_probabilities : ClassProbabilities, optional
        How sure it is that this is a wall.
    pings : int, optional
        How many pings speak for it.
    stations : int, optional
        From how many stations they came.
    endpoint_sigmas : ndarray, shape (2,), optional
        Standard deviation of the start and of the end along the wall [m]: half the width of the 95 % interval, divided
        by 1.96.  NaN (the default) where the method does not estimate it.
    inferred : ndarray, shape (2,), optional
        Length at the start and at the end of the wall over which it was extrapolated to a corner that was not detected
        [m]; 0 by default.
    reflection_loss : float, optional
        How much fainter than a hard wall it reflects sound [dB]; 0 by default.

    Raises
    ------
    InvalidValueError
        If a number is not finite (NaN is allowed in ``endpoint_sigmas``), the ends coincide, the covariance is invalid,
        or ``inferred``, ``reflection_loss`` or a standard deviation is negative.
    """

    normal_angle: float
    offset: float
    endpoints_xy: FloatArray
    covariance: FloatArray
    class_probabilities: ClassProbabilities = field(default_factory=lambda: ClassProbabilities(wall=1.0))
    pings: int = 0
    stations: int = 0
    endpoint_sigmas: FloatArray = field(default_factory=lambda: np.full(2, np.nan))
    inferred: FloatArray = field(default_factory=lambda: np.zeros(2))
    reflection_loss: float = 0.0

    def __post_init__(self) -> None:
        checked_number(self.reflection_loss, name="reflection_loss", minimum=0.0)
        checked_number(self.normal_angle, name="normal_angle")
        checked_number(self.offset, name="offset")
        ends = _checked_ends(self.endpoints_xy, kind="a wall")
        sigmas = checked_floats(self.endpoint_sigmas, name="endpoint_sigmas", shape=(2,), finite=False)
        inferred = checked_floats(self.inferred, name="inferred", shape=(2,))
        for name, lengths in (("endpoint_sigmas", sigmas), ("inferred", inferred)):
            if (lengths < 0.0).any() or np.isinf(lengths).any():
                raise InvalidValueError(f"{name} must be neither negative nor infinite, it is {lengths.tolist()}")
        store(
            self,
            endpoints_xy=ends,
            covariance=checked_covariance(self.covariance, name="covariance", size=2),
            endpoint_sigmas=sigmas,
            inferred=inferred,
        )

    @property
    def length(self) -> float:
        """Distance between the ends [m]."""
        return float(np.hypot(*(self.endpoints_xy[1] - self.endpoints_xy[0])))

    @property
    def normal_xy(self) -> FloatArray:
        """Unit normal, shape (2,)."""
        return directions(self.normal_angle)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Corner:
    """A corner: where two walls meet, or an edge that was detected by itself.

    Parameters
    ----------
    position_xy : ndarray, shape (2,)
        Vertex [m].
    kind : CornerKind
        Concave or convex.
    covariance : ndarray, shape (2, 2)
        Of x and y [m, m].
    class_probabilities : ClassProbabilities, optional
        How sure it is that this is a corner.
    pings : int, optional
        How many pings speak for it by themselves; 0 for a mere crossing of walls.
    stations : int, optional
        Number of stations that detected it.

    Raises
    ------
    InvalidValueError
        If the position is not finite or the covariance is invalid.
    """

    position_xy: FloatArray
    kind: CornerKind
    covariance: FloatArray
    class_probabilities: ClassProbabilities = field(default_factory=lambda: ClassProbabilities(corner=1.0))
    pings: int = 0
    stations: int = 0

    def __post_init__(self) -> None:
        store(
            self,
            position_xy=checked_floats(self.position_xy, name="position_xy", shape=(2,)),
            kind=CornerKind(self.kind),
            covariance=checked_covariance(self.covariance, name="covariance", size=2),
        )


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Cylinder:
    """An upright cylinder.

    Parameters
    ----------
    center_xy : ndarray, shape (2,)
        Axis [m].
    radius : float
        Radius [m], not negative.
    covariance : ndarray, shape (3, 3)
        Of x, y and radius [m].
    class_probabilities : ClassProbabilities, optional
        How sure it is that this is a cylinder.
    pings : int, optional
        How many pings speak for it.
    stations : int, optional
        From how many stations they came.

    Raises
    ------
    InvalidValueError
        If a number is not finite, the radius negative or the covariance none.
    """

    center_xy: FloatArray
    radius: float
    covariance: FloatArray
    class_probabilities: ClassProbabilities = field(default_factory=lambda: ClassProbabilities(cylinder=1.0))
    pings: int = 0
    stations: int = 0

    def __post_init__(self) -> None:
        checked_number(self.radius, name="radius", minimum=0.0)
        store(
            self,
            center_xy=checked_floats(self.center_xy, name="center_xy", shape=(2,)),
            covariance=checked_covariance(self.covariance, name="covariance", size=3),
        )


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Opening:
    """A gap between walls through which the robot drove or sound travelled, such as a doorway.

    Parameters
    ----------
    endpoints_xy : ndarray, shape (2, 2)
        Start and end: the two jambs [m].
    width_sigma : float
        Standard deviation of the width [m]: half the width of the 95 % interval, divided by 1.96.
    walls : tuple of int
        Indices of the walls on both sides, in the map that holds the opening.
    passed : bool, optional
        True if the robot drove through; False if only sound travelled through.

    Raises
    ------
    InvalidValueError
        If a number is not finite, the ends coincide, or the standard deviation is negative.
    """

    endpoints_xy: FloatArray
    width_sigma: float
    walls: tuple[int, ...]
    passed: bool = False

    def __post_init__(self) -> None:
        checked_number(self.width_sigma, name="width_sigma", minimum=0.0)
        ends = _checked_ends(self.endpoints_xy, kind="an opening")
        store(self, endpoints_xy=ends, walls=tuple(int(each) for each in self.walls))

    @property
    def width(self) -> float:
        """Distance between the ends [m]."""
        return float(np.hypot(*(self.endpoints_xy[1] - self.endpoints_xy[0])))


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class UnobservedStretch:
    """A stretch of a wall line between two walls that no station could observe: neither wall nor opening.

    Parameters
    ----------
    endpoints_xy : ndarray, shape (2, 2)
        Start and end [m].
    walls : tuple of int
        Indices of the walls on both sides, in the map that holds the stretch.

    Raises
    ------
    InvalidValueError
        If a number is not finite, or the ends coincide.
    """

    endpoints_xy: FloatArray
    walls: tuple[int, ...]

    def __post_init__(self) -> None:
        ends = _checked_ends(self.endpoints_xy, kind="an unobserved stretch")
        store(self, endpoints_xy=ends, walls=tuple(int(each) for each in self.walls))


def _checked_ends(endpoints_xy: FloatArray, *, kind: str) -> FloatArray:
    """Check both ends of something long, shape (2, 2) [m]."""
    ends = checked_floats(endpoints_xy, name="endpoints_xy", shape=(2, 2))
    if (ends[0] == ends[1]).all():
        raise InvalidValueError(f"the ends of {kind} must differ, both are {ends[0].tolist()}")
    return ends
