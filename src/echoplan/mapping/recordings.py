"""Several recordings of one place in one map: each is located in the map of those before it."""

from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from os import PathLike, fspath
from typing import TypeAlias, cast

import numpy as np
from pydantic import BaseModel

from echoplan.arrays import FloatArray
from echoplan.diagnosis.consistency import stations_of
from echoplan.diagnosis.localisation import disagreement, listed_starts
from echoplan.errors import InputError, InvalidValueError
from echoplan.geometry import compose, invert
from echoplan.joint.localisation import localise
from echoplan.joint.mapper import JointSettings
from echoplan.joint.settings import PoseMode
from echoplan.mapping.changes import Looks, contradicts, find_changes, outdated
from echoplan.mapping.progress import Progress
from echoplan.mapping.start import StartingMap, read_start, sensors_of
from echoplan.methods import LocalMapper, map_sweeps
from echoplan.model import Changes, FeatureMap, Localisation, Rig, Source, Sweep
from echoplan.preprocessing import clean_sweeps, find_faults
from echoplan.sources import as_source

__all__ = ["OneOrSeveral", "Recordings", "check_options", "check_sensors", "map_recordings", "open_recordings"]

# A source or its name; one, or a list of them.
AnySource: TypeAlias = Source | str | PathLike[str]
OneOrSeveral: TypeAlias = AnySource | Sequence[AnySource]

# Numbers of stations by which a recording is located, in this order: more of them decide between rooms that look alike,
# but perhaps only its beginning lies in the map.
_STATIONS = (24, 12, 6, 4)
# Last station, counted from 0, before which a robot may count as carried, and a number that means never. The first
# stations may fit the map nowhere, as in a doorway: then it counts as carried to the first one that fits.
_LOST, _NEVER = 3, -1
# Greatest median distance between the first poses in the map and the located ones [m]. Located poses err by less than
# 1 cm in the mean (benchmarks/localisation.py).
_LOCATED = 0.1
# Time between two recordings if the clock of the later one does not go on [ns].
_PAUSE_NS = 1_000_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Recordings:
    """One recording, or several of one place.

    Parameters
    ----------
    names : tuple of str
        What each was called by the user, and its number if another one has that name.
    sources : tuple of Source
        Where the sweeps came from.
    sweeps : tuple of tuple of Sweep, optional
        Sweeps of each, once they are read.
    """

    names: tuple[str, ...]
    sources: tuple[Source, ...]
    sweeps: tuple[tuple[Sweep, ...], ...] = ()

    @property
    def first(self) -> Source:
        """Source of the first recording, whose frame is that of the map."""
        return self.sources[0]

    @property
    def in_words(self) -> str:
        """Names of the sources, as a title has them."""
        first, *others = (each.name for each in self.sources)
        return " and ".join([first, *others] if len(others) < 2 else [first, f"{len(others)} other recordings"])

    def read(self, progress: Progress) -> "Recordings":
        """Return them with their sweeps.

        Parameters
        ----------
        progress : Progress
            Shows how far it is.

        Returns
        -------
        Recordings
            The same recordings.

        Raises
        ------
        InputError
            If a source cannot be read.
        """
        sweeps = tuple(tuple(progress.track(each, total=len(each), task="reading")) for each in self.sources)
        return replace(self, sweeps=sweeps)


def open_recordings(source: OneOrSeveral) -> Recordings:
    """Open one source, or a list of them.

    Parameters
    ----------
    source : Source or str or Path, or list of them
        What ``echoplan.open`` returns, or what it takes.

    Returns
    -------
    Recordings
        Without their sweeps.

    Raises
    ------
    InputError
        If a source cannot be used.
    """
    several = list(source) if source and isinstance(source, list | tuple) else [cast("AnySource", source)]
    sources = tuple(as_source(each) for each in several)
    names = [
        fspath(one) if isinstance(one, str | PathLike) else opened.name
        for one, opened in zip(several, sources, strict=True)
    ]
    # Folders in different places may have one name.
    distinct = (
        name if names.count(name) == 1 else f"{name} (recording {number})" for number, name in enumerate(names, start=1)
    )
    return Recordings(names=tuple(distinct), sources=sources)


