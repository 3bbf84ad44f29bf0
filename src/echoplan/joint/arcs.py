"""Arcs: the echoes of one reflector in one sweep, and the plane that would explain them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pydantic import BaseModel, Field

from echoplan.acoustics.predicted_echo import Hearing, Kind, excess_of, look, walk_of
from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.compiled import compiled
from echoplan.extraction.runs import connected_runs
from echoplan.geometry import circular_mean, rotation_step, wrap
from echoplan.preprocessing.measurements import Measurements

__all__ = ["Arc", "ArcSettings", "arc_planes", "find_arcs"]

# A plane's normal is looked for in these directions from the middle of an arc [rad]: it may be masked on one side.
_TURNS = np.radians(np.arange(-24.0, 25.0, 2.0))
# Arcs of steps finer than this are dense; of coarser ones than that, every echo stands alone [rad].
_DENSE, _SPARSE = math.radians(3.0), math.radians(10.0)
# An echo expected so far below the threshold speaks against a plane [dB]; one so far off says no more than that [m].
_FAINT, _FAR = -2.0, 0.03
_WALL = int(Kind.WALL)


class ArcSettings(BaseModel, frozen=True, extra="forbid"):
    """What belongs together in one sweep; arcs only seed hypotheses, pings judge them."""

    jump: float = Field(default=0.018, gt=0.0, description="greatest step between neighbouring readings [m]")
    coarse_jump: float = Field(default=0.03, gt=0.0, description="likewise where pings are 3 degrees apart or more [m]")
    resolutions: float = Field(default=2.2, gt=0.0, description="least such step in steps of the readings")
    max_gap: float = Field(default=4.5, gt=0.0, description="missing steps of rotation that an arc survives")
    reach: int = Field(default=5, ge=1, le=1000, description="neighbours to which a ping may be linked")


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Arc:
    """Echoes of one reflector in one sweep.

    Parameters
    ----------
    station : int
        Number of the station.
    pings : ndarray of int, shape (n,)
        Indices into the soundings.
    """

    station: int
    pings: IntArray

    def share_of(self, chosen: BoolArray) -> float:
        """Tell how many of its echoes are among some pings.

        Parameters
        ----------
        chosen : ndarray of bool, shape (n,)
            Which of all pings.

        Returns
        -------
        float
            So many of one: NumPy's mean takes five times as long for so few.
        """
        return np.count_nonzero(chosen[self.pings]) / len(self.pings)


def find_arcs(measurements: Measurements, *, resolution: float, settings: ArcSettings) -> list[Arc]:
    """Find the arcs of every station.

    Parameters
    ----------
    measurements : Measurements
        The pings.
    resolution : float
        Step of the readings [m].
    settings : ArcSettings
        What belongs together.

    Returns
    -------
    list of Arc
        Runs of at least three echoes where pings are dense, parted at ridges; of two where they are coarse, and single
        echoes of a ring.
    """
    bearings, arcs = measurements.bearings, []
    for station in range(len(measurements.centers)):
        own = np.flatnonzero(measurements.stations == station)
        if len(own):
            runs = _runs(bearings[own], measurements.readings[own], resolution, settings)
            arcs += [Arc(station=station, pings=own[run]) for run in runs]
    return arcs


def _runs(bearings: FloatArray, readings: FloatArray, resolution: float, settings: ArcSettings) -> list[IntArray]:
    step = rotation_step(bearings)
    jump = max(settings.jump if step < _DENSE else settings.coarse_jump, settings.resolutions * resolution)
    gap = max(settings.max_gap * step, math.radians(4.5)) if step < _SPARSE else 1.2 * step
    least = 3 if step < _DENSE else 2 if step < _SPARSE else 1
    runs = connected_runs(bearings, readings, max_gap=gap, jump=jump, reach=settings.reach)
    # Where pings are few a ridge may be chance.
    parts = _parted(runs, bearings, readings, jump) if step < _DENSE else runs
    return [part for part in parts if len(part) >= least]


def _parted(runs: Sequence[IntArray], bearings: FloatArray, readings: FloatArray, height: float) -> list[IntArray]:
    """Part runs at their ridges."""
    return [part for run in runs for part in _apart(run, bearings, readings, height)]


def _apart(run: IntArray, bearings: FloatArray, readings: FloatArray, height: float) -> list[IntArray]:
    """Part a run where it is farther than to either side: of one reflector only one place is nearest."""
    from scipy.signal import find_peaks  # noqa: PLC0415 - SciPy is slow to import

    turns = wrap(bearings[run] - circular_mean(bearings[run]))
    along = run[np.argsort(turns, kind="stable")]
    ridges, _ = find_peaks(readings[along], prominence=height)
    return np.split(along, ridges) if len(ridges) else [run]


def arc_planes(arcs: Sequence[Arc], measurements: Measurements, hearing: Hearing) -> FloatArray:
    """Find the plane that explains each arc best by itself.

    Parameters
    ----------
    arcs : sequence of Arc
        The arcs, at least one.
    measurements : Measurements
        What their indices point to.
    hearing : Hearing
        The sonar.

    Returns
    -------
    ndarray, shape (a, 2)
        ``(normal_angle, offset)`` [rad, m], within 24 degrees of the middle of each arc.
    """
    bounds = np.cumsum([0, *(len(arc.pings) for arc in arcs)])
    members = np.concatenate([arc.pings for arc in arcs])
    bearings = measurements.bearings
    middles = np.array([circular_mean(bearings[arc.pings]) for arc in arcs])
    return _planes(measurements, hearing, members, bounds, middles)


@compiled
def _planes(
    measurements: Measurements, hearing: Hearing, members: IntArray, bounds: IntArray, middles: FloatArray
) -> FloatArray:
    planes = np.empty((len(middles), 2))
    for arc in range(len(middles)):
        pings, best = members[bounds[arc] : bounds[arc + 1]], math.inf
        for turn in _TURNS:
            normal = middles[arc] + turn
            offset, misfit = _offset(measurements, hearing, pings, normal)
            # Between planes that fit alike, that whose normal is nearest to the middle of the arc.
            misfit += 0.002 * abs(turn)
            if misfit < best:
                best, planes[arc, 0], planes[arc, 1] = misfit, normal, offset
    return planes


@compiled
def _offset(measurements: Measurements, hearing: Hearing, pings: IntArray, normal: float) -> tuple[float, float]:
    """Median offset of the planes with one normal that explain single pings, and how badly it explains all [m]."""
    ranges = hearing.scale * measurements.readings[pings]
    depth, silent = np.median(ranges), 0
    offsets, plane = np.empty(len(pings)), (_WALL, math.cos(normal), math.sin(normal), 0.0)
    for number, ping in enumerate(pings):
        place = (measurements.x[ping], measurements.y[ping], measurements.ux[ping], measurements.uy[ping])
        toward, cosine, sine, _, _ = look(plane, place)
        excess = excess_of(hearing, (depth, cosine, sine, depth, 0.0))
        silent += excess < _FAINT
        offsets[number] = ranges[number] - walk_of(hearing, excess) - toward
    offset = np.median(offsets)
    scatter = np.mean(np.minimum(np.abs(offsets - offset), _FAR))
    return float(offset), float(scatter + 0.01 * silent / len(pings))
