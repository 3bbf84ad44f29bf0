"""One ping with all readings that it might give, to see which of them something explains best."""

import itertools
from dataclasses import replace

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.geometry import directions
from echoplan.joint.likelihood.ping_scores import NO_ECHO
from echoplan.preprocessing.measurements import Measurements
from helpers.expectations import REACH, SONAR

# Without a walk a reading is the depth itself.
PLAIN = replace(SONAR, walk_gain=0.0)


def one_ping(
    place: tuple[float, float],
    bearing: float,
    *,
    mate: tuple[float, float] | None = None,
    mate_bearing: float = 0.0,
    lag: float = 0.0,
) -> Measurements:
    """One ping at a place, as often as there are readings to try, a tenth of a millimetre apart, and its mate."""
    readings = np.append(np.arange(0.3, REACH - 0.1, 1e-4), np.inf)
    count = len(readings)
    x, y = np.full(count, place[0]), np.full(count, place[1])
    axes, crosstalk_sources = np.tile(directions(bearing), (count, 1)), np.full((count, 2), -1)
    if mate:
        x, y, axes[-1], crosstalk_sources[:-1, 1] = (
            np.append(x[1:], mate[0]),
            np.append(y[1:], mate[1]),
            directions(mate_bearing),
            count - 1,
        )
    nothing = np.zeros(count)
    return Measurements(
        x=x,
        y=y,
        ux=axes[:, 0].copy(),
        uy=axes[:, 1].copy(),
        arms_x=nothing,
        arms_y=nothing,
        angles=nothing,
        rates=nothing,
        readings=readings,
        stations=np.zeros(count, dtype=np.int64),
        sensors=np.zeros(count, dtype=np.int64),
        crosstalk_sources=crosstalk_sources,
        crosstalk_delays=np.full((count, 2), lag),
        weights=nothing + 1.0,
        ways=nothing,
        centers=np.array([place]),
        min_range=0.03,
        max_range=REACH,
    )


def likeliest(measurements: Measurements, log_densities: FloatArray) -> float:
    """The reading that a ghost explains best [m]."""
    assert log_densities.max() > NO_ECHO
    return float(measurements.readings[np.argmax(log_densities)])


def point_on(reflector: FloatArray, along: float) -> FloatArray:
    """A place along a wall."""
    point: FloatArray = reflector[2] * directions(reflector[1]) + along * directions(reflector[1] + np.pi / 2)
    return point


def length(*points: FloatArray) -> float:
    """Length of a way through points."""
    return float(sum(np.hypot(*(b - a)) for a, b in itertools.pairwise(points)))
