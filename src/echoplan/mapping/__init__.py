"""From one source to its map and to the files that others read: what ``echoplan map`` does, as functions."""

from echoplan.mapping.exports import EXPORTS, Exportable, ExportFormat, export_formats, export_map
from echoplan.mapping.folder import PICTURES, RESULTS, results_folder
from echoplan.mapping.locate import LOCATED, LocateResult, locate_source, located_formats
from echoplan.mapping.progress import SILENT, Progress
from echoplan.mapping.recordings import check_options
from echoplan.mapping.result import MapResult
from echoplan.mapping.run import map_source
from echoplan.mapping.start import PRIOR

__all__ = [
    "EXPORTS",
    "LOCATED",
    "PICTURES",
    "PRIOR",
    "RESULTS",
    "SILENT",
    "ExportFormat",
    "Exportable",
    "LocateResult",
    "MapResult",
    "Progress",
    "check_options",
    "export_formats",
    "export_map",
    "locate_source",
    "located_formats",
    "map_source",
    "results_folder",
]
