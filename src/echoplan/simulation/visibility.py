"""What stands in the way of sound, and which faces an image can reach: in machine code.

Importing this module imports numba, which takes its time: import it where it is used.
"""

import math
from typing import Protocol

from echoplan.arrays import IntArray
from echoplan.compiled import inlined
from echoplan.kernels import sort
from echoplan.simulation.scene import Disc, Face, Scene
from echoplan.simulation.tree import MARGIN

__all__ = ["TIE", "distance", "faces_within", "is_blocked", "on_line", "passes"]

# Points nearer than this are one point [m]; directions nearer than this are one direction [rad].
TIE = 1e-9


class _Box(Protocol):
    center: complex
    half: complex


@inlined
def is_blocked(scene: Scene, p: complex, q: complex) -> bool:
    """Return whether a face or a cylinder stands between two points."""
    way, boxes, node = q - p, scene.tree.boxes, 0
    while node < len(boxes):
        box = boxes[node]
        if _misses(box, p, way):
            node = box.skip
            continue
        for face in scene.tree.order[box.first : box.last]:
            if _crosses(scene.faces[face], p, q):
                return True
        node += 1
    hidden = False
    for disc in scene.discs:
        hidden = hidden or passes(disc, p, q)
    return hidden


@inlined
def faces_within(scene: Scene, face: Face, image: complex, reach: float, found: IntArray) -> int:
    """Find the faces that may be met by sound from an image that comes through the face of the mirror.

    They are written to ``found`` in their order, and their number is returned.
    """
    boxes, order, node, count = scene.tree.boxes, scene.tree.order, 0, 0
    to_start = face.start - MARGIN * face.tangent - image
    to_end = face.start + (face.length + MARGIN) * face.tangent - image
    height = on_line(face, image).imag
    # Sound of an image on its own face may arrive from any direction.
    is_wide = abs(height) < MARGIN
    turn = math.copysign(1.0, (to_start.conjugate() * to_end).imag)
    ahead = -math.copysign(1.0, height) * face.tangent
    while node < len(boxes):
        box = boxes[node]
        near = not is_wide and _least_distance(box, image) <= reach
        near = near and _most_left(box, image, turn * to_start) >= 0 and _most_left(box, image, -turn * to_end) >= 0
        if not is_wide and not (near and _most_left(box, face.start, ahead) >= 0):
            node = box.skip
            continue
        for place in range(box.first, box.last):
            found[count] = order[place]
            count += 1
        node += 1
    sort(found[:count])
    return count


@inlined
def distance(p: complex, q: complex) -> float:
    """Distance of two points."""
    return math.sqrt((p.real - q.real) ** 2 + (p.imag - q.imag) ** 2)


@inlined
def on_line(face: Face, point: complex) -> complex:
    """Coordinates of a point along a face, and above it."""
    return (point - face.start) * face.tangent.conjugate()


@inlined
def passes(disc: Disc, p: complex, q: complex) -> bool:
    """Return whether the way between two points passes through a cylinder."""
    way, length = q - p, distance(p, q)
    share = ((disc.center - p) * way.conjugate()).real / (length * length) if length > 0 else 0.0
    return distance(p + min(max(share, 0.0), 1.0) * way, disc.center) < disc.radius - TIE


@inlined
def _crosses(face: Face, p: complex, q: complex) -> bool:
    from_p, from_q = on_line(face, p), on_line(face, q)
    if min(from_p.imag, from_q.imag) < -TIE and max(from_p.imag, from_q.imag) > TIE:
        along = from_p.real + (from_q.real - from_p.real) * from_p.imag / (from_p.imag - from_q.imag)
        return -TIE <= along <= face.length + TIE
    return False


@inlined
def _misses(box: _Box, p: complex, way: complex) -> bool:
    # Whether a straight way passes by a box, or ends before it.
    away, half = box.center - p - 0.5 * way, box.half
    beside = abs((way.conjugate() * away).imag) > abs(way.imag) * half.real + abs(way.real) * half.imag
    beyond = abs(away.real) > half.real + 0.5 * abs(way.real) or abs(away.imag) > half.imag + 0.5 * abs(way.imag)
    return beside or beyond


@inlined
def _least_distance(box: _Box, point: complex) -> float:
    away = box.center - point
    return math.hypot(max(abs(away.real) - box.half.real, 0.0), max(abs(away.imag) - box.half.imag, 0.0))


@inlined
def _most_left(box: _Box, point: complex, way: complex) -> float:
    # How far, times the length of the way, a box reaches to the left of a way through a point.
    middle = (way.conjugate() * (box.center - point)).imag
    return middle + abs(way.imag) * box.half.real + abs(way.real) * box.half.imag
