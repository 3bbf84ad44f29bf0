"""All echoes of a ping: mirror images, cylinders and edges, traced one path at a time in machine code.

The equations are those of ``echoplan.acoustics``, which provides the special functions as tables.  Importing this
module imports numba, which takes its time: import it where it is used.
"""

import math
from typing import Any, TypeAlias

import numpy as np

from echoplan.arrays import ComplexArray, FloatArray, IntArray
from echoplan.compiled import compiled, inlined
from echoplan.simulation.detector import Echoes
from echoplan.simulation.scene import Disc, Edge, Face, Scene
from echoplan.simulation.sonar import Sonar
from echoplan.simulation.stage import Receiver, Source, Stage
from echoplan.simulation.visibility import TIE, distance, faces_within, is_blocked, on_line, passes

__all__ = ["find_echoes"]

Echo: TypeAlias = tuple[float, complex, int]
Ends: TypeAlias = tuple[Source, Receiver]
Route: TypeAlias = tuple[complex, complex, complex, complex]

# No reflector sounds louder than at this distance: the face of a transducer is not a point [m].
_NEAREST = 1e-3
# No robot gains 1 % on sound, and no servo turns by more than this while sound flies [rad].
_HASTE, _SWING = 1.01, 0.2


@compiled
def find_echoes(stage: Stage, pings: IntArray, deadlines: FloatArray) -> Echoes:
    """Trace all paths from every audible burst to the receivers of some pings.

    Parameters
    ----------
    stage : Stage
        What stands around, transducer and air, all pings.
    pings : ndarray of int, shape (n,)
        Those that listen.
    deadlines : ndarray, shape (n,)
        How long they listen [s].

    Returns
    -------
    Echoes
        Echoes that they receive, in no order within a ping.
    """
    found = [(0.0, 0j, 0) for _ in range(0)]
    bounds, (_, sonar, shots) = np.zeros(len(pings) + 1, np.int64), stage
    for number, ping in enumerate(pings):
        for shot in range(shots.first_burst[ping], shots.last_burst[ping]):
            if sonar.crosstalk or shots.sensors[shot] == shots.sensors[ping]:
                _trace(found, stage, (shot, ping), deadlines[number])
        bounds[number + 1] = len(found)
    count = len(found)
    times, strengths, reflectors = np.empty(count), np.empty(count, np.complex128), np.empty(count, np.int64)
    for number, (time, pressure, reflector) in enumerate(found):
        phase = -sonar.wavenumber * sonar.speed * time
        strengths[number] = pressure * complex(math.cos(phase), math.sin(phase))
        times[number], reflectors[number] = time, reflector
    return Echoes(times, strengths, reflectors, bounds)


@inlined
def _trace(found: list[Echo], stage: Stage, pair: tuple[int, int], deadline: float) -> None:
    (scene, sonar, shots), (shot, ping) = stage, pair
    fired = shots.instants[shot] - shots.instants[ping]
    shortest, longest = max(-fired, 0.0) * sonar.speed, (_HASTE * deadline - fired) * sonar.speed
    place, axis, velocity, turn = shots.places[ping], shots.axes[ping], shots.velocities[ping], shots.turns[ping]
    source = Source(shots.places[shot], shots.axes[shot], fired)
    ends = (source, Receiver(place, axis, velocity, turn, deadline, shortest, longest))
    if sonar.order >= 1:
        _trace_faces(found, scene, sonar, ends)
        _trace_discs(found, scene, sonar, ends)
    if sonar.order >= 2:
        _trace_pairs(found, scene, sonar, ends)
        _trace_faces_then_discs(found, scene, sonar, ends)
        _trace_discs_then_faces(found, scene, sonar, ends)
    if sonar.diffraction:
        _trace_edges(found, scene, sonar, ends)


@inlined
def _trace_faces(found: list[Echo], scene: Scene, sonar: Sonar, ends: Ends) -> None:
    (source, receiver), faces = ends, scene.faces
    for index in range(len(faces)):
        image = _mirrored_source(faces[index], source)
        if _is_beyond(image, receiver):
            continue
        reception, time, pressure = _straight(sonar, image, receiver)
        if abs(pressure) >= sonar.floor:
            spot, lit = _bounce(faces[index], source.place, reception)
            echo = (time, complex(pressure * lit * faces[index].gain), index)
            _record(found, scene, (source.place, spot, spot, reception), echo)