def map_recordings(
    mapper: LocalMapper,
    recordings: Recordings,
    *,
    known: FeatureMap | None = None,
    follow: Callable[[Sequence[Sweep]], Iterable[Sweep]] = iter,
) -> tuple[FeatureMap, tuple[Sweep, ...]]:
    """Map one recording, or several of one place, each with poses in a frame of its own.

    Parameters
    ----------
    mapper : LocalMapper
        The mapper.
    recordings : Recordings
        The recordings, in the order of time.
    known : FeatureMap, optional
        The map from which the mapper goes on; none by default.
    follow : callable, optional
        Is given the cleaned sweeps of each recording, with poses in the frame of the map, and passes them on.

    Returns
    -------
    feature_map : FeatureMap
        The map, in the frame of the map before, or else of the first recording, with what changed from one recording to
        the next.  Sweeps are numbered through all recordings.
    sweeps : tuple of Sweep
        All sweeps as recorded, but in that frame and with these numbers.

    Raises
    ------
    InputError
        If of several recordings, or one after a map, one has no pings or no positions, is given twice, begins where
        those before it show too little, or does not fit them.
    """
    if len(recordings.sources) > 1 or known is not None:
        _check_readings(mapper.rig, recordings)
    found, mapped, changes = known, tuple[Sweep, ...](), list[Changes]()
    cleaned: list[Sweep] = []

    def keep(sweeps: Sequence[Sweep]) -> Iterable[Sweep]:
        """Keep the cleaned sweeps and pass them on."""
        cleaned.extend(sweeps)
        return follow(sweeps)

    for name, recorded in zip(recordings.names, recordings.sweeps, strict=True):
        if found is None:
            found, mapped = map_sweeps(mapper, recorded, follow=keep), recorded
            continue
        sweeps = [sweep for sweep in recorded if len(sweep)]
        faults = find_faults(sweeps, mapper.rig)
        located = _first_poses(name, clean_sweeps(sweeps, mapper.rig, faults), known=found, rig=mapper.rig)
        earlier, count = Looks(*mapper.looks(), mapper.misses(_at_poses(cleaned, found))), len(cleaned)
        mapper.begin_recording(located[0])
        moved = _moved(sweeps, away=compose(located[0], invert(sweeps[0].station)), after=mapped)
        for sweep in keep(clean_sweeps(moved, mapper.rig, faults)):
            mapper.add(sweep)
        before, found, mapped = found, mapper.result(), (*mapped, *moved)
        placed = _at_poses(cleaned[count:], found)
        later = earlier.later(Looks(*mapper.looks(), mapper.misses(placed)))
        _check_fit(name, before, later, sweeps=placed, located=located)
        if gone := outdated(before, earlier=earlier, later=later):
            mapper.forget(gone)
            found = mapper.result()
        changed = find_changes(before, found, earlier=earlier, later=later)
        changes.append(replace(changed, recording=name, first_sweep=moved[0].index))
    assert found is not None
    return replace(found, changes=tuple(changes)), mapped


def check_options(
    method: str, settings: BaseModel, *, recordings: int, start: str | PathLike[str] | None
) -> StartingMap | None:
    """Check, before anything is read, that a method can map so many recordings, or go on from a map.

    Parameters
    ----------
    method : str
        Name of the method.
    settings : BaseModel
        Its settings.
    recordings : int
        How many recordings are to be mapped.
    start : str or Path or None
        Folder of the map from which the new one goes on.

    Returns
    -------
    StartingMap or None
        That map.

    Raises
    ------
    InputError
        If the method maps one recording only, poses are to be trusted, or the map cannot be read.
    """
    if recordings == 1 and start is None:
        return None
    if not isinstance(settings, JointSettings):
        if start is not None:
            raise InputError("--start", f"{method} cannot go on from a map", remedy="use joint")
        raise InputError("--method", "it maps one recording only", remedy="use joint")
    if settings.poses is PoseMode.TRUST:
        problem = "the poses of a recording that goes on from another one cannot be trusted: its frame is its own"
        raise InputError("--poses", problem, remedy="leave it out")
    return None if start is None else read_start(start)


def check_sensors(recordings: Recordings, known: StartingMap | None) -> None:
    """Check that recordings have the same sensors, and those of the map from which the new one goes on.

    Parameters
    ----------
    recordings : Recordings
        The recordings.
    known : StartingMap or None
        That map.

    Raises
    ------
    InputError
        If one has others: noise and range scale of the map are those of its sensors.
    """
    before, wanted = recordings.names[0], sensors_of(recordings.first.rig)
    if known is not None:
        before, wanted = "the map of --start", known.sensors
    for name, source in zip(recordings.names, recordings.sources, strict=True):
        if not np.array_equal(sensors_of(source.rig), wanted):
            raise InputError(
                name, f"its sensors are not those of {before}", remedy="map it alone, or correct its rig.toml"
            )


def _check_readings(rig: Rig, recordings: Recordings) -> None:
    """Refuse recordings without pings or positions, and one that is given twice."""
    given = set[bytes]()
    for name, sweeps in zip(recordings.names, recordings.sweeps, strict=True):
        if not any(map(len, sweeps)):
            raise InputError(name, "it has no pings", remedy="leave it out")
        if find_faults(sweeps, rig).has_no_poses:
            raise InputError(name, "it has no positions", remedy="record the poses of the robot with it")
        readings = b"".join(sweep.ranges.tobytes() for sweep in sweeps)
        if readings in given:
            raise InputError(name, "it is given twice, so its echoes would count twice", remedy="name it once")
        given.add(readings)


