"""Reflectors: lines and points that win the votes of many echoes, each echo going to one of them."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.classical.features.fits import fit_circle, fit_line
from echoplan.classical.features.observations import Observation, Stack
from echoplan.classical.loci.loci import Loci
from echoplan.classical.loci.votes import VoteSettings, chance_votes, line_ballot, point_ballot
from echoplan.extraction import LocatedPoint
from echoplan.geometry import circular_mean, directions, wrap

__all__ = ["Reflector", "ReflectorKind", "echo_points", "find_reflectors", "observations_of_reflector"]

_ROUNDS = 10
# A point is a circle of no radius; the fit wants to know how surely [m].
_NO_RADIUS = 1e-6


class ReflectorKind(StrEnum):
    """What echoes may share: a tangent or a point."""

    LINE = "line"
    POINT = "point"


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Reflector:
    """What a group of echoes has in common.

    Parameters
    ----------
    kind : ReflectorKind
        A tangent or a point.
    parameters : ndarray, shape (2,)
        ``(normal_angle, offset)`` of a line [rad, m], or ``(x, y)`` of a point [m].
    members : ndarray of int, shape (m,)
        Numbers of the arcs.
    """

    kind: ReflectorKind
    parameters: FloatArray
    members: IntArray


def find_reflectors(loci: Loci, settings: VoteSettings) -> list[Reflector]:
    """Let arcs vote for lines and points, and give each to the winner that it fits.

    The leading cell of both accumulators wins, if enough sweeps voted for it.  A line or point is fitted to its
    voters, takes all free arcs within the gate, and is fitted again; their votes are then withdrawn.

    Parameters
    ----------
    loci : Loci
        The arcs.
    settings : VoteSettings
        Cells and gates.

    Returns
    -------
    list of Reflector
        Those with most votes first; no arc belongs to two.
    """
    ballots = {ReflectorKind.LINE: line_ballot(loci, settings), ReflectorKind.POINT: point_ballot(loci, settings)}
    free = np.ones(len(loci), dtype=bool)
    found: list[Reflector] = []
    cells = sum(map(len, ballots.values()))
    least = _least_votes(loci, cells, settings)
    while True:
        leaders = {kind: ballot.leader() for kind, ballot in ballots.items()}
        winners = {kind: votes for kind, (_, votes) in leaders.items() if votes >= least[kind]}
        if not winners:
            return found
        kind = max(winners, key=lambda each: winners[each])
        cell, _ = leaders[kind]
        reflector = _settled(kind, ballots[kind].voters(cell), loci, free, settings)
        if reflector is None:
            ballots[kind].strike(np.array([cell]))
            continue
        found.append(reflector)
        free[reflector.members] = False
        for ballot in ballots.values():
            ballot.withdraw(reflector.members)
        least = _least_votes(loci[free], cells, settings)


def observations_of_reflector(reflector: Reflector, loci: Loci, *, degrees: FloatArray) -> list[Observation]:
    """Return the observation of a reflector by each sweep.

    Parameters
    ----------
    reflector : Reflector
        A line or a point.
    loci : Loci
        All arcs.
    degrees : ndarray, shape (3,)
        How much it looks like a corner, a cylinder and a wall.

    Returns
    -------
    list of Observation
        One a sweep: the mean of its arcs, as seen from the mean of their centres; their direction is as uncertain
        as a beam is wide.
    """
    sweeps = loci.sweeps[reflector.members]
    return [
        Observation(
            sweep=int(sweep),
            point=_located(reflector, loci[reflector.members[sweeps == sweep]]),
            degrees=degrees,
            pings=int(np.count_nonzero(sweeps == sweep)),
        )
        for sweep in np.unique(sweeps)
    ]


def echo_points(reflector: Reflector, loci: Loci) -> FloatArray:
    """Locate the echoes of a reflector on their arcs.

    Parameters
    ----------
    reflector : Reflector
        A line or a point.
    loci : Loci
        All arcs.

    Returns
    -------
    ndarray, shape (m, 2)
        The point of each of its arcs that is nearest to it [m].
    """
    own = loci[reflector.members]
    points: FloatArray = own.centers_xy + own.ranges[:, None] * directions(_normals(reflector, own.centers_xy))
    return points


def _least_votes(loci: Loci, cells: int, settings: VoteSettings) -> dict[ReflectorKind, int]:
    # A square cell is wide, in the mean over all directions, by 4 / pi of its side.
    widths = {ReflectorKind.LINE: settings.offset_step, ReflectorKind.POINT: 4.0 / np.pi * settings.cell}
    return {
        kind: max(settings.min_votes, chance_votes(loci, width=width, cells=cells, settings=settings))
        for kind, width in widths.items()
    }


def _located(reflector: Reflector, own: Loci) -> LocatedPoint:
    hub = own.centers_xy.mean(axis=0)
    arms = own.centers_xy - hub
    distances = own.ranges + np.sum(arms * directions(_normals(reflector, own.centers_xy)), axis=1)
    beam = float(np.mean(own.half_apertures**2)) / 3
    return LocatedPoint(
        hub_xy=hub,
        bearing=circular_mean(own.bearings),
        distance=float(distances.mean()),
        covariance=np.diag([beam / len(own), float(distances.var())]),
    )


def _normals(reflector: Reflector, centers_xy: FloatArray) -> FloatArray:
    """Directions in which a reflector is nearest [rad], shape (n,)."""
    if reflector.kind is ReflectorKind.LINE:
        return np.full(len(centers_xy), reflector.parameters[0])
    away = reflector.parameters - centers_xy
    angles: FloatArray = np.arctan2(away[:, 1], away[:, 0])
    return angles


def _settled(
    kind: ReflectorKind, voters: IntArray, loci: Loci, free: BoolArray, settings: VoteSettings
) -> Reflector | None:
    """Fit and gather in turn until the arcs stay the same; None if too few sweeps have some."""
    if len(np.unique(loci.sweeps[voters])) < settings.min_sweeps:
        return None
    reflector = _fitted(kind, voters, loci, settings)
    for _ in range(_ROUNDS):
        members = np.flatnonzero(free & _fits(reflector, loci, settings))
        if len(np.unique(loci.sweeps[members])) < settings.min_sweeps:
            return None
        if np.array_equal(members, reflector.members):
            break
        reflector = _fitted(kind, members, loci, settings)
    return reflector


def _fitted(kind: ReflectorKind, members: IntArray, loci: Loci, settings: VoteSettings) -> Reflector:
    own = loci[members]
    stack = Stack(
        hubs_xy=own.centers_xy,
        bearings=own.bearings,
        distances=own.ranges,
        bearing_sigmas=own.half_apertures / np.sqrt(3),
        distance_sigmas=np.full(len(own), settings.gate / 2),
    )
    fit = fit_line(stack) if kind is ReflectorKind.LINE else fit_circle(stack, radius=0.0, radius_sigma=_NO_RADIUS)
    return Reflector(kind=kind, parameters=fit.parameters[:2], members=members)


def _fits(reflector: Reflector, loci: Loci, settings: VoteSettings) -> BoolArray:
    """Mask of the arcs that may come from a reflector: its distance matches, and it lies in their beam."""
    if reflector.kind is ReflectorKind.LINE:
        depths = reflector.parameters[1] - loci.centers_xy @ directions(reflector.parameters[0])
    else:
        depths = np.hypot(*(reflector.parameters - loci.centers_xy).T)
    turns = np.abs(wrap(_normals(reflector, loci.centers_xy) - loci.bearings))
    fits: BoolArray = (np.abs(depths - loci.ranges) <= settings.gate) & (turns <= loci.half_apertures)
    return fits
