"""What every rule of a grid can do."""

from typing import Protocol

from echoplan.classical.grids.cones import Cones
from echoplan.model import OccupancyGrid

__all__ = ["GridRule"]


class GridRule(Protocol):
    """Anything that makes a grid of cones."""

    def add(self, cones: Cones) -> None:
        """Take the cones of one more sweep.

        Parameters
        ----------
        cones : Cones
            The pings.
        """
        ...

    @property
    def grid(self) -> OccupancyGrid:
        """The map of all cones so far."""
        ...