def _check_fit(name: str, before: FeatureMap, later: Looks, *, sweeps: Sequence[Sweep], located: FloatArray) -> None:
    """Refuse a recording of another place, or one whose first sweeps are not where they were located."""
    if contradicts(before, later.views_xy):
        raise InputError(name, "it is of another place than what came before", remedy="map it alone")
    away = np.array([sweep.station for sweep in sweeps[: len(located)]]) - located
    off = float(np.median(np.hypot(away[:, 0], away[:, 1])))
    if off > _LOCATED:
        problem = f"its first poses in the map are {off:.2f} m (median) from where they were located"
        raise InputError(name, problem, remedy="begin it where another recording was, or map it alone")


def _at_poses(sweeps: Sequence[Sweep], found: FeatureMap) -> list[Sweep]:
    """Return sweeps with their poses in a map; without those that it does not have."""
    poses = dict(zip(found.sweeps.tolist(), found.poses, strict=True))
    return [
        replace(sweep, map_from_base=compose(poses[sweep.index], compose(invert(sweep.station), sweep.map_from_base)))
        for sweep in sweeps
        if sweep.index in poses
    ]


def _moved(sweeps: Sequence[Sweep], *, away: FloatArray, after: Sequence[Sweep]) -> tuple[Sweep, ...]:
    """Return sweeps with poses in the frame of the map, and with numbers and times after those of other sweeps."""
    first, late = sweeps[0].index, 0
    if after:
        first, late = after[-1].index + 1, int(after[-1].stamps_ns[-1]) + _PAUSE_NS - int(sweeps[0].stamps_ns[0])
    return tuple(
        replace(
            sweep,
            index=first + number,
            stamps_ns=sweep.stamps_ns + max(0, late),
            map_from_base=compose(away, sweep.map_from_base),
        )
        for number, sweep in enumerate(sweeps)
    )


def _first_poses(name: str, sweeps: Sequence[Sweep], *, known: FeatureMap, rig: Rig) -> FloatArray:
    """Return the poses of the first sweeps in the map of the recordings before it, shape (k, 3) [m, m, rad].

    The recorded pose is tried first: recordings in one frame can be joined in a symmetric place, too. Sweeps before the
    first station that fits are located from there.
    """
    numbers, recorded = stations_of(sweeps).numbers, sweeps[0].station
    doubts: list[str] = []
    # A short recording is tried once with all of its stations.
    for stations in dict.fromkeys(min(each, int(numbers[-1]) + 1) for each in _STATIONS):
        first = sweeps[: int(np.searchsorted(numbers, stations))]
        for start in (recorded, None):
            try:
                found = _located(first, known=known, rig=rig, start=start)
            except InvalidValueError as error:
                doubts.append(str(error))
            else:
                return _led_back(found, first, known=known, rig=rig)
    # The reason that counts is that of most stations, searched in the whole map.
    remedy = "begin it where another recording was and no other place looks alike, or map it alone"
    raise InputError(name, doubts[1], remedy=remedy)


def _led_back(found: Localisation, sweeps: Sequence[Sweep], *, known: FeatureMap, rig: Rig) -> FloatArray:
    """Return the poses of sweeps, of which the first ones may not fit without a guess.

    The guess is their poses if they are located in the opposite order, from the first one that fits.
    """
    fitting = int(np.searchsorted(found.sweeps, found.segments[-1].first))
    if fitting == 0:
        return found.poses
    back = localise(sweeps[fitting::-1], known, rig=rig, start=found.poses[fitting], carried_until=_NEVER)
    poses = np.concatenate([back.poses[:0:-1], found.poses[fitting:]])
    with suppress(InvalidValueError):
        again = _located(sweeps, known=known, rig=rig, start=poses[0])
        return poses if again.kidnapped else again.poses
    return poses


def _located(sweeps: Sequence[Sweep], *, known: FeatureMap, rig: Rig, start: FloatArray | None) -> Localisation:
    """Return the poses of some sweeps in a map; raise ``InvalidValueError`` if there is a doubt about them."""
    found = localise(sweeps, known, rig=rig, start=start, carried_until=_LOST)
    if poor := disagreement(found):
        raise InvalidValueError(f"its beginning is not in the map so far: {poor}")
    if (segment := found.segments[-1]).is_ambiguous:
        raise InvalidValueError(f"it begins in one of several places that look alike: {listed_starts(segment)}")
    return found
