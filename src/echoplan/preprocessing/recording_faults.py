"""Faults of a recording as a whole: whether it has positions, how many, and whether it is of sonar."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from echoplan.model import Rig, Sweep
from echoplan.preprocessing.beams import cone_of_rays
from echoplan.preprocessing.constancy import Trace
from echoplan.preprocessing.measurements import join_measurements, measurements_of
from echoplan.preprocessing.rays import are_rays

__all__ = [
    "ENOUGH_PLACES",
    "RecordingFault",
    "RecordingFaultKind",
    "count_places",
    "find_beam_faults",
    "find_place_faults",
]

# Positions nearer to each other are one place: from there a wall and a pole differ by less than readings scatter [m].
_APART = 0.1
# From so many places at least a wall, a corner and a pole differ.
ENOUGH_PLACES = 3
# Readings of a sensor in one direction, to this width [rad], agree to this [m]: as far as a hand sways that turns it.
_DIRECTION, _AGREE = math.radians(5.0), 0.2
# At one place nearly all readings agree with those of before; from the stations of simulated rooms without their poses
# 12 to 63 % do.  Fewer directions do not show it.
_SAME_PLACE, _DIRECTIONS = 0.7, 8
# Neither sonar nor simulated sonar has so narrow a beam: half of the opening angle [rad].  Sweeps of fewer readings
# show none.
_NARROW, _FEWEST = math.radians(2.5), 20


class RecordingFaultKind(StrEnum):
    """What is wrong with a recording."""

    NO_POSES = "no-poses"
    ONE_PLACE = "one-place"
    TWO_PLACES = "two-places"
    NARROW_BEAM = "narrow-beam"


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordingFault:
    """A fault of a recording as a whole.

    Parameters
    ----------
    kind : RecordingFaultKind
        What is wrong.
    value : float, optional
        Of ``NO_POSES`` the share of readings that agree with those of before in the same direction; of ``NARROW_BEAM``
        half of the opening angle [rad]; else nan.
    """

    kind: RecordingFaultKind
    value: float = math.nan


def count_places(sweeps: Sequence[Sweep]) -> int:
    """Count the places from which a recording was made, up to three, which are enough.

    Parameters
    ----------
    sweeps : sequence of Sweep
        All sweeps.

    Returns
    -------
    int
        Places at least 10 cm apart.
    """
    count, left = 0, np.concatenate([np.zeros((0, 2)), *(sweep.map_from_base[:, :2] for sweep in sweeps)])
    while len(left) and count < ENOUGH_PLACES:
        left = left[np.hypot(*(left - left[0]).T) > _APART]
        count += 1
    return count


def find_place_faults(sweeps: Sequence[Sweep], traces: Sequence[Trace]) -> tuple[RecordingFault, ...]:
    """Find out whether the positions of a recording suffice for a map.

    Parameters
    ----------
    sweeps : sequence of Sweep
        All sweeps, none empty.
    traces : sequence of Trace
        Their pings, sensor by sensor.

    Returns
    -------
    tuple of RecordingFault
        One at most.
    """
    count = count_places(sweeps)
    if count >= ENOUGH_PLACES:
        return ()
    if count == ENOUGH_PLACES - 1:
        return (RecordingFault(kind=RecordingFaultKind.TWO_PLACES),)
    shares = [share for trace in traces for share in _agreements(trace)]
    if len(shares) >= _DIRECTIONS and np.mean(shares) < _SAME_PLACE:
        return (RecordingFault(kind=RecordingFaultKind.NO_POSES, value=float(np.mean(shares))),)
    return (RecordingFault(kind=RecordingFaultKind.ONE_PLACE),)


def find_beam_faults(sweeps: Sequence[Sweep], rig: Rig) -> tuple[RecordingFault, ...]:
    """Find out whether readings are of a beam too narrow for sonar: a laser, or infrared.

    Parameters
    ----------
    sweeps : sequence of Sweep
        All sweeps, without what faults of sensors put there.
    rig : Rig
        What made them; nothing is found if it says whether they are rays.

    Returns
    -------
    tuple of RecordingFault
        One at most.
    """
    scans = [measurements_of(sweep, rig) for sweep in sweeps if len(sweep) >= _FEWEST]
    if rig.rays is not None or not scans:
        return ()
    joined = join_measurements(scans)
    cone = cone_of_rays(joined) if are_rays(joined) else math.nan
    return (RecordingFault(kind=RecordingFaultKind.NARROW_BEAM, value=cone),) if cone < _NARROW else ()


def _agreements(trace: Trace) -> list[float]:
    """Return the share of readings that agree with those half a recording before, direction by direction."""
    directions = np.rint(trace.bearings / _DIRECTION) % round(2 * math.pi / _DIRECTION)
    finite, shares = np.isfinite(trace.readings), []
    for direction in np.unique(directions):
        readings = trace.readings[finite & (directions == direction)]
        half = len(readings) // 2
        if half:
            shares.append(float(np.mean(np.abs(readings[-half:] - readings[:half]) <= _AGREE)))
    return shares
