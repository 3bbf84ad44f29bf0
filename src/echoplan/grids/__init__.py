"""Occupancy grids of feature maps, for path planners."""

from echoplan.grids.map_grid import MapGridSettings, grid_from_map

__all__ = ["MapGridSettings", "grid_from_map"]
