"""Maps of points: features and the stations that detected them, as one value."""

from collections.abc import Mapping, Sequence

import numpy as np

from echoplan.classical.points.features import PointFeatures
from echoplan.model import FeatureMap, Sweep

__all__ = ["map_of_features"]


def map_of_features(
    features: PointFeatures, sweeps: Sequence[Sweep], *, method: str, parameters: Mapping[str, object]
) -> FeatureMap:
    """Make a map of features.

    Parameters
    ----------
    features : PointFeatures
        Walls, corners and cylinders.
    sweeps : sequence of Sweep
        What the map was made of; their poses are taken as given, and sweeps without a ping have none.
    method : str
        Name of the method.
    parameters : mapping
        Its settings, ready for JSON.

    Returns
    -------
    FeatureMap
        The map.
    """
    nonempty = [sweep for sweep in sweeps if len(sweep)]
    return FeatureMap(
        method=method,
        parameters=parameters,
        walls=features.walls,
        corners=features.corners,
        cylinders=features.cylinders,
        sweeps=np.array([sweep.index for sweep in nonempty], dtype=np.int64),
        poses=np.array([sweep.station for sweep in nonempty]).reshape(-1, 3),
    )
