"""From one source to its map and to the files that others read: what ``echoplan map`` does, as functions."""

from echoplan.mapping.exports import EXPORTS, Exportable, ExportFormat, export_formats, export_map
from echoplan.mapping.folder import PICTURES, RESULTS, results_folder
from echoplan.mapping.progress import SILENT, Progress
from echoplan.mapping.result import MapResult
from echoplan.mapping.run import map_source

__all__ = [
    "EXPORTS",
    "PICTURES",
    "RESULTS",
    "SILENT",
    "ExportFormat",
    "Exportable",
    "MapResult",
    "Progress",
    "export_formats",
    "export_map",
    "map_source",
    "results_folder",
]
