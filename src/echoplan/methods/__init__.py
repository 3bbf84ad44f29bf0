"""The methods: each puts the stages together in its own way, and all answer to the same two calls."""

from echoplan.methods.registry import (
    METHODS,
    Mapper,
    Method,
    find_method,
    grid_of,
    map_sweeps,
    observations_of,
    points_of,
)

__all__ = ["METHODS", "Mapper", "Method", "find_method", "grid_of", "map_sweeps", "observations_of", "points_of"]