@inlined
def _trace_pairs(found: list[Echo], scene: Scene, sonar: Sonar, ends: Ends) -> None:
    (source, receiver), reached = ends, np.empty(len(scene.faces), np.int64)
    for first in scene.faces:
        image = _mirrored_source(first, source)
        for index in reached[: faces_within(scene, first, image.place, receiver.longest, reached)]:
            second = scene.faces[index]
            final = _mirrored_source(second, image)
            if _is_beyond(final, receiver):
                continue
            reception, time, pressure = _straight(sonar, final, receiver)
            if abs(pressure) >= sonar.floor:
                route, lit = _bounce_twice((first, second), image.place, source.place, reception)
                _record(found, scene, route, (time, complex(pressure * lit * first.gain * second.gain), -1))


@inlined
def _trace_discs(found: list[Echo], scene: Scene, sonar: Sonar, ends: Ends) -> None:
    (source, receiver), discs = ends, scene.discs
    for index in range(len(discs)):
        if _is_out(discs[index], source, receiver):
            continue
        spot, reception, time, pressure = _over(sonar, discs[index], source, receiver)
        if abs(pressure) >= sonar.floor:
            echo = (time, complex(pressure), len(scene.faces) + index)
            _record(found, scene, (source.place, spot, spot, reception), echo)


@inlined
def _trace_faces_then_discs(found: list[Echo], scene: Scene, sonar: Sonar, ends: Ends) -> None:
    source, receiver = ends
    for face in scene.faces:
        image = _mirrored_source(face, source)
        for disc in scene.discs:
            if _is_out(disc, image, receiver):
                continue
            spot, reception, time, pressure = _over(sonar, disc, image, receiver)
            if abs(pressure) >= sonar.floor:
                first, lit = _bounce(face, source.place, spot)
                echo = (time, complex(pressure * lit * face.gain), -1)
                _record(found, scene, (source.place, first, spot, reception), echo)


@inlined
def _trace_discs_then_faces(found: list[Echo], scene: Scene, sonar: Sonar, ends: Ends) -> None:
    source, receiver = ends
    for face in scene.faces:
        image = _mirrored_receiver(face, receiver)
        for disc in scene.discs:
            if _is_out(disc, source, image):
                continue
            spot, reception, time, pressure = _over(sonar, disc, source, image)
            if abs(pressure) >= sonar.floor:
                last, lit = _bounce(face, spot, _mirror(face, reception))
                echo = (time, complex(pressure * lit * face.gain), -1)
                _record(found, scene, (source.place, spot, last, _mirror(face, reception)), echo)


@inlined
def _trace_edges(found: list[Echo], scene: Scene, sonar: Sonar, ends: Ends) -> None:
    source, receiver = ends
    for edge in scene.edges:
        there = distance(source.place, edge.apex)
        moved = _later(receiver, source.fired + (there + distance(edge.apex, receiver.place)) / sonar.speed)
        back = distance(edge.apex, moved.place)
        loudness = _loudness(sonar, (source, moved), (edge.apex - source.place, edge.apex - moved.place), there + back)
        # An edge diffracts no more than a plane reflects.
        if min(there, back) < _NEAREST or abs(loudness) < sonar.floor * (there + back):
            continue
        pressure = loudness * _scattered(sonar, edge, (source, moved), (there, back))
        if abs(pressure) >= sonar.floor:
            echo = (source.fired + (there + back) / sonar.speed, pressure, -1)
            _record(found, scene, (source.place, edge.apex, edge.apex, moved.place), echo)


@inlined
def _record(found: list[Echo], scene: Scene, route: Route, echo: Echo) -> None:
    clear = echo[1] != 0
    for leg in range(3):
        clear = clear and not is_blocked(scene, route[leg], route[leg + 1])
    if clear:
        found.append(echo)


@inlined
def _straight(sonar: Sonar, image: Source, receiver: Receiver) -> tuple[complex, float, float]:
    # Where the receiver is when sound of an image arrives, when that is, and how loud: in images paths stay straight.
    moved = _later(receiver, image.fired + distance(image.place, receiver.place) / sonar.speed)
    way, length = moved.place - image.place, distance(moved.place, image.place)
    pressure = _loudness(sonar, (image, moved), (way, -way), length) / max(length, _NEAREST)
    return moved.place, image.fired + length / sonar.speed, pressure


@inlined
def _over(sonar: Sonar, disc: Disc, source: Source, receiver: Receiver) -> tuple[complex, complex, float, float]:
    # The specular point of a cylinder, where the receiver is when the sound arrives, when that is, and how loud.
    around = distance(source.place, disc.center) + distance(disc.center, receiver.place) - 2 * disc.radius
    moved = _later(receiver, source.fired + around / sonar.speed)
    spot, cosine = _specular_point(disc, source.place, moved.place)
    if cosine <= 0:
        return disc.center, receiver.place, 0.0, 0.0
    there, back = max(distance(source.place, spot), _NEAREST), max(distance(spot, moved.place), _NEAREST)
    length = there + back
    law = disc.gain / math.sqrt(length * (length + 2 * there * back / (disc.radius * cosine)))
    pressure = law * _loudness(sonar, (source, moved), (spot - source.place, spot - moved.place), length)
    return spot, moved.place, source.fired + length / sonar.speed, pressure


