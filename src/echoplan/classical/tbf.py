"""Triangulation-based fusion (Wijk and Christensen 2000; as recalled): points that several sweeps agree on."""

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray
from echoplan.classical.loci import Loci, Triangulated, TriangulationSettings, triangulate
from echoplan.classical.points import PointFeatureSettings, SegmentSettings, features_of_points, map_of_features
from echoplan.model import FeatureMap, Rig, Sweep
from echoplan.settings import Settings

__all__ = ["TbfMapper", "TbfSettings"]


# Arcs of two stations whose feet on a wall are s apart cross s**2 / 8 r in front of it: 2 cm for 0.5 m and 1.5 m.
_IN_FRONT = 0.02


class TbfSettings(Settings):
    """Settings of all stages of triangulation-based fusion."""

    triangulation: TriangulationSettings = Field(default_factory=TriangulationSettings)
    # Several sweeps agree on each point already; which of them was the newest says nothing.
    features: PointFeatureSettings = Field(
        default_factory=lambda: PointFeatureSettings(segments=SegmentSettings(common_sigma=_IN_FRONT), min_stations=1)
    )


class TbfMapper:
    """Maps by triangulating each sweep with the few before it.

    Parameters
    ----------
    rig : Rig
        What made the sweeps.
    settings : TbfSettings, optional
        Settings of the stages.
    """

    def __init__(self, rig: Rig, settings: TbfSettings | None = None) -> None:
        self.rig = rig
        self.settings = settings or TbfSettings()
        self._sweeps: list[Sweep] = []
        self._recent: list[Loci] = []
        self._found: list[Triangulated] = []

    def add(self, sweep: Sweep) -> None:
        """Triangulate one more sweep with those before it.

        Parameters
        ----------
        sweep : Sweep
            The pings of one pass of the array.
        """
        newest = Loci.of(sweep, self.rig)
        self._found.append(triangulate(newest, Loci.joined(self._recent), self.settings.triangulation))
        self._recent = [*self._recent, newest][-self.settings.triangulation.window :]
        self._sweeps.append(sweep)

    def result(self) -> FeatureMap:
        """Find features among the points triangulated so far.

        Returns
        -------
        FeatureMap
            Walls, corners and cylinders.
        """
        found = Triangulated.joined(self._found)
        features = features_of_points(
            found.points_xy,
            np.ones(len(found.counts)),
            self.settings.features,
            origins_xy=found.origins_xy,
            sweeps=found.sweeps,
        )
        return map_of_features(features, self._sweeps, method="tbf", parameters=self.settings.model_dump(mode="json"))

    @property
    def points_xy(self) -> FloatArray:
        """The triangulated points [m], shape (n, 2)."""
        return Triangulated.joined(self._found).points_xy
