"""From pings to located objects: clusters, the MDP compensation, the polynomial minimum, constant depth."""

from echoplan.extraction.clusters import Cluster, ClusteringSettings, differential_clusters, hub_distances
from echoplan.extraction.compensation import arm_excess, cylinder_excess, flat_excess
from echoplan.extraction.minimum import (
    LocatedPoint,
    MdpSettings,
    Parabola,
    compensated_clusters,
    compensated_distances,
    fit_parabola,
    middle_point,
    minimum_distance_point,
)
from echoplan.extraction.rcd import Rcd, RcdSettings, region_of_constant_depth
from echoplan.extraction.runs import connected_runs

__all__ = [
    "Cluster",
    "ClusteringSettings",
    "LocatedPoint",
    "MdpSettings",
    "Parabola",
    "Rcd",
    "RcdSettings",
    "arm_excess",
    "compensated_clusters",
    "compensated_distances",
    "connected_runs",
    "cylinder_excess",
    "differential_clusters",
    "fit_parabola",
    "flat_excess",
    "hub_distances",
    "middle_point",
    "minimum_distance_point",
    "region_of_constant_depth",
]
