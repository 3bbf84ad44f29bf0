"""Angles, poses, lines and visibility: pure mathematics in the plane."""

from echoplan.geometry.angles import circular_mean, directions, rotation_step, wrap
from echoplan.geometry.lines import along, feet, intersections, lines_through, path_crossings, signed_distances
from echoplan.geometry.poses import aligned, compose, identity, invert, transform_points
from echoplan.geometry.visibility import (
    crosses_discs,
    crosses_segments,
    distances_to_segments,
    is_blocked,
    outward_normals,
)

__all__ = [
    "aligned",
    "along",
    "circular_mean",
    "compose",
    "crosses_discs",
    "crosses_segments",
    "directions",
    "distances_to_segments",
    "feet",
    "identity",
    "intersections",
    "invert",
    "is_blocked",
    "lines_through",
    "outward_normals",
    "path_crossings",
    "rotation_step",
    "signed_distances",
    "transform_points",
    "wrap",
]