@inlined
def _is_beyond(image: Source, receiver: Receiver) -> bool:
    # Whether sound of an image comes too early, too late, is sent away from the receiver or comes from behind it:
    # cheap and conservative.
    way = receiver.place - image.place
    square = way.real * way.real + way.imag * way.imag
    ahead, before = (way * image.axis.conjugate()).real, -(way * receiver.axis.conjugate()).real
    out_of_time = square < receiver.shortest * receiver.shortest or square > receiver.longest * receiver.longest
    return out_of_time or min(ahead, before) < -_SWING * math.sqrt(square)


@inlined
def _is_out(disc: Disc, source: Source, receiver: Receiver) -> bool:
    # The same for a cylinder between source and receiver.
    there, back = distance(source.place, disc.center), distance(disc.center, receiver.place)
    out_of_time = there + back < receiver.shortest or there + back - 2 * disc.radius > receiver.longest
    ahead = ((disc.center - source.place) * source.axis.conjugate()).real
    before = ((disc.center - receiver.place) * receiver.axis.conjugate()).real
    return out_of_time or min(ahead + _SWING * there, before + _SWING * back) < -disc.radius


@inlined
def _later(receiver: Receiver, time: float) -> Receiver:
    angle = receiver.turn * time
    place, axis = receiver.place + receiver.velocity * time, receiver.axis * complex(1 - angle * angle / 2, angle)
    return Receiver(
        place, axis, receiver.velocity, receiver.turn, receiver.deadline, receiver.shortest, receiver.longest
    )


@inlined
def _loudness(sonar: Sonar, ends: Ends, ways: tuple[complex, complex], length: float) -> float:
    # Pressure at 1 m over the threshold, less beams and absorption; none before or after the receiver listens.
    source, receiver = ends
    time = source.fired + length / sonar.speed
    if time < 0 or time > receiver.deadline:
        return 0.0
    beams = _beam(sonar.beam, source.axis, ways[0]) * _beam(sonar.beam, receiver.axis, ways[1])
    return sonar.gain * beams * math.exp(-sonar.damping * length)


@inlined
def _beam(table: FloatArray, axis: complex, way: complex) -> float:
    length, seen = distance(way, 0j), way * axis.conjugate()
    if length < TIE:
        return 1.0
    if seen.real < -TIE * length:
        return 0.0
    return float(_looked_up(table, min(abs(seen.imag) / length, 1.0)))


@inlined
def _looked_up(table: FloatArray | ComplexArray, share: float) -> Any:
    node, below = share * (len(table) - 1), min(int(share * (len(table) - 1)), len(table) - 2)
    return table[below] + (node - below) * (table[below + 1] - table[below])


@inlined
def _mirror(face: Face, point: complex) -> complex:
    return face.start + face.tangent * on_line(face, point).conjugate()


@inlined
def _mirrored_source(face: Face, source: Source) -> Source:
    return Source(_mirror(face, source.place), face.tangent * face.tangent * source.axis.conjugate(), source.fired)


@inlined
def _mirrored_receiver(face: Face, receiver: Receiver) -> Receiver:
    twist = face.tangent * face.tangent
    axis, velocity = twist * receiver.axis.conjugate(), twist * receiver.velocity.conjugate()
    return Receiver(
        _mirror(face, receiver.place),
        axis,
        velocity,
        -receiver.turn,
        receiver.deadline,
        receiver.shortest,
        receiver.longest,
    )


@inlined
def _bounce(face: Face, p: complex, q: complex) -> tuple[complex, float]:
    # Where a face reflects sound from p to q, and the share that it returns there: half at an end, none beyond it.
    from_p, from_q = on_line(face, p), on_line(face, q)
    if min(from_p.imag, from_q.imag) < -TIE and max(from_p.imag, from_q.imag) > TIE:
        return p, 0.0
    heights = abs(from_p.imag) + abs(from_q.imag)
    share = abs(from_p.imag) / heights if heights > TIE else 0.5
    along = from_p.real + share * (from_q.real - from_p.real)
    inside = min(along, face.length - along)
    lit = 1.0 if inside > TIE else (0.5 if inside >= -TIE else 0.0)
    return face.start + along * face.tangent, lit


