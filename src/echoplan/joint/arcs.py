"""Arcs: echoes of one reflector in one sweep, and the plane that fits each arc best."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from echoplan.acoustics.predicted_echo import Kind, SonarTables, echo_geometry, excess_of, walk_of
from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.compiled import compiled, inlined
from echoplan.extraction.runs import connected_runs
from echoplan.geometry import circular_mean, rotation_step, wrap
from echoplan.kernels import median_of
from echoplan.preprocessing.measurements import Measurements

__all__ = ["Arc", "ArcSettings", "arc_planes", "find_arcs"]

# Candidate normals relative to the mean bearing of an arc [rad]: the arc may be masked on one side.
_TURNS = np.radians(np.arange(-24.0, 25.0, 2.0))
# Rotation step below which arcs are dense, and from which each echo is an arc of its own [rad].
_DENSE, _SPARSE = math.radians(3.0), math.radians(10.0)
# Signal excess below which an observed echo counts against a plane [dB]; cap on the deviation of one ping [m].
_FAINT, _FAR = -2.0, 0.03
_WALL = int(Kind.WALL)


class ArcSettings(NamedTuple):
    """Thresholds that link neighbouring readings to arcs; arcs propose landmarks, the pings score them."""

    # Largest difference between neighbouring readings of an arc where pings are dense [m].
    jump: float = 0.018
    # Largest difference between neighbouring readings of an arc where pings are 3 degrees apart or more [m].
    coarse_jump: float = 0.03
    # Smallest value of both, in steps of the readings.
    resolutions: float = 2.2
    # Largest gap in an arc, in steps of rotation.
    max_gap: float = 4.5
    # Number of neighbours with which a ping may be linked.
    reach: int = 5


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Arc:
    """Echoes of one reflector in one sweep."""

    station: int
    # Indices into the measurements, shape (n,).
    pings: IntArray

    def share_of(self, chosen: BoolArray) -> float:
        """Return the share of the pings of the arc that a mask over all pings, shape (n,), selects."""
        return np.count_nonzero(chosen[self.pings]) / len(self.pings)


def find_arcs(measurements: Measurements, *, resolution: float, settings: ArcSettings) -> list[Arc]:
    """Find the arcs of every station in readings of the given resolution [m].

    An arc has at least three echoes where the rotation steps of the sensor are below 3 degrees, two where they are
    below 10 degrees, and one where they are coarser. Only arcs of the finest kind are split at local maxima of the
    range.
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
    return [
        part
        for run in runs
        # With few pings a local maximum may be noise.
        for part in (_apart(run, bearings, readings, jump) if step < _DENSE else [run])
        if len(part) >= least
    ]


def _apart(run: IntArray, bearings: FloatArray, readings: FloatArray, height: float) -> list[IntArray]:
    """Split a run at local maxima of range of at least ``height`` [m] prominence: a reflector has a single minimum."""
    from scipy.signal import find_peaks  # noqa: PLC0415 - SciPy is slow to import

    turns = wrap(bearings[run] - circular_mean(bearings[run]))
    along = run[np.argsort(turns, kind="stable")]
    ridges, _ = find_peaks(readings[along], prominence=height)
    return np.split(along, ridges) if len(ridges) else [run]


def arc_planes(arcs: Sequence[Arc], measurements: Measurements, tables: SonarTables) -> FloatArray:
    """Return the plane that fits each arc best, as ``(normal_angle, offset)`` [rad, m], shape (a, 2).

    The normal is searched within 24 degrees of the mean bearing of the arc. There must be at least one arc.
    """
    bounds = np.cumsum([0, *(len(arc.pings) for arc in arcs)])
    members = np.concatenate([arc.pings for arc in arcs])
    bearings = measurements.bearings
    middles = np.array([circular_mean(bearings[arc.pings]) for arc in arcs])
    return _planes(measurements, tables, members, bounds, middles)


@compiled
def _planes(
    measurements: Measurements, tables: SonarTables, members: IntArray, bounds: IntArray, middles: FloatArray
) -> FloatArray:
    planes = np.empty((len(middles), 2))
    for arc in range(len(middles)):
        pings, best = members[bounds[arc] : bounds[arc + 1]], math.inf
        for turn in _TURNS:
            normal = middles[arc] + turn
            offset, misfit = _offset(measurements, tables, pings, normal)
            # Among planes that fit equally well, prefer the normal nearest to the mean bearing.
            misfit += 0.002 * abs(turn)
            if misfit < best:
                best, planes[arc, 0], planes[arc, 1] = misfit, normal, offset
    return planes


@inlined
def _offset(measurements: Measurements, tables: SonarTables, pings: IntArray, normal: float) -> tuple[float, float]:
    """Return the median offset of planes with one normal that fit single pings, and the misfit to all pings [m].

    The misfit is the mean of the absolute deviations, each capped at 3 cm, plus 1 cm times the share of pings whose
    echo is expected below the threshold.
    """
    ranges = tables.scale * measurements.readings[pings]
    depth, silent = median_of(ranges), 0
    offsets, plane = np.empty(len(pings)), (_WALL, math.cos(normal), math.sin(normal), 0.0, 0.0)
    for number, ping in enumerate(pings):
        place = (measurements.x[ping], measurements.y[ping], measurements.ux[ping], measurements.uy[ping])
        toward, cosine, sine, _, _ = echo_geometry(plane, place)
        excess = excess_of(tables, (depth, cosine, sine, depth, 0.0))
        silent += excess < _FAINT
        offsets[number] = ranges[number] - walk_of(tables, excess) - toward
    offset = median_of(offsets)
    scatter = np.mean(np.minimum(np.abs(offsets - offset), _FAR))
    return float(offset), float(scatter + 0.01 * silent / len(pings))
