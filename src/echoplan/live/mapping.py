"""What the process beside the server does: it maps the survey and writes the results."""

import shutil
from dataclasses import dataclass
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path

from echoplan.arrays import FloatArray
from echoplan.io import write_recording
from echoplan.live.drawing import drawing_of
from echoplan.live.messages import encoded
from echoplan.live.survey import Survey
from echoplan.live.unsaved import RECORDING
from echoplan.mapping import EXPORTS, MapResult, map_source
from echoplan.mapping.folder import results_folder
from echoplan.model import FeatureMap, OccupancyGrid
from echoplan.preprocessing import Faults, find_faults
from echoplan.viewer import Plan

__all__ = ["MapUpdate", "draw_map", "map_update", "sensor_faults", "write_results"]


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


def draw_map(survey: Survey) -> str:
    """Map a survey and return the message that draws the map."""
    plan = _mapped(survey.thinned()).plan if len(survey) else Plan(feature_map=FeatureMap(method="joint"))
    return encoded("map", drawing_of(plan))


def map_update(survey: Survey) -> MapUpdate | None:
    """Map a survey for programs beside the page; None without a pose."""
    result = _mapped(survey.thinned()) if len(survey) else None
    if result is None or not len(result.poses):
        return None
    ends = {each.index: each.last_ns for each in survey.sweeps}
    return MapUpdate(
        feature_map=result.feature_map,
        grid=result.exportable.nav2_grid,
        last_ns=ends[int(result.feature_map.sweeps[-1])],
        map_from_base=result.poses[-1],
    )


def sensor_faults(survey: Survey) -> Faults:
    """Find faults of sensors; in one sweep a sensor without an echo may be sound."""
    return Faults(sensors=find_faults(tuple(survey), survey.rig).sensors if len(survey) > 1 else ())


def write_results(survey: Survey, *, folder: Path, archive: Path) -> tuple[str, ...]:
    """Write the recording, the map and its exports into a folder and an archive; return the names of the exports."""
    result = _mapped(survey)
    exports = [each for each in EXPORTS.values() if not each.package or find_spec(each.package) is not None]
    with results_folder(folder, result, exports=exports) as draft:
        write_recording(draft / RECORDING, survey.recording)
        # Of the draft: the folder itself may have other files.
        shutil.make_archive(str(archive.with_suffix("")), "zip", draft)
    return tuple(name for each in exports for name in each.files)


@lru_cache(maxsize=1)
def _mapped(survey: Survey) -> MapResult:
    """Map a survey; what is saved is mostly what was drawn last."""
    return map_source(survey.recording)
