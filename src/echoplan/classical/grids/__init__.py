"""Occupancy grids of the cones of pings, by five rules; walls, corners and cylinders among their cells.

What is compiled is imported here too: import this package where it is used.
"""

from echoplan.classical.grids.bayes import BayesRule, BayesSettings
from echoplan.classical.grids.canvas import Canvas, CanvasSettings
from echoplan.classical.grids.cemal import CemalRule, CemalSettings
from echoplan.classical.grids.cones import Cones, chosen_cones, cones_of, join_cones
from echoplan.classical.grids.elfes import ElfesRule, ElfesSettings
from echoplan.classical.grids.features import GridFeatureSettings, features_of_grid, free_sides, occupied_cells
from echoplan.classical.grids.muriel import MurielRule, MurielSettings
from echoplan.classical.grids.range_layer import RangeLayerRule, RangeLayerSettings
from echoplan.classical.grids.rules import GridRule
from echoplan.classical.grids.sectors import Raster, Trace, box_about, trace_for

__all__ = [
    "BayesRule",
    "BayesSettings",
    "Canvas",
    "CanvasSettings",
    "CemalRule",
    "CemalSettings",
    "Cones",
    "ElfesRule",
    "ElfesSettings",
    "GridFeatureSettings",
    "GridRule",
    "MurielRule",
    "MurielSettings",
    "RangeLayerRule",
    "RangeLayerSettings",
    "Raster",
    "Trace",
    "box_about",
    "chosen_cones",
    "cones_of",
    "features_of_grid",
    "free_sides",
    "join_cones",
    "occupied_cells",
    "trace_for",
]
