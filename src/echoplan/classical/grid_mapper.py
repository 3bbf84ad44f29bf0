"""What the methods of occupancy grids have in common: cones of sweeps into a grid, features out of it."""

from pydantic import Field

from echoplan.classical.grids import CanvasSettings, GridFeatureSettings, GridRule, cones_of, features_of_grid
from echoplan.classical.points import map_of_features
from echoplan.model import FeatureMap, OccupancyGrid, Rig, Sweep
from echoplan.settings import Settings

__all__ = ["GridMapper", "GridSettings"]


class GridSettings(Settings):
    """Settings of the stages that all grids share."""

    canvas: CanvasSettings = Field(default_factory=CanvasSettings)
    features: GridFeatureSettings = Field(default_factory=GridFeatureSettings)


class GridMapper:
    """Maps by an occupancy grid.

    Parameters
    ----------
    rig : Rig
        What made the sweeps.
    settings : GridSettings
        Settings of the stages.
    method : str
        Name of the method.
    rule : GridRule
        How cones become a grid.

    Examples
    --------
    >>> from echoplan.io import builtin_rig
    >>> from echoplan.methods import find_method
    >>> mapper = find_method("grid-bayes").build(builtin_rig("rotary-array"))
    >>> mapper.grid.values
    array([[0.5]])
    """

    def __init__(self, rig: Rig, settings: GridSettings, *, method: str, rule: GridRule) -> None:
        self.rig = rig
        self.settings = settings
        self.method = method
        self.rule = rule
        self._sweeps: list[Sweep] = []

    def add(self, sweep: Sweep) -> None:
        """Draw the cones of one more sweep.

        Parameters
        ----------
        sweep : Sweep
            The pings of one pass of the array.

        Raises
        ------
        InvalidValueError
            If the grid grows too large.
        """
        self.rule.add(cones_of(sweep, self.rig))
        self._sweeps.append(sweep)

    @property
    def grid(self) -> OccupancyGrid:
        """The grid of all sweeps so far; one unknown cell before the first echo.

        Raises
        ------
        InvalidValueError
            If the grid would be too large.
        """
        return self.rule.grid

    def result(self) -> FeatureMap:
        """Find features among the occupied cells of the grid.

        Returns
        -------
        FeatureMap
            Walls, corners and cylinders.

        Raises
        ------
        InvalidValueError
            If the grid would be too large.
        """
        features = features_of_grid(self.grid, self.settings.features)
        return map_of_features(
            features, self._sweeps, method=self.method, parameters=self.settings.model_dump(mode="json")
        )
