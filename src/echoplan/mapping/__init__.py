"""From observations of single sweeps to features of a map."""

from echoplan.mapping.assembly import AssemblySettings, Grouped, assemble
from echoplan.mapping.association import AssociationSettings, Group, absorb, group_lines, group_points
from echoplan.mapping.corners import Voices, corner_of, crossing_covariance, heard_at
from echoplan.mapping.cylinders import CylinderSettings, cylinder_of
from echoplan.mapping.fits import Fit, fit_circle, fit_line
from echoplan.mapping.junctions import Junction, Span, junctions, settle
from echoplan.mapping.observations import Observation, Stack, shares, stations_of
from echoplan.mapping.points import PointFeatures, PointFeatureSettings, features_of_points
from echoplan.mapping.targets import Target, TargetKind, find_targets
from echoplan.mapping.walls import WallSettings, heard_span, walls_of

__all__ = [
    "AssemblySettings",
    "AssociationSettings",
    "CylinderSettings",
    "Fit",
    "Group",
    "Grouped",
    "Junction",
    "Observation",
    "PointFeatureSettings",
    "PointFeatures",
    "Span",
    "Stack",
    "Target",
    "TargetKind",
    "Voices",
    "WallSettings",
    "absorb",
    "assemble",
    "corner_of",
    "crossing_covariance",
    "cylinder_of",
    "features_of_points",
    "find_targets",
    "fit_circle",
    "fit_line",
    "group_lines",
    "group_points",
    "heard_at",
    "heard_span",
    "junctions",
    "settle",
    "shares",
    "stations_of",
    "walls_of",
]
