"""Directional maximum (Barshan 2007; as recalled): arcs thinned to their densest cells along many directions."""

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray
from echoplan.classical.loci import ArcMap, Loci, arc_map, directional_maxima
from echoplan.classical.points import PointFeatureSettings, features_of_points, map_of_features
from echoplan.model import FeatureMap, Rig, Sweep
from echoplan.settings import Settings

__all__ = ["DirectionalMaximumMapper", "DirectionalMaximumSettings"]


class DirectionalMaximumSettings(Settings):
    """Settings of all stages of the directional maximum."""

    resolution: float = Field(default=0.02, gt=0.0, description="Side of a cell of the arc map [m].")
    directions: int = Field(
        default=18, ge=1, description="Number of directions in half a turn: 18 are every 10 degrees."
    )
    min_arcs: int = Field(
        default=3, ge=1, description="Smallest number of arcs through a cell that is a maximum: any two arcs may cross."
    )
    features: PointFeatureSettings = Field(default_factory=PointFeatureSettings)


class DirectionalMaximumMapper:
    """Maps by the densest cells of the arc map.

    Parameters
    ----------
    rig : Rig
        What made the sweeps.
    settings : DirectionalMaximumSettings, optional
        Settings of the stages.
    """

    def __init__(self, rig: Rig, settings: DirectionalMaximumSettings | None = None) -> None:
        self.rig = rig
        self.settings = settings or DirectionalMaximumSettings()
        self._sweeps: list[Sweep] = []
        self._loci: list[Loci] = []

    def add(self, sweep: Sweep) -> None:
        """Draw the arcs of one more sweep.

        Parameters
        ----------
        sweep : Sweep
            The pings of one pass of the array.
        """
        self._loci.append(Loci.of(sweep, self.rig))
        self._sweeps.append(sweep)

    def result(self) -> FeatureMap:
        """Thin the arc map and find features among what is left.

        Returns
        -------
        FeatureMap
            Walls, corners and cylinders.
        """
        points = self.points_xy
        features = features_of_points(points, np.ones(len(points)), self.settings.features)
        return map_of_features(
            features, self._sweeps, method="directional-maximum", parameters=self.settings.model_dump(mode="json")
        )

    @property
    def arcs(self) -> ArcMap:
        """The arc map before it is thinned."""
        return arc_map(Loci.joined(self._loci), resolution=self.settings.resolution)

    @property
    def points_xy(self) -> FloatArray:
        """Centres of the cells that are kept [m], shape (n, 2)."""
        cells, settings = self.arcs, self.settings
        leads = directional_maxima(cells, count=settings.directions, resolution=settings.resolution)
        kept: FloatArray = cells.points_xy[(leads > 0) & (cells.counts >= settings.min_arcs)]
        return kept
