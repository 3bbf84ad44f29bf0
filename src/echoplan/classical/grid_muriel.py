"""MURIEL (Konolige 1997; as recalled): the evidence of each place counts once."""

from pydantic import Field

from echoplan.classical.grid_mapper import GridMapper, GridSettings
from echoplan.classical.grids import MurielRule, MurielSettings
from echoplan.model import Rig

__all__ = ["GridMurielSettings", "grid_muriel_mapper"]


class GridMurielSettings(GridSettings):
    """Settings of all stages."""

    rule: MurielSettings = Field(default_factory=MurielSettings)


def grid_muriel_mapper(rig: Rig, settings: GridMurielSettings | None = None) -> GridMapper:
    """Make a mapper.

    Parameters
    ----------
    rig : Rig
        What made the sweeps.
    settings : GridMurielSettings, optional
        Settings of all stages.

    Returns
    -------
    GridMapper
        Ready for the first sweep.
    """
    settings = settings or GridMurielSettings()
    return GridMapper(rig, settings, method="grid-muriel", rule=MurielRule(settings.rule, settings.canvas))
