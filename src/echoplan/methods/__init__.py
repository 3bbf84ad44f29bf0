"""The methods: each puts the stages together in its own way, and all answer to the same two calls."""

from echoplan.methods.local import LocalMapper, check_order
from echoplan.methods.mapper import Mapper, grid_of, map_sweeps, observations_of, points_of
from echoplan.methods.registry import METHODS, Method, find_method

__all__ = [
    "METHODS",
    "LocalMapper",
    "Mapper",
    "Method",
    "check_order",
    "find_method",
    "grid_of",
    "map_sweeps",
    "observations_of",
    "points_of",
]
