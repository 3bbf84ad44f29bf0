"""A world as the ray tracer wants it: faces, cylinders and the edges at which sound is diffracted."""

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from echoplan.acoustics import reflection_coefficients
from echoplan.arrays import ComplexArray, FloatArray
from echoplan.geometry import distances_to_segments
from echoplan.model import World
from echoplan.simulation.tree import Tree, build_tree

__all__ = ["Disc", "Edge", "Face", "Scene", "build_scene"]

# Points nearer than this are one point [m].
_WELD = 1e-9
# Inside sharper corners sound is reflected more than twice; edges there stay silent [rad].
_SHARPEST = np.pi / 3

_FACE = np.dtype([("start", "c16"), ("tangent", "c16"), ("length", "f8"), ("gain", "f8")])
_DISC = np.dtype([("center", "c16"), ("radius", "f8"), ("gain", "f8")])
_EDGE = np.dtype([("apex", "c16"), ("first", "f8"), ("opening", "f8"), ("first_gain", "f8"), ("second_gain", "f8")])


class Face(Protocol):
    """A flat face: start [m], unit direction, length [m], amplitude reflection coefficient."""

    start: complex
    tangent: complex
    length: float
    gain: float


class Disc(Protocol):
    """A cylinder: axis [m], radius [m], amplitude reflection coefficient."""

    center: complex
    radius: float
    gain: float


class Edge(Protocol):
    """An edge: place [m], direction of its first face, angle of the air from there [rad], gains of its faces."""

    apex: complex
    first: float
    opening: float
    first_gain: float
    second_gain: float


class Scene(NamedTuple):
    """Everything that reflects or scatters, points and directions as complex numbers x + jy.

    Attributes
    ----------
    faces, discs, edges : ndarray of records, shapes (m,), (k,), (q,)
        The flat faces, the cylinders and the edges that diffract, with the fields of Face, Disc and Edge.
    tree : Tree
        Boxes around the faces.
    """

    faces: NDArray[np.void]
    discs: NDArray[np.void]
    edges: NDArray[np.void]
    tree: Tree


@dataclass(frozen=True, slots=True, kw_only=True)
class _Wedge:
    apex: complex
    first: float
    opening: float
    gains: tuple[float, float]

    @property
    def record(self) -> tuple[complex, float, float, float, float]:
        """Fields of an Edge: apex [m], first and opening angle [rad], gains of both faces."""
        return (self.apex, self.first, self.opening, *self.gains)

    @property
    def scatters(self) -> bool:
        """Whether the edge diffracts sound that mirror images do not account for."""
        # Where the opening is pi over a whole number the mirror images are the whole field.
        images = np.pi / self.opening
        whole = abs(images - round(images)) < _WELD and self.gains[0] == self.gains[1]
        return self.opening > _SHARPEST + _WELD and not whole


def build_scene(world: World) -> Scene:
    """Prepare a world for the ray tracer.

    Parameters
    ----------
    world : World
        What stands in the room.

    Returns
    -------
    Scene
        Its faces in the order of ``world.segments_xy``, its cylinders in that of ``world.discs``.

    Raises
    ------
    UnknownNameError
        If a material is not known.

    Examples
    --------
    >>> from echoplan.model import Polyline
    >>> box = World(name="box", polylines=(Polyline(points_xy=[[0, 0], [1, 0], [1, 1], [0, 1]], closed=True),))
    >>> len(build_scene(box).edges)  # the right angles within reflect, those without also diffract
    4
    """
    segments = world.segments_xy
    names = [line.material for line in world.polylines for _ in line.segments_xy]
    gains = reflection_coefficients(names)
    starts, spans = _as_complex(segments[:, 0]), _as_complex(segments[:, 1] - segments[:, 0])
    lengths = np.abs(spans)
    discs = world.discs
    disc_gains = reflection_coefficients([pillar.material for pillar in world.pillars])
    return Scene(
        faces=_records(_FACE, starts, spans / lengths, lengths, gains),
        discs=_records(_DISC, _as_complex(discs[:, :2]), discs[:, 2], disc_gains),
        edges=np.array([edge.record for edge in _edges(segments, gains) if edge.scatters], dtype=_EDGE),
        tree=build_tree(segments),
    )


def _as_complex(points_xy: FloatArray) -> ComplexArray:
    return points_xy[:, 0] + 1j * points_xy[:, 1]


def _records(kind: np.dtype[np.void], *columns: FloatArray | ComplexArray) -> NDArray[np.void]:
    return np.array(list(zip(*columns, strict=True)), dtype=kind)


def _edges(segments_xy: FloatArray, gains: FloatArray) -> list[_Wedge]:
    ends = segments_xy.reshape(-1, 2)
    if not len(ends):
        return []
    apexes = ends[np.unique(np.round(ends / _WELD), axis=0, return_index=True)[1]]
    return [
        edge
        for apex, near in zip(apexes, _touching(apexes, segments_xy), strict=True)
        for edge in _edges_at(apex, segments_xy[near], gains[near])
    ]


def _touching(points_xy: FloatArray, segments_xy: FloatArray) -> list[list[int]]:
    """Find the segments on which each point lies."""
    from scipy.spatial import KDTree  # noqa: PLC0415 - SciPy is slow to import

    centers, radii = segments_xy.mean(axis=1), np.linalg.norm(segments_xy[:, 1] - segments_xy[:, 0], axis=1) / 2
    tree, touching = KDTree(points_xy), [list[int]() for _ in points_xy]
    for number, (segment, center, radius) in enumerate(zip(segments_xy, centers, radii, strict=True)):
        near = np.array(tree.query_ball_point(center, radius + 2 * _WELD), dtype=np.int64)
        for point in near[distances_to_segments(points_xy[near], segment)[:, 0] < _WELD]:
            touching[point].append(number)
    return touching


def _edges_at(apex: FloatArray, segments_xy: FloatArray, gains: FloatArray) -> list[_Wedge]:
    away = segments_xy - apex  # (faces, ends, 2)
    far = np.hypot(away[..., 0], away[..., 1]) > _WELD
    directions = np.arctan2(away[..., 1], away[..., 0])[far]
    gain = np.broadcast_to(gains[:, None], far.shape)[far]
    order = np.argsort(directions)
    directions, gain = directions[order], gain[order]
    openings = np.diff(directions, append=directions[0] + 2 * np.pi)
    rows = zip(directions, openings, gain, np.roll(gain, -1), strict=True)
    return [
        _Wedge(
            apex=complex(*apex),
            first=float(first),
            opening=float(opening),
            gains=(float(g), float(h)),
        )
        for first, opening, g, h in rows
    ]
