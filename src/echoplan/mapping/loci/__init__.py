"""Arcs on which reflectors lie, and what many of them tell together."""

from echoplan.mapping.loci.crossings import Crossings, find_crossings
from echoplan.mapping.loci.loci import Loci
from echoplan.mapping.loci.medians import Medians, MedianSettings, transversal_medians
from echoplan.mapping.loci.triangulation import Triangulated, TriangulationSettings, triangulate

__all__ = [
    "Crossings",
    "Loci",
    "MedianSettings",
    "Medians",
    "Triangulated",
    "TriangulationSettings",
    "find_crossings",
    "transversal_medians",
    "triangulate",
]
