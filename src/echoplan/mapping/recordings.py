"""Several recordings of one place in one map: each is located in the map of those before it."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from os import PathLike, fspath
from typing import TypeAlias, cast

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.diagnosis import assess_localisation
from echoplan.diagnosis.consistency import stations_of
from echoplan.errors import InputError, InvalidValueError
from echoplan.geometry import compose, invert
from echoplan.joint.localisation import localise
from echoplan.mapping.progress import Progress
from echoplan.methods import LocalMapper, map_sweeps
from echoplan.model import FeatureMap, Rig, Source, Sweep, Verdict
from echoplan.preprocessing import clean_sweeps, find_faults
from echoplan.sources import as_source

__all__ = ["OneOrSeveral", "Recordings", "map_recordings", "read_recordings"]

# A source or its name; one, or a list of them.
AnySource: TypeAlias = Source | str | PathLike[str]
OneOrSeveral: TypeAlias = AnySource | Sequence[AnySource]

# Numbers of stations by which a recording is located, in this order: only its beginning may lie in the map.
_STATIONS = (6, 4, 3)
# Time between two recordings if the clock of the later one does not go on [ns].
_PAUSE_NS = 1_000_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Recordings:
    """One recording, or several of one place, as they were read.

    Parameters
    ----------
    names : tuple of str
        What each was called by the user.
    sources : tuple of Source
        Where the sweeps came from.
    sweeps : tuple of tuple of Sweep
        Sweeps of each.
    """

    names: tuple[str, ...]
    sources: tuple[Source, ...]
    sweeps: tuple[tuple[Sweep, ...], ...]

    @property
    def first(self) -> Source:
        """Source of the first recording, whose frame is that of the map."""
        return self.sources[0]


def read_recordings(source: OneOrSeveral, *, progress: Progress) -> Recordings:
    """Read one source, or a list of them.

    Parameters
    ----------
    source : Source or str or Path, or list of them
        What ``echoplan.open`` returns, or what it takes.
    progress : Progress
        Shows how far it is.

    Returns
    -------
    Recordings
        Their sweeps.

    Raises
    ------
    InputError
        If a source cannot be used.
    """
    several = list(source) if source and isinstance(source, list | tuple) else [cast("AnySource", source)]
    sources = tuple(as_source(each) for each in several)
    names = (
        fspath(one) if isinstance(one, str | PathLike) else opened.name
        for one, opened in zip(several, sources, strict=True)
    )
    sweeps = tuple(tuple(progress.track(each, total=len(each), task="reading")) for each in sources)
    return Recordings(names=tuple(names), sources=sources, sweeps=sweeps)


def map_recordings(
    mapper: LocalMapper,
    recordings: Recordings,
    *,
    follow: Callable[[Sequence[Sweep]], Iterable[Sweep]] = iter,
) -> FeatureMap:
    """Map one recording, or several of one place, each with poses in a frame of its own.

    Parameters
    ----------
    mapper : LocalMapper
        The mapper.
    recordings : Recordings
        The recordings, in the order of time.
    follow : callable, optional
        Is given the cleaned sweeps of each recording, with poses in the frame of the map, and passes them on.

    Returns
    -------
    FeatureMap
        The map, in the frame of the first recording.  Sweeps are numbered through all recordings.

    Raises
    ------
    InputError
        If several recordings are to be mapped, and the method maps one only, or they have different sensors, or one has
        no pings or no positions, or begins where those before it show too little.
    """
    if len(recordings.sources) > 1:
        _check_several(mapper, recordings)
    found, before = map_sweeps(mapper, recordings.sweeps[0], follow=follow), recordings.sweeps[0]
    for name, recorded in zip(recordings.names[1:], recordings.sweeps[1:], strict=True):
        faults = find_faults(recorded, mapper.rig)
        if faults.has_no_poses:
            raise InputError(name, "it has no positions", remedy="record the poses of the robot with it")
        sweeps = [sweep for sweep in clean_sweeps(recorded, mapper.rig, faults) if len(sweep)]
        start = _start(name, sweeps, known=found, rig=mapper.rig)
        mapper.begin_recording(start)
        before = _after(before[-1], sweeps, away=compose(start, invert(sweeps[0].station)))
        for sweep in follow(before):
            mapper.add(sweep)
        found = mapper.result()
    return found


def _check_several(mapper: LocalMapper, recordings: Recordings) -> None:
    """Refuse recordings that cannot be mapped together."""
    if not mapper.maps_several:
        raise InputError("--method", "it maps one recording only", remedy="use joint for several recordings")
    for name, source, sweeps in zip(recordings.names, recordings.sources, recordings.sweeps, strict=True):
        if source.rig.sensors != mapper.rig.sensors:
            problem = f"its sensors are not those of {recordings.names[0]}"
            raise InputError(name, problem, remedy="map it alone, or correct its rig.toml")
        if not any(map(len, sweeps)):
            raise InputError(name, "it has no pings", remedy="leave it out")


def _after(last: Sweep, sweeps: Sequence[Sweep], *, away: FloatArray) -> tuple[Sweep, ...]:
    """Return sweeps with poses moved to the frame of the map, and with numbers and times after those of a sweep."""
    late = max(0, int(last.stamps_ns[-1]) + _PAUSE_NS - int(sweeps[0].stamps_ns[0]))
    return tuple(
        replace(
            sweep,
            index=last.index + 1 + number,
            stamps_ns=sweep.stamps_ns + late,
            map_from_base=compose(away, sweep.map_from_base),
        )
        for number, sweep in enumerate(sweeps)
    )


def _start(name: str, sweeps: Sequence[Sweep], *, known: FeatureMap, rig: Rig) -> FloatArray:
    """Return the pose of the first sweep in the map of the recordings before it, shape (3,) [m, m, rad]."""
    numbers = stations_of(sweeps).numbers
    for stations in _STATIONS:
        try:
            found = localise(sweeps[: int(np.searchsorted(numbers, stations))], known, rig=rig)
        except InvalidValueError:
            continue
        if assess_localisation(found, known).verdict is Verdict.GOOD and not found.kidnapped:
            pose: FloatArray = found.poses[0]
            return pose
    problem = "it begins where the recordings before it show too little, or in one of several places that look alike"
    raise InputError(name, problem, remedy="begin each recording where another one was, or map it alone")
