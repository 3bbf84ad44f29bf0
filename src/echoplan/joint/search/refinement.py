"""Refinement of one landmark on nearby readings by robust Gauss-Newton steps."""

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np

from echoplan.acoustics.echo_model import COSINE_LIMIT
from echoplan.acoustics.predicted_echo import (
    SILENCE,
    Kind,
    Shape,
    SonarTables,
    differentiate,
    echo_geometry,
    shape_of,
    walk_of,
)
from echoplan.arrays import FloatArray, IntArray
from echoplan.compiled import compiled, inlined
from echoplan.joint.landmarks import PARAMETERS
from echoplan.kernels import solve_small
from echoplan.preprocessing.measurements import Measurements

__all__ = ["AnnealingSchedule", "approach", "refine"]

# Standard deviation of readings [m], gate on residuals [m] and greatest number of steps; from coarse to fine.
AnnealingSchedule: TypeAlias = Sequence[tuple[float, float, int]]

_WALL, _CYLINDER = int(Kind.WALL), int(Kind.CYLINDER)

# Greatest change of each parameter in one step [rad or m, m, m].
_LONGEST = (0.06, 0.05, 0.05)
# Least and greatest radius of a cylinder [m].
_THIN, _THICK = 0.015, 0.45
# Standard deviation of the prior on each step, for directions that the pings leave open [rad or m, m, m].
_HOLD = (0.3, 0.3, 0.15)
# Readings count from this signal excess [dB] and depth [m] on.
_FAINT, _TINY = -3.0, 0.01
# Greatest range walk that is allowed for when readings are collected [m].
_WALK = 0.05


def approach(
    measurements: Measurements,
    tables: SonarTables,
    reflector: FloatArray,
    pings: IntArray,
    schedule: AnnealingSchedule,
) -> FloatArray:
    """Refine a landmark, shape (4,), on pings that may be its echoes, by an annealing schedule from coarse to fine."""
    moved = reflector
    for noise, band, rounds in schedule:
        moved = refine(measurements, tables, moved, pings, (noise, band), rounds)
    return moved


@compiled
def refine(
    measurements: Measurements,
    tables: SonarTables,
    reflector: FloatArray,
    pings: IntArray,
    scales: tuple[float, float],
    rounds: int,
) -> FloatArray:
    """Refine a landmark, shape (4,), on pings that may be its echoes, by at most ``rounds`` Gauss-Newton steps.

    ``scales`` are the standard deviation of readings and the gate on residuals [m]. With fewer than two pings in the
    gate the landmark does not change.
    """
    moved, noise, band = reflector.copy(), scales[0], scales[1]
    free = PARAMETERS[int(reflector[0])]
    near = _gathered(measurements, tables, shape_of(moved), pings, band)
    for turn in range(rounds):
        width = band if turn < rounds - 2 else max(0.6 * band, 4.0 * noise)
        step = _step(measurements, tables, moved, near, (noise, width))
        for axis in range(free):
            moved[1 + axis] += min(max(step[axis], -_LONGEST[axis]), _LONGEST[axis])
        if reflector[0] == _CYLINDER:
            moved[3] = min(max(moved[3], _THIN), _THICK)
        if max(abs(step[0]), abs(step[1]), abs(step[2])) < 1e-5:
            break
    return moved


@inlined
def _gathered(measurements: Measurements, tables: SonarTables, shape: Shape, pings: IntArray, band: float) -> IntArray:
    """Return the pings whose readings are near a landmark, with a margin for steps and range walk."""
    near, count = np.empty(len(pings), np.int64), 0
    for ping in pings:
        geometry = echo_geometry(
            shape, (measurements.x[ping], measurements.y[ping], measurements.ux[ping], measurements.uy[ping])
        )
        late = measurements.readings[ping] * tables.scale - geometry[0]
        if geometry[1] > COSINE_LIMIT and -band - _WALK < late < band + 2.0 * _WALK:
            near[count] = ping
            count += 1
    return near[:count].copy()


@inlined
def _step(
    measurements: Measurements,
    tables: SonarTables,
    reflector: FloatArray,
    pings: IntArray,
    scales: tuple[float, float],
) -> FloatArray:
    """Return one Gauss-Newton step on the pings within the gate, with Geman-McClure weights."""
    noise, band = scales
    shape, jacobian, count = shape_of(reflector), np.zeros(8), 0
    normal, right = np.zeros((3, 3)), np.zeros(3)
    for ping in pings:
        place = (measurements.x[ping], measurements.y[ping], measurements.ux[ping], measurements.uy[ping])
        depth, excess = differentiate(tables, shape, place, jacobian, 0.0)
        late = measurements.readings[ping] * tables.scale - depth - walk_of(tables, excess)
        if excess < _FAINT or excess == SILENCE or depth < _TINY or abs(late) >= band:
            continue
        weight = measurements.weights[ping] / (1.0 + (0.5 * late / noise) ** 2) ** 2
        count += 1
        for row in range(3):
            right[row] += weight * jacobian[row] * late
            for column in range(3):
                normal[row, column] += weight * jacobian[row] * jacobian[column]
    if count < 2:
        return np.zeros(3)
    for axis in range(3):
        normal[axis, axis] += (noise / _HOLD[axis]) ** 2 + 1e-3
    return solve_small(normal, right)
