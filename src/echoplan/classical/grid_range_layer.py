"""What Nav2's range_sensor_layer would map, with its defects."""

from pydantic import Field

from echoplan.classical.grid_mapper import GridMapper, GridSettings
from echoplan.classical.grids import RangeLayerRule, RangeLayerSettings
from echoplan.model import Rig

__all__ = ["GridRangeLayerSettings", "grid_range_layer_mapper"]


class GridRangeLayerSettings(GridSettings):
    """Settings of all stages."""

    rule: RangeLayerSettings = Field(default_factory=RangeLayerSettings)


def grid_range_layer_mapper(rig: Rig, settings: GridRangeLayerSettings | None = None) -> GridMapper:
    """Make a mapper.

    Parameters
    ----------
    rig : Rig
        What made the sweeps.
    settings : GridRangeLayerSettings, optional
        Settings of all stages.

    Returns
    -------
    GridMapper
        Ready for the first sweep.
    """
    settings = settings or GridRangeLayerSettings()
    return GridMapper(rig, settings, method="grid-range-layer", rule=RangeLayerRule(settings.rule, settings.canvas))
