"""Topology: free space, the places in it and the passages between them."""

from echoplan.classical.topology.free_space import FreeSpace, FreeSpaceSettings, find_free_space
from echoplan.classical.topology.places import Passage, Place, PlaceSettings, TopologicalGraph, find_places

__all__ = [
    "FreeSpace",
    "FreeSpaceSettings",
    "Passage",
    "Place",
    "PlaceSettings",
    "TopologicalGraph",
    "find_free_space",
    "find_places",
]
