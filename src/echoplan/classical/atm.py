"""Arc-transversal median (Choset, Nagatani and Lazar 2003; as recalled): where arcs cross, there is something."""

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray
from echoplan.classical.loci import Loci, MedianSettings, transversal_medians
from echoplan.classical.points import PointFeatureSettings, SegmentSettings, features_of_points, map_of_features
from echoplan.model import FeatureMap, Rig, Sweep
from echoplan.settings import Settings

__all__ = ["AtmMapper", "AtmSettings"]


# Arcs that touch a wall from a depth r and cross at 30 degrees do so r (1 - cos(15 degrees)) in front of it [m].
_IN_FRONT = 0.05


class AtmSettings(Settings):
    """Settings of all stages of the arc-transversal median."""

    medians: MedianSettings = Field(default_factory=MedianSettings)
    features: PointFeatureSettings = Field(
        default_factory=lambda: PointFeatureSettings(segments=SegmentSettings(common_sigma=_IN_FRONT))
    )


class AtmMapper:
    """Maps by the median of the transversal crossings of each arc.

    Parameters
    ----------
    rig : Rig
        What made the sweeps.
    settings : AtmSettings, optional
        Settings of the stages.
    """

    def __init__(self, rig: Rig, settings: AtmSettings | None = None) -> None:
        self.rig = rig
        self.settings = settings or AtmSettings()
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
        """Find the medians of all arcs and the features among them.

        Returns
        -------
        FeatureMap
            Walls, corners and cylinders.
        """
        own, points = self._placed()
        features = features_of_points(
            points, np.ones(len(own)), self.settings.features, origins_xy=own.centers_xy, sweeps=own.sweeps
        )
        return map_of_features(features, self._sweeps, method="atm", parameters=self.settings.model_dump(mode="json"))

    @property
    def points_xy(self) -> FloatArray:
        """A point for each arc that others cross [m], shape (n, 2)."""
        return self._placed()[1]

    def _placed(self) -> tuple[Loci, FloatArray]:
        """Arcs that have a median, and where it lies."""
        loci = Loci.joined(self._loci)
        medians = transversal_medians(loci, loci, self.settings.medians)
        own = loci[medians.arcs]
        return own, own.points_xy(medians.turns)
