"""A survey: the sweeps of a live page so far, which viewers place and undo; each change is a new value."""

import zlib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from echoplan.arrays import FloatArray, IntArray
from echoplan.geometry import compose, invert
from echoplan.model import Recording, Rig, Sweep
from echoplan.preprocessing.stations import StationSettings, group_sweeps

__all__ = ["PackedSweep", "Survey"]

_INTEGERS, _FLOATS = ("stamps_ns", "sensor_ids"), ("servo_angles", "ranges")
# Between the end of a sweep and the start of one whose stamps lie before it [ns].
_GAP_NS = 1_000_000
# The mapper takes the median of repeated pings; so many determine it well.
_REPEATS = 9


@dataclass(frozen=True, slots=True, kw_only=True)
class PackedSweep:
    """A sweep in a tenth of the memory: an hour of a device at full rate is half a million pings.

    Parameters
    ----------
    index : int
        Number of the sweep.
    pings : int
        How many it has.
    station : tuple of float
        Pose of the robot halfway through it [m, m, rad].
    last_ns : int
        Stamp of its last ping [ns].
    temperature : float
        Of the air [degrees Celsius].
    data : bytes
        Its columns, compressed.
    """

    index: int
    pings: int
    station: tuple[float, float, float]
    last_ns: int
    temperature: float
    data: bytes

    @classmethod
    def pack(cls, sweep: Sweep) -> "PackedSweep":
        """Pack a sweep that has pings."""
        # Differences of stamps are nearly all the same.
        columns = [
            *(np.diff(getattr(sweep, name), prepend=0).astype(np.int64) for name in _INTEGERS),
            *(getattr(sweep, name) for name in _FLOATS),
            *sweep.map_from_base.T,
        ]
        x, y, yaw = sweep.station.tolist()
        return cls(
            index=sweep.index,
            pings=len(sweep),
            station=(x, y, yaw),
            last_ns=int(sweep.stamps_ns[-1]),
            temperature=sweep.temperature,
            data=zlib.compress(b"".join(column.tobytes() for column in columns)),
        )

    def unpack(self) -> Sweep:
        """Return the sweep itself."""
        words = np.frombuffer(zlib.decompress(self.data), dtype=np.int64).reshape(-1, self.pings)
        stamps, ids = np.cumsum(words[: len(_INTEGERS)], axis=1)
        angles, ranges, *poses = words[len(_INTEGERS) :].view(np.float64)
        return Sweep(
            index=self.index,
            stamps_ns=stamps,
            sensor_ids=ids,
            servo_angles=angles,
            ranges=ranges,
            map_from_base=np.stack(poses, axis=1),
            temperature=self.temperature,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Survey:
    """The sweeps so far of one source.

    Parameters
    ----------
    name : str
        What the source is called.
    rig : Rig
        What made the sweeps.
    sweeps : tuple of PackedSweep, optional
        In the order of time.
    """

    name: str
    rig: Rig = field(compare=False)
    sweeps: tuple[PackedSweep, ...] = ()

    def __len__(self) -> int:
        return len(self.sweeps)

    def __iter__(self) -> Iterator[Sweep]:
        return (each.unpack() for each in self.sweeps)

    @property
    def recording(self) -> Recording:
        """All sweeps as they were placed."""
        return Recording(name=self.name, rig=self.rig, sweeps=tuple(self))

    @property
    def stations(self) -> IntArray:
        """Number of the station of each sweep, shape (s,); sweeps that repeat each other are of one station."""
        if not self.sweeps:
            return np.zeros(0, dtype=np.int64)
        poses = np.array([each.station for each in self.sweeps])
        return group_sweeps(poses, np.array([each.pings for each in self.sweeps]), StationSettings()).numbers

    @property
    def station_poses(self) -> FloatArray:
        """Pose of the first sweep of each station [m, m, rad], shape (n, 3)."""
        firsts = np.unique(self.stations, return_index=True)[1]
        return np.array([self.sweeps[first].station for first in firsts]).reshape(-1, 3)

    def thinned(self) -> "Survey":
        """Keep the first sweeps of each station: more repeats change the map of a live page little, and take time."""
        counts, kept = Counter[int](), list[PackedSweep]()
        for sweep, station in zip(self.sweeps, self.stations.tolist(), strict=True):
            counts[station] += 1
            if counts[station] <= _REPEATS:
                kept.append(sweep)
        return replace(self, sweeps=tuple(kept))

    def with_sweep(self, sweep: Sweep) -> "Survey":
        """Add a sweep; it is numbered, and its stamps are moved if they would go back."""
        stamps = sweep.stamps_ns
        last = self.sweeps[-1] if self.sweeps else None
        if last is not None and stamps[0] <= last.last_ns:
            stamps = stamps + (last.last_ns + _GAP_NS - stamps[0])
        number = 0 if last is None else last.index + 1
        added = PackedSweep.pack(replace(sweep, index=number, stamps_ns=stamps))
        return replace(self, sweeps=(*self.sweeps, added))

    def with_station_at(self, station: int, *, map_from_base: FloatArray) -> "Survey":
        """Move a station [m, m, rad] with all its sweeps; a station that does not exist changes nothing."""
        moved, poses, numbers = list(self.sweeps), self.station_poses, self.stations
        for place in np.flatnonzero(numbers == station).tolist():
            sweep = moved[place].unpack()
            relative = compose(invert(poses[station]), sweep.map_from_base)
            moved[place] = PackedSweep.pack(replace(sweep, map_from_base=compose(map_from_base, relative)))
        return replace(self, sweeps=tuple(moved))

    def without_last_station(self) -> "Survey":
        """Drop the sweeps of the last station."""
        numbers = self.stations
        kept = numbers < numbers.max(initial=0)
        return replace(self, sweeps=tuple(each for each, keep in zip(self.sweeps, kept, strict=True) if keep))
