"""Maximum-likelihood grid with conflict evaluation (Lee and Chung 2009): long reflections are discarded."""

from pydantic import Field

from echoplan.classical.grid_mapper import GridMapper, GridSettings
from echoplan.classical.grids import CemalRule, CemalSettings
from echoplan.model import Rig

__all__ = ["GridCemalSettings", "grid_cemal_mapper"]


class GridCemalSettings(GridSettings):
    """Settings of all stages."""

    rule: CemalSettings = Field(default_factory=CemalSettings)


def grid_cemal_mapper(rig: Rig, settings: GridCemalSettings | None = None) -> GridMapper:
    """Make a mapper.

    Parameters
    ----------
    rig : Rig
        What made the sweeps.
    settings : GridCemalSettings, optional
        Settings of all stages.

    Returns
    -------
    GridMapper
        Ready for the first sweep.
    """
    settings = settings or GridCemalSettings()
    return GridMapper(rig, settings, method="grid-cemal", rule=CemalRule(settings.rule, settings.canvas))
