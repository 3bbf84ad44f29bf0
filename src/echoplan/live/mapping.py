"""What the process beside the server does: it maps the survey and writes the results."""

import shutil
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path

from echoplan.io import write_recording
from echoplan.live.drawing import drawing_of
from echoplan.live.messages import encoded
from echoplan.live.survey import Survey
from echoplan.live.unsaved import RECORDING
from echoplan.mapping import EXPORTS, MapResult, map_source
from echoplan.mapping.folder import results_folder
from echoplan.model import FeatureMap
from echoplan.preprocessing import Faults, find_faults
from echoplan.viewer import Plan

__all__ = ["draw_map", "sensor_faults", "write_results"]


def draw_map(survey: Survey) -> str:
    """Map a survey and return the message that draws the map."""
    plan = _mapped(survey.thinned()).plan if len(survey) else Plan(feature_map=FeatureMap(method="joint"))
    return encoded("map", drawing_of(plan))


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
