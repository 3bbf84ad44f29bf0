"""What the process beside the server does: it maps the survey, checks the map and writes the results."""

import shutil
from collections import deque
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from echoplan.arrays import FloatArray
from echoplan.diagnosis import assess
from echoplan.grids import grid_from_map
from echoplan.io import write_recording
from echoplan.io.rig import format_rig
from echoplan.joint.mapper import JointMapper
from echoplan.live.drawing import drawing_of
from echoplan.live.messages import encoded, verdict_message
from echoplan.live.survey import PackedSweep, Survey
from echoplan.live.unsaved import RECORDING
from echoplan.mapping import EXPORTS, map_source
from echoplan.mapping.folder import results_folder
from echoplan.methods import LocalMapper, map_sweeps
from echoplan.model import FeatureMap, OccupancyGrid, Sweep
from echoplan.preprocessing import Faults, clean_sweeps, find_faults
from echoplan.viewer import EchoListener, Plan

__all__ = ["MapUpdate", "check_map", "draw_map", "map_update", "sensor_faults", "write_results"]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class MapUpdate:
    """A new map, for programs beside the page.

    Parameters
    ----------
    feature_map : FeatureMap
        The map.
    grid : OccupancyGrid
        Its grid.
    last_ns : int
        Time of the last ping of its last sweep [ns].
    map_from_base : ndarray, shape (3,)
        Pose of the robot in that sweep [m, m, rad].
    """

    feature_map: FeatureMap
    grid: OccupancyGrid
    last_ns: int
    map_from_base: FloatArray


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class _Mapped:
    """The map of a survey, and the mapper that made it, to which new sweeps can be added.

    ``added`` has the sweeps in the mapper: as recorded, and their readings without those of faulty sensors.
    """

    survey: Survey
    rig: str
    mapper: LocalMapper
    listener: EchoListener
    added: tuple[tuple[PackedSweep, bytes], ...]
    recorded: tuple[Sweep, ...]
    cleaned: tuple[Sweep, ...]
    feature_map: FeatureMap

    def begins(self, rig: str, sweeps: tuple[tuple[PackedSweep, bytes], ...]) -> bool:
        """Return True if other sweeps of a rig begin with those in the mapper."""
        return bool(self.added) and self.rig == rig and sweeps[: len(self.added)] == self.added


# The newest map of this process: the functions that an executor calls there share nothing else.
_newest: deque[_Mapped] = deque(maxlen=1)


def draw_map(survey: Survey) -> str:
    """Map a survey and return the message that draws the map, without a verdict."""
    if not len(survey):
        return encoded("map", drawing_of(Plan(feature_map=FeatureMap(method="joint"))))
    mapped = _mapped(survey)
    return encoded("map", drawing_of(Plan(feature_map=mapped.feature_map, echoes_xy=mapped.listener.points_xy)))


def check_map(survey: Survey) -> str:
    """Map a survey and return the message with the verdict on the map."""
    if not len(survey):
        return encoded("verdict", verdict_message(None, sweeps=0))
    mapped = _mapped(survey)
    quality = assess(mapped.feature_map, survey.rig, mapped.recorded, has_rig_file=False)
    return encoded("verdict", verdict_message(quality, sweeps=len(survey)))


def map_update(survey: Survey) -> MapUpdate | None:
    """Map a survey for programs beside the page; None without a pose."""
    mapped = _mapped(survey) if len(survey) else None
    if mapped is None or not len(mapped.feature_map.poses):
        return None
    ends = {each.index: each.last_ns for each in survey.sweeps}
    return MapUpdate(
        feature_map=mapped.feature_map,
        grid=grid_from_map(mapped.feature_map, rig=survey.rig, sweeps=mapped.cleaned),
        last_ns=ends[int(mapped.feature_map.sweeps[-1])],
        map_from_base=mapped.feature_map.poses[-1],
    )


def sensor_faults(survey: Survey) -> Faults:
    """Find faults of sensors; in one sweep a sensor without an echo may be sound."""
    return Faults(sensors=find_faults(tuple(survey), survey.rig).sensors if len(survey) > 1 else ())


def write_results(survey: Survey, *, folder: Path, archive: Path) -> tuple[str, ...]:
    """Write the recording, the map and its exports into a folder and an archive; return the names of the exports."""
    result = map_source(survey.recording)
    exports = [each for each in EXPORTS.values() if not each.package or find_spec(each.package) is not None]
    with results_folder(folder, result, exports=exports) as draft:
        write_recording(draft / RECORDING, survey.recording)
        # Of the draft: the folder itself may have other files.
        shutil.make_archive(str(archive.with_suffix("")), "zip", draft)
    return tuple(name for each in exports for name in each.files)


def _mapped(survey: Survey) -> _Mapped:
    """Map a survey: add its new sweeps to the newest map if that has the others as they are, or begin a new map."""
    survey, rig, written = survey.thinned(), survey.rig, format_rig(survey.rig)
    before = next(iter(_newest), None)
    if before is not None and (before.survey, before.rig) == (survey, written):
        return before
    # After an error, sweeps may be in the mapper that are not in the map.
    _newest.clear()
    recorded = tuple(survey)
    faults = find_faults(recorded, rig)
    cleaned = clean_sweeps(recorded, rig, faults)
    added = tuple((packed, sweep.ranges.tobytes()) for packed, sweep in zip(survey.sweeps, cleaned, strict=True))
    if before is not None and before.begins(written, added):
        mapper, listener, first = before.mapper, before.listener, len(before.added)
    else:
        mapper, listener, first = LocalMapper(JointMapper(rig), rig), EchoListener(rig), 0
    new = tuple(listener.listen(cleaned[first:]))
    if faults.is_from_one_place:
        added, found = (), map_sweeps(LocalMapper(JointMapper(rig), rig), recorded)
    else:
        for sweep in new:
            mapper.add(sweep)
        found = mapper.result()
    _newest.append(
        _Mapped(
            survey=survey,
            rig=written,
            mapper=mapper,
            listener=listener,
            added=added,
            recorded=recorded,
            cleaned=cleaned,
            feature_map=found,
        )
    )
    return _newest[0]
