"""Arc features fused with Hough lines of triangulated points (Ismail and Balachandran 2015; as recalled)."""

from pydantic import Field

from echoplan.arrays import FloatArray
from echoplan.classical.features.fusion import FusionSettings, fuse_walls
from echoplan.classical.points import PointFeatures, join_segments, map_of_features
from echoplan.classical.rcd import RcdMapper, RcdMapperSettings
from echoplan.classical.tbf import TbfMapper, TbfSettings
from echoplan.model import FeatureMap, Rig, Sweep
from echoplan.settings import Settings

__all__ = ["ArcHoughTbfMapper", "ArcHoughTbfSettings"]


class ArcHoughTbfSettings(Settings):
    """Settings of both parts and of their fusion."""

    arcs: RcdMapperSettings = Field(default_factory=RcdMapperSettings)
    points: TbfSettings = Field(default_factory=TbfSettings)
    fusion: FusionSettings = Field(default_factory=FusionSettings)


class ArcHoughTbfMapper:
    """Maps by arcs and by triangulated points, and fuses both.

    Parameters
    ----------
    rig : Rig
        What made the sweeps.
    settings : ArcHoughTbfSettings, optional
        Settings of both parts.
    """

    def __init__(self, rig: Rig, settings: ArcHoughTbfSettings | None = None) -> None:
        self.rig = rig
        self.settings = settings or ArcHoughTbfSettings()
        self._sweeps: list[Sweep] = []
        self._arcs = RcdMapper(rig, self.settings.arcs)
        self._points = TbfMapper(rig, self.settings.points)

    def add(self, sweep: Sweep) -> None:
        """Give one more sweep to both parts.

        Parameters
        ----------
        sweep : Sweep
            The pings of one pass of the array.
        """
        self._arcs.add(sweep)
        self._points.add(sweep)
        self._sweeps.append(sweep)

    def result(self) -> FeatureMap:
        """Fuse the walls of both; cylinders are the arcs'.

        Returns
        -------
        FeatureMap
            Walls, corners and cylinders.
        """
        arcs, points = self._arcs.result(), self._points.result()
        segments = fuse_walls(arcs.walls, points.walls, self.settings.fusion)
        joined = join_segments(segments, max_extension=self.settings.points.features.max_extension)
        return map_of_features(
            PointFeatures(walls=joined.walls, corners=joined.corners, cylinders=arcs.cylinders),
            self._sweeps,
            method="arc-hough-tbf",
            parameters=self.settings.model_dump(mode="json"),
        )

    @property
    def points_xy(self) -> FloatArray:
        """The triangulated points [m], shape (n, 2)."""
        return self._points.points_xy
