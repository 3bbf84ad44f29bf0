"""Arcs on which reflectors lie, and what many of them determine together."""

from echoplan.classical.loci.crossings import Crossings, find_crossings
from echoplan.classical.loci.density import ArcMap, arc_map, directional_maxima
from echoplan.classical.loci.loci import Loci
from echoplan.classical.loci.medians import Medians, MedianSettings, transversal_medians
from echoplan.classical.loci.reflectors import (
    Reflector,
    ReflectorKind,
    echo_points,
    find_reflectors,
    observations_of_reflector,
)
from echoplan.classical.loci.triangulation import Triangulated, TriangulationSettings, triangulate
from echoplan.classical.loci.votes import VoteSettings, line_ballot, point_ballot

__all__ = [
    "ArcMap",
    "Crossings",
    "Loci",
    "MedianSettings",
    "Medians",
    "Reflector",
    "ReflectorKind",
    "Triangulated",
    "TriangulationSettings",
    "VoteSettings",
    "arc_map",
    "directional_maxima",
    "echo_points",
    "find_crossings",
    "find_reflectors",
    "line_ballot",
    "observations_of_reflector",
    "point_ballot",
    "transversal_medians",
    "triangulate",
]
