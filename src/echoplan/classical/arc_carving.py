"""Arc carving (Silver et al. 2004; as recalled): newer echoes cut what they show to be free out of older arcs."""

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray
from echoplan.classical.loci import Loci
from echoplan.classical.loci.carving import CarvingSettings, carve, longest_runs, sample_turns
from echoplan.classical.points import PointFeatureSettings, SegmentSettings, features_of_points, map_of_features
from echoplan.model import FeatureMap, Rig, Sweep
from echoplan.settings import Settings

__all__ = ["ArcCarvingMapper", "ArcCarvingSettings"]


# The middle of a piece of 30 degrees of an arc of radius r may lie r (1 - cos(15 degrees)) in front of a wall [m].
_IN_FRONT = 0.05


class ArcCarvingSettings(Settings):
    """Settings of all stages of arc carving."""

    carving: CarvingSettings = Field(default_factory=CarvingSettings)
    features: PointFeatureSettings = Field(
        default_factory=lambda: PointFeatureSettings(segments=SegmentSettings(common_sigma=_IN_FRONT))
    )


class ArcCarvingMapper:
    """Maps by the middles of what carving leaves of arcs.

    Parameters
    ----------
    rig : Rig
        What made the sweeps.
    settings : ArcCarvingSettings, optional
        Settings of the stages.
    """

    def __init__(self, rig: Rig, settings: ArcCarvingSettings | None = None) -> None:
        self.rig = rig
        self.settings = settings or ArcCarvingSettings()
        self._sweeps: list[Sweep] = []
        self._loci = Loci.joined([])
        self._left = np.ones((0, self.settings.carving.samples), dtype=bool)

    def add(self, sweep: Sweep) -> None:
        """Add the arcs of one more sweep, and let it carve all arcs so far.

        Parameters
        ----------
        sweep : Sweep
            The pings of one pass of the array.
        """
        newest, settings = Loci.of(sweep, self.rig), self.settings.carving
        self._loci = Loci.joined([self._loci, newest])
        left = np.concatenate([self._left, np.ones((len(newest), settings.samples), dtype=bool)])
        points = self._loci.points_xy(sample_turns(self._loci, settings.samples))
        self._left = carve(points, left, newest, margin=settings.margin, core=settings.core)
        self._sweeps.append(sweep)

    def result(self) -> FeatureMap:
        """Find features among what is left of the arcs.

        Returns
        -------
        FeatureMap
            Walls, corners and cylinders.
        """
        own, points = self._placed()
        features = features_of_points(
            points, np.ones(len(own)), self.settings.features, origins_xy=own.centers_xy, sweeps=own.sweeps
        )
        return map_of_features(
            features, self._sweeps, method="arc-carving", parameters=self.settings.model_dump(mode="json")
        )

    @property
    def points_xy(self) -> FloatArray:
        """Middles of what is left of the arcs, where that is narrow enough [m], shape (n, 2)."""
        return self._placed()[1]

    def _placed(self) -> tuple[Loci, FloatArray]:
        """Arcs of which a narrow piece is left, and the middle of it."""
        pieces = longest_runs(self._left, sample_turns(self._loci, self.settings.carving.samples))
        narrow = pieces.widths <= self.settings.carving.max_width
        own = self._loci[pieces.arcs[narrow]]
        return own, own.points_xy(pieces.turns[narrow])
