"""A topological map: places and the passages between them, from the free space that echoes show.

After the idea of Werner and others, here as recalled from summaries: a robot that is to find its way needs no exact
walls, but rooms and doors.  What pings show to be free is a grid; where it is wide enough there is a place, and where
two places meet, a passage.  Walls, corners and cylinders are those of the paper's method.
"""

from dataclasses import replace

from pydantic import Field

from echoplan.classical.features import Observation
from echoplan.classical.mdp_fuzzy import MdpFuzzyMapper, MdpFuzzySettings
from echoplan.classical.topology import (
    FreeSpace,
    FreeSpaceSettings,
    PlaceSettings,
    TopologicalGraph,
    find_free_space,
    find_places,
)
from echoplan.model import FeatureMap, Pings, Rig, Sweep
from echoplan.preprocessing import valid_pings
from echoplan.settings import Settings

__all__ = ["TopologicalMapper", "TopologicalSettings"]


class TopologicalSettings(Settings):
    """Settings of all stages."""

    features: MdpFuzzySettings = Field(default_factory=MdpFuzzySettings)
    free_space: FreeSpaceSettings = Field(default_factory=FreeSpaceSettings)
    places: PlaceSettings = Field(default_factory=PlaceSettings)


class TopologicalMapper:
    """Maps places and passages.

    Parameters
    ----------
    rig : Rig
        What made the sweeps.
    settings : TopologicalSettings, optional
        Settings of the stages.
    """

    def __init__(self, rig: Rig, settings: TopologicalSettings | None = None) -> None:
        self.rig = rig
        self.settings = settings or TopologicalSettings()
        self.features = MdpFuzzyMapper(rig, self.settings.features)
        self._pings_by_sweep: list[Pings] = []

    def add(self, sweep: Sweep) -> None:
        """Take one more sweep.

        Parameters
        ----------
        sweep : Sweep
            The pings of one pass of the array.
        """
        self._pings_by_sweep.append(valid_pings(Pings.from_sweep(sweep, self.rig), self.rig))
        self.features.add(sweep)

    @property
    def observations(self) -> list[Observation]:
        """What was located and classified so far, sweep by sweep."""
        return self.features.observations

    def free_space(self) -> FreeSpace:
        """Return the space observed as free so far.

        Returns
        -------
        FreeSpace
            Cells before the echoes and under the robot.
        """
        return find_free_space(self._pings_by_sweep, self.settings.free_space)

    def graph(self) -> TopologicalGraph:
        """Return places and passages found so far.

        Returns
        -------
        TopologicalGraph
            Rooms, and the doors between them.
        """
        return find_places(self.free_space(), self.settings.places)

    def result(self) -> FeatureMap:
        """Make the map of walls, corners and cylinders that goes with the graph.

        Returns
        -------
        FeatureMap
            By the method of the paper.
        """
        parameters = self.settings.model_dump(mode="json")
        return replace(self.features.result(), method="topological", parameters=parameters)
