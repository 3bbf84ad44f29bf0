"""Walls with a thickness: bodies behind the faces that were heard, mitred where two walls meet."""

from collections.abc import Sequence

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.geometry import crosses_segments, directions, intersections, lines_through, signed_distances
from echoplan.model import Wall

__all__ = ["wall_bodies"]

# Ends nearer than this are one corner [m].
_JOINED = 1e-3
# A mitre longer than this many thicknesses is cut off square, as strokes are; longer ones would leave the paper.
_MITRE_LIMIT = 3.0


def wall_bodies(walls: Sequence[Wall], stations_xy: FloatArray, *, thickness: float) -> list[FloatArray]:
    """Give walls a body on the side that cannot be heard.

    Sonar hears faces and nothing behind them, so the thickness is only that of a drawing.

    Parameters
    ----------
    walls : sequence of Wall
        The faces.
    stations_xy : ndarray, shape (s, 2)
        Where they were heard from [m].
    thickness : float
        How thick to draw them [m].

    Returns
    -------
    list of ndarray, shape (4, 2)
        Start and end of the face, then end and start of the back [m]; one a wall.
    """
    faces = np.array([wall.endpoints_xy for wall in walls]).reshape(-1, 2, 2)
    lines = lines_through(faces[:, 0], faces[:, 1])
    outward = np.array(
        [
            _outward(wall, line, np.delete(faces, number, axis=0), stations_xy)
            for number, (wall, line) in enumerate(zip(walls, lines, strict=True))
        ]
    )
    backs = lines + np.stack([np.zeros(len(lines)), outward * thickness], axis=-1).reshape(-1, 2)
    squares = faces + (outward * thickness)[:, None, None] * directions(lines[:, 0])[:, None, :]
    return [
        np.stack([*faces[number], *(_back_end(number, end, faces, backs, squares=squares) for end in (1, 0))])
        for number in range(len(walls))
    ]


def _outward(wall: Wall, line: FloatArray, others: FloatArray, stations_xy: FloatArray) -> float:
    """Side of a face that nobody heard, +1 or -1 along the normal of its line: by those who heard it, if one can tell.

    Those who stood opposite did, unless another face is between: a box is heard from all around.
    """
    inside = -np.sign(signed_distances(line, stations_xy))
    start, way = wall.endpoints_xy[0], wall.endpoints_xy[1] - wall.endpoints_xy[0]
    shares = (stations_xy - start) @ way / (way @ way)
    is_opposite = (shares > 0) & (shares < 1)
    is_hidden = crosses_segments(stations_xy, start + shares[:, None] * way, others).any(axis=1)
    votes = [float(inside[each].sum()) for each in (is_opposite & ~is_hidden, is_opposite, slice(None))]
    votes.append(float(directions(line[0]) @ wall.normal_xy))
    return 1.0 if next((vote for vote in votes if vote), 0.0) >= 0 else -1.0


def _back_end(number: int, end: int, faces: FloatArray, backs: FloatArray, *, squares: FloatArray) -> FloatArray:
    """Where the back of a wall ends: on the back of the wall that it meets, else square to its face."""
    square: FloatArray = squares[number, end]
    corner = faces[number, end]
    thickness = float(np.hypot(*(square - corner)))
    apart = np.hypot(*np.moveaxis(faces - corner, -1, 0)).min(axis=1)
    apart[number] = np.inf
    if apart.min() > _JOINED:
        return square
    mitre = intersections(backs[number], backs[int(apart.argmin())])
    fits = np.hypot(*(mitre - corner)) <= _MITRE_LIMIT * thickness
    return mitre if fits else square
