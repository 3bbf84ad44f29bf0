"""Conflicts between readings: arcs of some that lie in what others call free."""

import math
from typing import NamedTuple

import numpy as np

from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.classical.grids.cones import Cones
from echoplan.classical.grids.sectors import Raster, Trace, trace_sector
from echoplan.compiled import compiled, inlined

__all__ = ["Claims", "claims_of", "explanations", "pressure", "settle_conflicts"]

# Nearer than this a sound is not taken to be louder [m].
_NEAREST = 0.01
# An arc is so many standard deviations of a range thick.
_DEVIATIONS = 4.0


class Claims(NamedTuple):
    """What n pings claim of c cells: e claims of single cells to be on an arc, and the rest to be free.

    The claims of cell k are ``starts[k]`` to ``starts[k + 1]``, the loudest first.  A claim falls when the cell is
    called free with more pressure, so those of cell k that stand are the first ``standing[k]``.

    Attributes
    ----------
    starts : ndarray of int, shape (c + 1,)
        First claim of each cell.
    standing : ndarray of int, shape (c,)
        How many claims of each cell stand.
    passes : ndarray of int, shape (c,)
        How many pings that are kept call the cell free.
    owners : ndarray of int, shape (e,)
        Whose claim it is.
    pressures : ndarray, shape (e,)
        Sound pressure with which it is claimed.
    fits : ndarray, shape (e,)
        How well the cell explains the reading: by the beam, and by a Gaussian of what it lies off the arc.
    left : ndarray of int, shape (n,)
        How many claims of each ping stand.
    kept : ndarray of bool, shape (n,)
        Which pings are kept.
    """

    starts: IntArray
    standing: IntArray
    passes: IntArray
    owners: IntArray
    pressures: FloatArray
    fits: FloatArray
    left: IntArray
    kept: BoolArray


@inlined
def pressure(distance: float, turn: float) -> float:
    """Sound pressure by distance and by angle as a share of half the aperture: a Gaussian beam, as Kuc has it."""
    return math.exp(-2.0 * turn**2) / max(distance, _NEAREST)


def claims_of(cones: Cones, raster: Raster, trace: Trace, *, thickness: float) -> Claims:
    """Claim the cells of all arcs.

    Parameters
    ----------
    cones : Cones
        The pings.
    raster : Raster
        The cells.
    trace : Trace
        Room for the cells of the largest cone.
    thickness : float
        Thickness of arcs [m].

    Returns
    -------
    Claims
        All stand, and no ping is kept yet.
    """
    nowhere = np.zeros(0, dtype=np.int64)
    count = arc_claims((nowhere, nowhere, np.zeros((2, 0))), raster, cones, trace, thickness)
    cells, owners = np.zeros((2, count), dtype=np.int64)
    pressures, fits = weights = np.zeros((2, count))
    arc_claims((cells, owners, weights), raster, cones, trace, thickness)
    order = np.lexsort((-pressures, cells))
    counts = np.bincount(cells, minlength=raster.rows * raster.columns)
    return Claims(
        starts=np.concatenate([[0], np.cumsum(counts)]),
        standing=counts,
        passes=np.zeros_like(counts),
        owners=owners[order],
        pressures=pressures[order],
        fits=fits[order],
        left=np.bincount(owners, minlength=len(cones.x)),
        kept=np.zeros(len(cones.x), dtype=bool),
    )


@compiled
def arc_claims(
    found: tuple[IntArray, IntArray, FloatArray], raster: Raster, cones: Cones, trace: Trace, thickness: float
) -> int:
    """Write down cell, owner, pressure and fit of the claims of all arcs, as far as there is room, and count them."""
    cells, owners, weights = found
    count = 0
    for ping in range(len(cones.x)):
        if math.isinf(cones.readings[ping]):
            continue
        nearest, farthest = cones.readings[ping] - thickness / 2, cones.readings[ping] + thickness / 2
        for cell in range(trace_sector(trace, raster, cones, ping, farthest)):
            if trace.distances[cell] >= nearest:
                if count < len(cells):
                    cells[count] = trace.rows[cell] * raster.columns + trace.columns[cell]
                    owners[count] = ping
                    off = (trace.distances[cell] - cones.readings[ping]) / (thickness / _DEVIATIONS)
                    weights[0, count] = pressure(trace.distances[cell], trace.turns[cell])
                    weights[1, count] = math.exp(-0.5 * off**2 - 2.0 * trace.turns[cell] ** 2)
                count += 1
    return count


@compiled
def settle_conflicts(claims: Claims, raster: Raster, cones: Cones, trace: Trace, thickness: float) -> None:
    """Go through the pings, the shortest reading first, and keep those that leave every earlier one a cell."""
    fallen = np.zeros(len(cones.x), dtype=np.int64)
    for ping in range(len(cones.x)):
        silent = math.isinf(cones.readings[ping])
        depth = cones.reaches[ping] if silent else cones.readings[ping] - thickness / 2
        count = trace_sector(trace, raster, cones, ping, depth)
        mute = not silent and claims.left[ping] == 0
        if not mute and not any_silenced(claims, raster, trace, count, fallen):
            claims.kept[ping] = True
            clear(claims, raster, trace, count)


@inlined
def any_silenced(claims: Claims, raster: Raster, trace: Trace, count: int, fallen: IntArray) -> bool:
    """Return whether freeing some cells leaves a kept ping without any cell of its arc."""
    silenced = False
    for change in (1, -1):
        for cell in range(count):
            number = trace.rows[cell] * raster.columns + trace.columns[cell]
            loud = pressure(trace.distances[cell], trace.turns[cell])
            claim = claims.starts[number] + claims.standing[number] - 1
            while claim >= claims.starts[number] and claims.pressures[claim] < loud:
                owner = claims.owners[claim]
                fallen[owner] += change
                silenced = silenced or (claims.kept[owner] and fallen[owner] == claims.left[owner])
                claim -= 1
    return silenced


@inlined
def clear(claims: Claims, raster: Raster, trace: Trace, count: int) -> None:
    """Call cells free: claims with less pressure fall."""
    for cell in range(count):
        number = trace.rows[cell] * raster.columns + trace.columns[cell]
        loud = pressure(trace.distances[cell], trace.turns[cell])
        claims.passes[number] += 1
        while claims.standing[number] > 0:
            claim = claims.starts[number] + claims.standing[number] - 1
            if claims.pressures[claim] >= loud:
                break
            claims.left[claims.owners[claim]] -= 1
            claims.standing[number] -= 1


def explanations(claims: Claims, *, share: float) -> IntArray:
    """Explain each reading that is kept by the cells of its arc that fit most readings best.

    Parameters
    ----------
    claims : Claims
        After conflicts were settled.
    share : float
        Cells with so great a share of the best cell's votes explain the reading too.

    Returns
    -------
    ndarray of int, shape (c,)
        How many readings each cell explains.
    """
    cells = np.repeat(np.arange(len(claims.standing)), np.diff(claims.starts))
    places = np.arange(len(cells)) - claims.starts[cells]
    stands = (places < claims.standing[cells]) & claims.kept[claims.owners]
    cells, owners = cells[stands], claims.owners[stands]
    votes = np.bincount(cells, weights=claims.fits[stands], minlength=len(claims.standing))[cells]
    best = np.zeros(len(claims.kept))
    np.maximum.at(best, owners, votes)
    return np.bincount(cells[votes >= share * best[owners]], minlength=len(claims.standing))
