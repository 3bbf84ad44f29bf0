"""Bayesian occupancy grid (Elfes 1989; Thrun, Burgard and Fox 2005): log odds of an inverse sensor model."""

from pydantic import Field

from echoplan.classical.grid_mapper import GridMapper, GridSettings
from echoplan.classical.grids import BayesRule, BayesSettings
from echoplan.model import Rig

__all__ = ["GridBayesSettings", "grid_bayes_mapper"]


class GridBayesSettings(GridSettings):
    """Settings of all stages."""

    rule: BayesSettings = Field(default_factory=BayesSettings)


def grid_bayes_mapper(rig: Rig, settings: GridBayesSettings | None = None) -> GridMapper:
    """Make a mapper.

    Parameters
    ----------
    rig : Rig
        What made the sweeps.
    settings : GridBayesSettings, optional
        Settings of all stages.

    Returns
    -------
    GridMapper
        Ready for the first sweep.
    """
    settings = settings or GridBayesSettings()
    return GridMapper(rig, settings, method="grid-bayes", rule=BayesRule(settings.rule, settings.canvas))
