"""Certainty grid of Moravec and Elfes (1985): empty and occupied apart, cancelled and normalised."""

from pydantic import Field

from echoplan.classical.grid_mapper import GridMapper, GridSettings
from echoplan.classical.grids import ElfesRule, ElfesSettings
from echoplan.model import Rig

__all__ = ["GridElfesSettings", "grid_elfes_mapper"]


class GridElfesSettings(GridSettings):
    """Settings of all stages."""

    rule: ElfesSettings = Field(default_factory=ElfesSettings)


def grid_elfes_mapper(rig: Rig, settings: GridElfesSettings | None = None) -> GridMapper:
    """Make a mapper.

    Parameters
    ----------
    rig : Rig
        What made the sweeps.
    settings : GridElfesSettings, optional
        Settings of all stages.

    Returns
    -------
    GridMapper
        Ready for the first sweep.
    """
    settings = settings or GridElfesSettings()
    return GridMapper(rig, settings, method="grid-elfes", rule=ElfesRule(settings.rule, settings.canvas))
