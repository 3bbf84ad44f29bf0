"""Walls with a thickness: bodies behind the faces that were detected, mitred where two walls meet."""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.geometry import directions, intersections, lines_through, outward_normals
from echoplan.model import Opening, Wall

__all__ = ["body_pieces", "jamb_strokes", "label_turn", "wall_bodies", "wall_depths"]

# Ends nearer than this are one corner [m].
_JOINED = 1e-3
# Partitions of buildings are hardly thicker [m]; faces farther apart belong to different things.
_THICKEST = 0.4
# Faces are back to back if their outward normals are opposite to within 18 degrees (cosine).
_BACK_TO_BACK = -0.95
# A mitre longer than this many thicknesses is cut off square, as strokes are; longer ones would leave the paper.
_MITRE_LIMIT = 3.0


def wall_bodies(walls: Sequence[Wall], stations_xy: FloatArray, *, thickness: float | FloatArray) -> list[FloatArray]:
    """Give walls a body on the side away from the stations.

    Sonar detects faces and nothing behind them, so the thickness is only that of a drawing.

    Parameters
    ----------
    walls : sequence of Wall
        The faces.
    stations_xy : ndarray, shape (s, 2)
        Positions from which they were detected [m].
    thickness : float or ndarray, shape (w,)
        How thick to draw them, or each of them [m].

    Returns
    -------
    list of ndarray, shape (4, 2)
        Start and end of the face, then end and start of the back [m]; one a wall.
    """
    faces = np.array([wall.endpoints_xy for wall in walls]).reshape(-1, 2, 2)
    lines = lines_through(faces[:, 0], faces[:, 1])
    normals = directions(lines[:, 0])
    own = np.array([wall.normal_xy for wall in walls]).reshape(-1, 2)
    outward = np.sign((outward_normals(faces, stations_xy, normals_xy=own) * normals).sum(axis=1))
    backs = lines + np.stack([np.zeros(len(lines)), outward * thickness], axis=-1).reshape(-1, 2)
    squares = faces + (outward * thickness)[:, None, None] * normals[:, None, :]
    return [
        np.stack([*faces[number], *(_back_end(number, end, faces, backs, squares=squares) for end in (1, 0))])
        for number in range(len(walls))
    ]


def wall_depths(walls: Sequence[Wall], stations_xy: FloatArray) -> FloatArray:
    """Find how thick each wall is, shape (w,) [m]: nan where its back was not detected as another wall."""
    faces = np.array([wall.endpoints_xy for wall in walls]).reshape(-1, 2, 2)
    own = np.array([wall.normal_xy for wall in walls]).reshape(-1, 2)
    outward = outward_normals(faces, stations_xy, normals_xy=own)
    depths = np.full(len(walls), np.nan)
    for number, (face, normal) in enumerate(zip(faces, outward, strict=True)):
        away = faces - face[0]
        length = float(np.hypot(*(face[1] - face[0])))
        along = away @ ((face[1] - face[0]) / length)
        overlaps = np.minimum(along.max(axis=1), length) - np.maximum(along.min(axis=1), 0.0) > 0.0
        behind = (away @ normal).mean(axis=1)
        is_back = overlaps & (outward @ normal < _BACK_TO_BACK) & (behind > _JOINED) & (behind <= _THICKEST)
        depths[number] = behind[is_back].min() if is_back.any() else np.nan
    return depths


def body_pieces(body: FloatArray, inferred: FloatArray) -> tuple[list[FloatArray], list[FloatArray]]:
    """Cut the body of a wall, shape (4, 2), where its inferred ends [m] begin: into observed and inferred pieces."""
    length = float(np.hypot(*(body[1] - body[0])))
    along = (body[1] - body[0]) / length
    across = (body[2] - body[1]) - ((body[2] - body[1]) @ along) * along
    first = min(float(inferred[0]), length)
    last = max(length - float(inferred[1]), first)
    start, end = body[[0, 3]], body[[1, 2]]
    edges = [
        start,
        np.stack([body[0] + first * along, body[0] + first * along + across]) if first > 0.0 else start,
        np.stack([body[0] + last * along, body[0] + last * along + across]) if last < length else end,
        end,
    ]
    before, observed, after = (
        [np.stack([one[0], other[0], other[1], one[1]])] if far > near else []
        for (near, far), (one, other) in zip(pairwise((0.0, first, last, length)), pairwise(edges), strict=True)
    )
    return observed, before + after


def jamb_strokes(opening: Opening, bodies: Sequence[FloatArray], *, thickness: float) -> FloatArray:
    """Strokes across both ends of an opening, shape (2, 2, 2) [m], twice as long as the bodies beside it are thick."""
    normal = directions(lines_through(*opening.endpoints_xy)[0])
    depth = sum(float((bodies[wall][2] - bodies[wall][1]) @ normal) for wall in opening.walls)
    middle = float(np.clip(depth, -thickness, thickness)) / 2
    return opening.endpoints_xy[:, None] + np.array([[middle - thickness], [middle + thickness]]) * normal


def label_turn(ends_xy: FloatArray) -> float:
    """Angle of a label along a stroke, shape (2, 2): read from below or from the right [degrees, -80 to 100].

    Beyond 90 degrees, so that labels along all walls that are upright but for their uncertainty run upwards.
    """
    across, along = (ends_xy[1] - ends_xy[0]).tolist()
    return 100.0 - (100.0 - math.degrees(math.atan2(along, across))) % 180.0


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
