"""Incremental Gaussian mixture map (Heinen and Engel 2011; as recalled): each component is a patch of a surface."""

from pydantic import Field

from echoplan.arrays import FloatArray
from echoplan.classical.features.mixture import Mixture, MixtureSettings, learn
from echoplan.classical.points import PointFeatureSettings, SegmentSettings, features_of_points, map_of_features
from echoplan.model import FeatureMap, Pings, Rig, Sweep
from echoplan.preprocessing import echo_points, valid_pings
from echoplan.settings import Settings

__all__ = ["GmmMapper", "GmmSettings"]


# A component starts as wide as 10 cm, and the bow of an arc keeps it so: its middle is known to half of that [m].
_BOW = 0.05


class GmmSettings(Settings):
    """Settings of all stages of the mixture map."""

    mixture: MixtureSettings = Field(default_factory=MixtureSettings)
    spacing: float = Field(
        default=0.05, gt=0.0, description="Distance between the points that represent a component [m]."
    )
    features: PointFeatureSettings = Field(
        default_factory=lambda: PointFeatureSettings(segments=SegmentSettings(common_sigma=_BOW))
    )


class GmmMapper:
    """Maps by a Gaussian mixture that learns one echo point after the other.

    Parameters
    ----------
    rig : Rig
        What made the sweeps.
    settings : GmmSettings, optional
        Settings of the stages.
    """

    def __init__(self, rig: Rig, settings: GmmSettings | None = None) -> None:
        self.rig = rig
        self.settings = settings or GmmSettings()
        self.mixture = Mixture.empty()
        self._sweeps: list[Sweep] = []

    def add(self, sweep: Sweep) -> None:
        """Learn the echo points of one more sweep.

        Parameters
        ----------
        sweep : Sweep
            The pings of one pass of the array.
        """
        for point in echo_points(valid_pings(Pings.from_sweep(sweep, self.rig), self.rig)):
            self.mixture = learn(self.mixture, point, self.settings.mixture)
        self._sweeps.append(sweep)

    def result(self) -> FeatureMap:
        """Find features among the components.

        Returns
        -------
        FeatureMap
            Walls, corners and cylinders.
        """
        points, weights = self.mixture.spread(spacing=self.settings.spacing)
        return map_of_features(
            features_of_points(points, weights, self.settings.features),
            self._sweeps,
            method="gmm",
            parameters=self.settings.model_dump(mode="json"),
        )

    @property
    def points_xy(self) -> FloatArray:
        """Middles of the components [m], shape (n, 2)."""
        return self.mixture.means_xy
