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
from echoplan.joint.mapper import JointMapper
from echoplan.joint.settings import PoseMode
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
) -> tuple[FeatureMap, tuple[Sweep, ...]]:
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
    feature_map : FeatureMap
        The map, in the frame of the first recording.  Sweeps are numbered through all recordings.
    sweeps : tuple of Sweep
        All sweeps as recorded, but in that frame and with these numbers.

    Raises
    ------
    InputError
        If several recordings are to be mapped, and the method maps one only, their poses are to be trusted, they have
        different sensors, or one has no pings or no positions, or begins where those before it show too little.
    """
    if len(recordings.sources) > 1:
        _check_several(mapper, recordings)
    found, mapped = map_sweeps(mapper, recordings.sweeps[0], follow=follow), recordings.sweeps[0]
    for name, recorded in zip(recordings.names[1:], recordings.sweeps[1:], strict=True):
        sweeps = [sweep for sweep in recorded if len(sweep)]
        faults = find_faults(sweeps, mapper.rig)
        start = _start(name, clean_sweeps(sweeps, mapper.rig, faults), known=found, rig=mapper.rig)
        mapper.begin_recording(start)
        moved = _after(mapped[-1], sweeps, away=compose(start, invert(sweeps[0].station)))
        for sweep in follow(clean_sweeps(moved, mapper.rig, faults)):
            mapper.add(sweep)
        found, mapped = mapper.result(), (*mapped, *moved)
    return found, mapped


def _check_several(mapper: LocalMapper, recordings: Recordings) -> None:
    """Refuse recordings that cannot be mapped together."""
    if not isinstance(mapper.mapper, JointMapper):
        raise InputError("--method", "it maps one recording only", remedy="use joint for several recordings")
    if mapper.mapper.settings.poses is PoseMode.TRUST:
        problem = "only the poses of the first of several recordings can be trusted: each has a frame of its own"
        raise InputError("--poses", problem, remedy="leave it out")
    for name, source, sweeps in zip(recordings.names, recordings.sources, recordings.sweeps, strict=True):
        if source.rig.sensors != mapper.rig.sensors:
            problem = f"its sensors are not those of {recordings.names[0]}"
            raise InputError(name, problem, remedy="map it alone, or correct its rig.toml")
        if not any(map(len, sweeps)):
            raise InputError(name, "it has no pings", remedy="leave it out")
        if find_faults(sweeps, mapper.rig).has_no_poses:
            raise InputError(name, "it has no positions", remedy="record the poses of the robot with it")


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
    """Return the pose of the first sweep in the map of the recordings before it, shape (3,) [m, m, rad].

    The recorded pose is tried first: recordings in one frame can be joined in a symmetric place, too.
    """
    numbers, recorded = stations_of(sweeps).numbers, sweeps[0].station
    for stations in _STATIONS:
        first = sweeps[: int(np.searchsorted(numbers, stations))]
        for start in (recorded, None):
            found = _located(first, known=known, rig=rig, start=start)
            if found is not None:
                return found
    problem = "it begins where the recordings before it show too little, or in one of several places that look alike"
    raise InputError(name, problem, remedy="begin each recording where another one was, or map it alone")


def _located(sweeps: Sequence[Sweep], *, known: FeatureMap, rig: Rig, start: FloatArray | None) -> FloatArray | None:
    """Return the pose of the first of some sweeps in a map if it is certain, shape (3,) [m, m, rad]."""
    try:
        found = localise(sweeps, known, rig=rig, start=start)
    except InvalidValueError:
        return None
    is_certain = assess_localisation(found, known).verdict is Verdict.GOOD and not found.kidnapped
    return found.poses[0] if is_certain else None
