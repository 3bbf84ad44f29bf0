"""The plain plot of points: every echo drawn on the axis of its beam, as if sound were a ray.

No paper's: what everyone draws first, and the yardstick of all others.  A wall is detected from half a beam to either
side of its normal at one and the same range, so that it is drawn as an arc about the sensor.
"""

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray
from echoplan.classical.points import PointFeatureSettings, features_of_points, map_of_features
from echoplan.model import FeatureMap, Pings, Rig, Sweep
from echoplan.preprocessing import echo_points, valid_pings
from echoplan.settings import Settings

__all__ = ["PointPlotMapper", "PointPlotSettings"]


class PointPlotSettings(Settings):
    """What makes features of the points."""

    features: PointFeatureSettings = Field(default_factory=PointFeatureSettings)


class PointPlotMapper:
    """Maps by echo points as they come.

    Parameters
    ----------
    rig : Rig
        What made the sweeps.
    settings : PointPlotSettings, optional
        What makes features of the points.
    """

    def __init__(self, rig: Rig, settings: PointPlotSettings | None = None) -> None:
        self.rig = rig
        self.settings = settings or PointPlotSettings()
        self._sweeps: list[Sweep] = []
        self._pings: list[Pings] = []

    def add(self, sweep: Sweep) -> None:
        """Plot the valid echoes of one more sweep.

        Parameters
        ----------
        sweep : Sweep
            The pings of one pass of the array.
        """
        self._pings.append(valid_pings(Pings.from_sweep(sweep, self.rig), self.rig))
        self._sweeps.append(sweep)

    def result(self) -> FeatureMap:
        """Find features among the points.

        Returns
        -------
        FeatureMap
            Walls, corners and cylinders.
        """
        points = self.points_xy
        origins = np.concatenate([np.zeros((0, 2)), *(pings.origins_xy for pings in self._pings)])
        sweeps = np.repeat([sweep.index for sweep in self._sweeps], [len(pings) for pings in self._pings])
        features = features_of_points(
            points, np.ones(len(points)), self.settings.features, origins_xy=origins, sweeps=sweeps.astype(np.int64)
        )
        return map_of_features(
            features, self._sweeps, method="point-plot", parameters=self.settings.model_dump(mode="json")
        )

    @property
    def points_xy(self) -> FloatArray:
        """Echo points on the beam axes [m], shape (n, 2)."""
        return np.concatenate([np.zeros((0, 2)), *(echo_points(pings) for pings in self._pings)])
