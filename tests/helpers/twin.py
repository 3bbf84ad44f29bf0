"""A twin of the simulator's machine code, written to be read: plain vectors, SciPy's functions, no tables, no haste.

It walks the same paths as ``echoplan.simulation.echoes`` and must receive the same echoes.
"""

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from scipy.optimize import minimize_scalar

from echoplan.acoustics import (
    burst_envelope,
    directivity,
    piston_ka,
    reflection_coefficients,
    wavenumber,
    wedge_coefficient,
)
from echoplan.arrays import ComplexArray, FloatArray
from echoplan.geometry import directions, is_blocked, wrap
from echoplan.model import Transducer
from echoplan.simulation import Simulation
from echoplan.simulation.scene import build_scene
from echoplan.simulation.shots import memory_of
from helpers.oracles import bistatic_cylinder_echo

# The pose of the receiver when a path of some length arrives.
ReceiverAfter: TypeAlias = Callable[[float], FloatArray]
Pair: TypeAlias = tuple[FloatArray, FloatArray]

TIE = 1e-9
# Only echoes that are louder than this share of the threshold are compared: the machine code leaves fainter ones out.
FLOOR = 0.02


@dataclass(frozen=True, slots=True, kw_only=True)
class Path:
    """A path of sound: where it is turned, the pose of the receiver at its end, the law of its echo, its length."""

    turns: list[FloatArray]
    receiver: FloatArray
    law: complex
    length: float


@dataclass(frozen=True, slots=True, eq=False)
class Twin:
    """Receives what the pings of a simulation receive."""

    simulation: Simulation

    def echoes(self, ping: int) -> tuple[FloatArray, ComplexArray]:
        """Arrivals and strengths of all echoes of a ping, in the order of time."""
        found = [echo for shot in self.shots(ping) for echo in self.received(shot, ping)]
        found.sort(key=lambda echo: echo[0])
        return np.array([time for time, _ in found]), np.array([strength for _, strength in found], dtype=complex)

    def shots(self, ping: int) -> list[int]:
        """The bursts that a ping may receive."""
        schedule, settings = self.simulation._schedule, self.simulation.settings
        fired = (schedule.stamps_ns - schedule.stamps_ns[ping]) * 1e-9
        memory = memory_of(self.transducer, settings.air) if settings.second_time_around else 0.0
        soon = fired < (self.deadline(ping) if settings.second_time_around else 1e-9)
        audible = (fired >= -memory) & soon
        if not settings.crosstalk:
            audible &= schedule.sensors == schedule.sensors[ping]
        return [int(shot) for shot in np.flatnonzero(audible)]

    def received(self, shot: int, ping: int) -> Iterator[tuple[float, complex]]:
        """Echoes of one burst."""
        schedule, air, f = self.simulation._schedule, self.simulation.settings.air, self.transducer.frequency
        fired = float(schedule.stamps_ns[shot] - schedule.stamps_ns[ping]) * 1e-9
        source = schedule.map_from_sensors[shot]

        def receiver_after(length: float) -> FloatArray:
            pose: FloatArray = schedule.map_from_sensors[ping] + schedule.velocities[ping] * (
                fired + length / self.speed
            )
            return pose

        for path in self.paths(source[:2], receiver_after):
            time, receiver = fired + path.length / self.speed, path.receiver[:2]
            beams = self.beam(source[2], path.turns[0] - source[:2]) * self.beam(
                path.receiver[2], path.turns[-1] - receiver
            )
            gain = 10 ** ((self.transducer.figure_of_merit - air.absorption(f) * path.length) / 20)
            strength = gain * beams * path.law
            audible = 0 <= time <= self.deadline(ping) and abs(strength) >= FLOOR
            if audible and self.clear([source[:2], *path.turns, receiver]):
                yield time, complex(strength * np.exp(-2j * np.pi * f * time))

    def paths(self, source: FloatArray, receiver_after: ReceiverAfter) -> Iterator[Path]:
        """All paths of the order that the settings allow."""
        settings = self.simulation.settings
        if settings.reflection_order >= 1:
            yield from self.once(source, receiver_after)
        if settings.reflection_order >= 2:
            yield from self.twice(source, receiver_after)
        if settings.diffraction:
            k = float(wavenumber(self.transducer.frequency, self.speed))
            for edge in build_scene(self.simulation.world).edges:
                yield from over_edge(edge, k, source, receiver_after)

    def once(self, source: FloatArray, receiver_after: ReceiverAfter) -> Iterator[Path]:
        """All single reflections."""
        for face, gain in self.faces:
            yield over_face(face, gain, source, receiver_after)
        for disc, gain in self.discs:
            yield from over_disc(disc, gain, source, receiver_after)

    def twice(self, source: FloatArray, receiver_after: ReceiverAfter) -> Iterator[Path]:
        """All double reflections."""
        for (first, gain), (second, other) in itertools.permutations(self.faces, 2):
            yield over_faces((first, second), gain * other, source, receiver_after)
        for (face, gain), (disc, other) in itertools.product(self.faces, self.discs):
            yield from over_face_and_disc((face, disc), gain * other, source, receiver_after)
            yield from over_disc_and_face((face, disc), gain * other, source, receiver_after)

    def clear(self, points: list[FloatArray]) -> bool:
        """Whether nothing stands between the points of a path."""
        legs = np.array(list(itertools.pairwise(points)))
        shift = 1e-7 * (legs[:, 1] - legs[:, 0])
        world = self.simulation.world
        discs = world.discs - [0.0, 0.0, TIE]
        blocked = is_blocked(legs[:, 0] + shift, legs[:, 1] - shift, segments_xy=world.segments_xy, discs=discs)
        return not blocked.any()

    def beam(self, bearing: float, toward: FloatArray) -> float:
        """Directivity towards a point."""
        off = wrap(np.arctan2(toward[1], toward[0]) - bearing)
        return float(directivity(off, piston_ka(self.transducer, self.simulation.settings.air)))

    def deadline(self, ping: int) -> float:
        """How long a ping listens."""
        return float(self.simulation._module.deadlines(self.simulation._schedule.sensors[[ping]])[0])

    @property
    def transducer(self) -> Transducer:
        """What sends and receives."""
        assert self.simulation.rig.transducer
        return self.simulation.rig.transducer

    @property
    def speed(self) -> float:
        """Speed of sound."""
        return self.simulation.settings.air.speed_of_sound

    @property
    def faces(self) -> list[tuple[FloatArray, float]]:
        """Faces and their reflection coefficients."""
        world = self.simulation.world
        names = [line.material for line in world.polylines for _ in line.segments_xy]
        return list(zip(world.segments_xy, reflection_coefficients(names).tolist(), strict=True))

    @property
    def discs(self) -> list[tuple[FloatArray, float]]:
        """Cylinders and their reflection coefficients."""
        world = self.simulation.world
        gains = reflection_coefficients([each.material for each in world.pillars])
        return list(zip(world.discs, gains.tolist(), strict=True))


