"""From observations of single sweeps to features of a map."""

from echoplan.classical.features.assembly import AssemblySettings, Grouped, assemble
from echoplan.classical.features.association import AssociationSettings, Group, absorb, group_lines, group_points
from echoplan.classical.features.corners import CornerObservations, associate_corners, corner_of, crossing_covariance
from echoplan.classical.features.cylinders import CylinderSettings, cylinder_of
from echoplan.classical.features.fits import Fit, fit_circle, fit_line
from echoplan.classical.features.junctions import Junction, Span, junctions, settle
from echoplan.classical.features.observations import Observation, Stack, shares, stations_of
from echoplan.classical.features.targets import Target, TargetKind, find_targets
from echoplan.classical.features.walls import WallSettings, detected_span, walls_of

__all__ = [
    "AssemblySettings",
    "AssociationSettings",
    "CornerObservations",
    "CylinderSettings",
    "Fit",
    "Group",
    "Grouped",
    "Junction",
    "Observation",
    "Span",
    "Stack",
    "Target",
    "TargetKind",
    "WallSettings",
    "absorb",
    "assemble",
    "associate_corners",
    "corner_of",
    "crossing_covariance",
    "cylinder_of",
    "detected_span",
    "find_targets",
    "fit_circle",
    "fit_line",
    "group_lines",
    "group_points",
    "junctions",
    "settle",
    "shares",
    "stations_of",
    "walls_of",
]