@inlined
def _bounce_twice(pair: tuple[Face, Face], image: complex, p: complex, q: complex) -> tuple[Route, float]:
    first, second = pair
    last, last_lit = _bounce(second, image, q)
    start, start_lit = _bounce(first, p, last)
    # In a right angle both bounces meet in the vertex: inside, two paths share the image there by halves; outside,
    # where each face lies behind the other, there is none.
    is_outside = start_lit == last_lit == 0.5 and min(_facing(first, second, p), _facing(second, first, q)) <= 0
    return (p, start, last, q), 0.0 if is_outside else min(start_lit, last_lit)


@inlined
def _facing(face: Face, other: Face, point: complex) -> float:
    # Positive if another face lies on a point's side of a face.
    return on_line(face, other.start + 0.5 * other.length * other.tangent).imag * on_line(face, point).imag


@inlined
def _specular_point(disc: Disc, p: complex, q: complex) -> tuple[complex, float]:
    # The point of a cylinder at which sound from p is reflected to q, and the cosine of its incidence; 0 if none.
    # The way over the cylinder is shortest there: Newton's steps, or halving where an end is still out of sight.
    away_p, away_q = distance(p, disc.center), distance(q, disc.center)
    if min(away_p, away_q) <= disc.radius or passes(disc, p, q):
        return disc.center, 0.0
    low, high = (p - disc.center) * (1 / away_p), (q - disc.center) * (1 / away_q)
    normal = (away_q - disc.radius) * low + (away_p - disc.radius) * high
    way = math.copysign(1.0, (high * low.conjugate()).imag)
    for _ in range(50):
        normal *= 1 / distance(normal, 0j)
        spot = disc.center + disc.radius * normal
        near_p, near_q = distance(p, spot), distance(q, spot)
        to_p, to_q = (p - spot) * normal.conjugate() * (1 / near_p), (q - spot) * normal.conjugate() * (1 / near_q)
        slope, is_lit = to_p.imag + to_q.imag, min(to_p.real, to_q.real) > 0
        if is_lit and abs(slope) < TIE:
            return spot, to_p.real
        low, high = (normal, high) if way * slope > 0 else (low, normal)
        stiffness = to_p.real + to_q.real + disc.radius * (to_p.real**2 / near_p + to_q.real**2 / near_q)
        normal = normal * complex(1.0, slope / stiffness) if is_lit else low + high
    return disc.center, 0.0


@inlined
def _direction(edge: Edge, point: complex) -> float:
    # Angle of a point as seen from an edge, counted from its first face; negative outside of its air.
    angle = math.atan2(point.imag - edge.apex.imag, point.real - edge.apex.real) - edge.first
    angle = (angle + TIE) % math.tau - TIE
    return max(angle, 0.0) if angle <= edge.opening + TIE else -1.0


@inlined
def _scattered(sonar: Sonar, edge: Edge, ends: Ends, distances: tuple[float, float]) -> complex:
    # What an edge makes of sound, by the coefficient of Kouyoumjian and Pathak as in acoustics.wedge_coefficient.
    (source, receiver), (there, back), opening = ends, distances, edge.opening
    incident, observed = _direction(edge, source.place), _direction(edge, receiver.place)
    if min(incident, observed) < 0:
        return 0j
    parameter = there * back / (there + back)
    kl, difference, total = sonar.wavenumber * parameter, observed - incident, observed + incident
    through = edge.first_gain * edge.second_gain if opening < math.pi else 1.0
    terms = through * _term(sonar, math.pi + difference, opening, kl)
    terms += through * _term(sonar, math.pi - difference, opening, kl)
    terms += edge.first_gain * _term(sonar, math.pi - total, opening, kl)
    terms += edge.second_gain * _term(sonar, math.pi + total, opening, kl)
    scale = -2 * opening / math.pi * math.sqrt(2 * math.pi * sonar.wavenumber) * there * back / math.sqrt(parameter)
    return complex(math.sqrt(0.5), -math.sqrt(0.5)) * (1 / scale) * terms


@inlined
def _term(sonar: Sonar, angle: float, opening: float, kl: float) -> complex:
    deviation = angle - 2 * opening * round(angle / (2 * opening))
    if abs(deviation) < TIE:
        return 0j
    leaning = abs(math.sin(deviation / 2)) / math.tan(deviation * math.pi / (2 * opening))
    z = 2 * math.sqrt(kl / math.pi) * abs(math.sin(deviation / 2))
    return 2 * math.sqrt(math.pi * kl) * leaning * complex(_looked_up(sonar.tail, z / (1 + z)))