def over_face(segment: FloatArray, gain: float, source: FloatArray, receiver_after: ReceiverAfter) -> Path:
    """The reflection of a face."""
    image = mirrored(segment, source)
    receiver = receiver_after(distance(image, receiver_after(0.0)))
    spot, lit = bounce(segment, source, receiver)
    length = distance(image, receiver)
    return Path(turns=[spot], receiver=receiver, law=lit * gain / length, length=length)


def over_faces(pair: Pair, gain: float, source: FloatArray, receiver_after: ReceiverAfter) -> Path:
    """The double reflection of two faces."""
    first, second = pair
    image = mirrored(first, source)
    final = mirrored(second, image)
    receiver = receiver_after(distance(final, receiver_after(0.0)))
    last, last_lit = bounce(second, image, receiver)
    start, start_lit = bounce(first, source, last)
    turned_away = height(first, second.mean(axis=0)) * height(first, source) <= 0
    lit = 0.0 if last_lit == start_lit == 0.5 and turned_away else min(last_lit, start_lit)
    length = distance(final, receiver)
    return Path(turns=[start, last], receiver=receiver, law=lit * gain / length, length=length)


def over_disc(disc: FloatArray, gain: float, source: FloatArray, receiver_after: ReceiverAfter) -> Iterator[Path]:
    """The reflection of a cylinder."""
    receiver = receiver_after(around(disc, source, receiver_after(0.0)))
    spot = reflection_point(disc, source, receiver)
    if spot is not None:
        yield Path(
            turns=[spot],
            receiver=receiver,
            law=gain * disc_law(disc, spot, source, receiver),
            length=way(source, spot, receiver),
        )


def over_face_and_disc(pair: Pair, gain: float, source: FloatArray, receiver_after: ReceiverAfter) -> Iterator[Path]:
    """The reflection of a face, then of a cylinder."""
    face, disc = pair
    image = mirrored(face, source)
    receiver = receiver_after(around(disc, image, receiver_after(0.0)))
    spot = reflection_point(disc, image, receiver)
    if spot is not None:
        turn, lit = bounce(face, source, spot)
        law = lit * gain * disc_law(disc, spot, image, receiver)
        yield Path(turns=[turn, spot], receiver=receiver, law=law, length=way(image, spot, receiver))


def over_disc_and_face(pair: Pair, gain: float, source: FloatArray, receiver_after: ReceiverAfter) -> Iterator[Path]:
    """The reflection of a cylinder, then of a face."""
    face, disc = pair
    receiver = receiver_after(around(disc, source, mirrored(face, receiver_after(0.0))))
    image = mirrored(face, receiver)
    spot = reflection_point(disc, source, image)
    if spot is not None:
        turn, lit = bounce(face, spot, receiver)
        law = lit * gain * disc_law(disc, spot, source, image)
        yield Path(turns=[spot, turn], receiver=receiver, law=law, length=way(source, spot, image))


def over_edge(edge: Any, k: float, source: FloatArray, receiver_after: ReceiverAfter) -> Iterator[Path]:
    """The diffraction at an edge."""
    apex = np.array([edge["apex"].real, edge["apex"].imag])
    receiver = receiver_after(way(source, apex, receiver_after(0.0)))
    there, back = distance(source, apex), distance(apex, receiver)
    incident, observed = (
        float(wrap(np.arctan2(end[1] - apex[1], end[0] - apex[0]) - edge["first"] - np.pi) + np.pi)
        for end in (source, receiver)
    )
    if max(incident, observed) <= edge["opening"]:
        coefficient = wedge_coefficient(
            incident,
            observed,
            opening=edge["opening"],
            wavenumber=k,
            distance_parameter=there * back / (there + back),
            reflection=(edge["first_gain"], edge["second_gain"]),
        )
        law = complex(coefficient * np.sqrt(there / (back * (there + back))) / there)
        yield Path(turns=[apex], receiver=receiver, law=law, length=there + back)


def first_crossing(
    times: FloatArray, strengths: ComplexArray, transducer: Transducer, *, begin: float, end: float, carrier: bool
) -> float:
    """When the sum of echoes first reaches the threshold, by looking every tenth of a microsecond."""
    clock = np.arange(begin, end, 1e-7)
    total = np.zeros(len(clock), dtype=complex)
    for time, strength in zip(times, strengths, strict=True):
        total += strength * burst_envelope(clock - time, transducer)
    level = (total * np.exp(2j * np.pi * transducer.frequency * clock)).real if carrier else abs(total)
    above = np.flatnonzero(level >= 1)
    return float(clock[above[0]]) if len(above) else np.inf


def distance(p: FloatArray, q: FloatArray) -> float:
    """How far apart two points are."""
    return float(np.hypot(p[0] - q[0], p[1] - q[1]))


def way(p: FloatArray, over: FloatArray, q: FloatArray) -> float:
    """Length of a way over a point."""
    return distance(p, over) + distance(over, q)


def around(disc: FloatArray, p: FloatArray, q: FloatArray) -> float:
    """Nearly the length of the way over a cylinder."""
    return way(p, disc[:2], q) - 2 * float(disc[2])


def height(segment: FloatArray, point: FloatArray) -> float:
    """Signed distance of a point from the line of a face."""
    along = (segment[1] - segment[0]) / distance(segment[0], segment[1])
    return float(along[0] * (point[1] - segment[0, 1]) - along[1] * (point[0] - segment[0, 0]))


def mirrored(segment: FloatArray, point: FloatArray) -> FloatArray:
    """Mirror image of a point in the line of a face."""
    along = (segment[1] - segment[0]) / distance(segment[0], segment[1])
    image: FloatArray = point[:2] - 2 * height(segment, point) * np.array([-along[1], along[0]])
    return image


def bounce(segment: FloatArray, p: FloatArray, q: FloatArray) -> tuple[FloatArray, float]:
    """Where a face reflects sound from p to q, and the share that it returns there."""
    high, other = height(segment, p), height(segment, q)
    if min(high, other) < -TIE and max(high, other) > TIE:
        return p, 0.0
    image, along = mirrored(segment, p), (segment[1] - segment[0]) / distance(segment[0], segment[1])
    share = abs(high) / (abs(high) + abs(other)) if abs(high) + abs(other) > TIE else 0.5
    spot = image + share * (q[:2] - image)
    on_face = float((spot - segment[0]) @ along)
    inside = min(on_face, distance(segment[0], segment[1]) - on_face)
    return spot, 1.0 if inside > TIE else 0.5 if inside >= -TIE else 0.0


def reflection_point(disc: FloatArray, p: FloatArray, q: FloatArray) -> FloatArray | None:
    """Where a cylinder reflects sound from p to q: where the way over its lit side is shortest."""
    center, radius = disc[:2], float(disc[2])
    if min(distance(p, center), distance(q, center)) <= radius:
        return None
    from_p, from_q = (float(np.arctan2(end[1] - center[1], end[0] - center[0])) for end in (p, q))
    span = float(wrap(from_q - from_p))

    def length(share: float) -> float:
        return way(p, center + radius * directions(from_p + share * span), q)

    share = minimize_scalar(length, bounds=(-1e-6, 1 + 1e-6), method="bounded", options={"xatol": 1e-12}).x
    normal = directions(from_p + share * span)
    spot = center + radius * normal
    lit = min(float(normal @ (end[:2] - spot)) for end in (p, q)) > 0
    return spot if lit else None


def disc_law(disc: FloatArray, spot: FloatArray, p: FloatArray, q: FloatArray) -> float:
    """Echo law of a cylinder."""
    normal = (spot - disc[:2]) / disc[2]
    incidence = np.arccos(np.clip(normal @ (p[:2] - spot) / distance(p, spot), -1, 1))
    return float(bistatic_cylinder_echo(distance(p, spot), distance(spot, q), disc[2], incidence=incidence))
