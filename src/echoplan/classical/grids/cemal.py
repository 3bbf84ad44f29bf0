"""Maximum-likelihood grid with conflict evaluation (Lee and Chung 2009; US patent 8,018,792; details as recalled).

An echo says that something is on its arc, and that nothing is before it.  Two readings are in conflict if one calls
the whole arc of the other free.  One of them is wrong: the one that comes with less sound pressure, which is the
longer one, a reflection thrown on by a wall.  It is discarded.  The readings that are left can all be right at once;
each is explained by those cells of its arc, not called free with more pressure, that fit most readings best.
The probabilities of the cells, by counting, are this module's own.
"""

from typing import ClassVar

import numpy as np
from pydantic import Field

from echoplan.arrays import BoolArray, IntArray
from echoplan.classical.grids.canvas import Canvas, CanvasSettings
from echoplan.classical.grids.cones import Cones, chosen_cones, join_cones
from echoplan.classical.grids.conflicts import Claims, claims_of, explanations, settle_conflicts
from echoplan.classical.grids.sectors import box_about, trace_for
from echoplan.model import OccupancyGrid
from echoplan.settings import Settings

__all__ = ["CemalRule", "CemalSettings"]


class CemalSettings(Settings):
    """How thick arcs are, and how many of their cells count."""

    former_keys: ClassVar = {"share": "min_relative_fit"}

    thickness: float = Field(default=0.1, gt=0.0, description="Thickness of arcs [m]: two cells of 5 cm.")
    min_relative_fit: float = Field(
        default=0.5,
        gt=0.0,
        le=1.0,
        description="Smallest fit of a cell that explains a reading, as a share of the best fit.",
    )


class CemalRule:
    """Discards readings that cannot be right and explains the others.

    Parameters
    ----------
    settings : CemalSettings
        How thick arcs are, and how many of their cells count.
    canvas : CanvasSettings
        How the map is cut into cells.
    """

    def __init__(self, settings: CemalSettings, canvas: CanvasSettings) -> None:
        self.settings = settings
        self._lattice = canvas
        self._parts: list[Cones] = []

    def add(self, cones: Cones) -> None:
        """Keep the cones of more pings.

        Parameters
        ----------
        cones : Cones
            The pings.
        """
        self._parts.append(cones)

    @property
    def kept(self) -> BoolArray:
        """Which of the pings so far are kept, in the order in which they were added, shape (n,)."""
        claims, order, _ = self._settled()
        kept = np.zeros(len(order), dtype=bool)
        kept[order] = claims.kept
        return kept

    @property
    def grid(self) -> OccupancyGrid:
        """The map of all cones so far.

        A cell that explains k readings is occupied with probability (k + 1) / (k + 2), one that k pings call free with
        1 / (k + 2): Laplace's rule of succession.

        Raises
        ------
        InvalidValueError
            If the map would be too large.
        """
        claims, _, canvas = self._settled()
        echoes = explanations(claims, share=self.settings.min_relative_fit)
        values = np.where(echoes > 0, (echoes + 1.0) / (echoes + 2.0), 1.0 / (claims.passes + 2.0))
        return canvas.grid(values.reshape(canvas.layers.shape[1:]))

    def _settled(self) -> tuple[Claims, IntArray, Canvas]:
        """Claims of all pings in the order of their readings, that order, and the cells."""
        every = join_cones(self._parts)
        order = np.argsort(every.readings, kind="stable")
        cones, thickness = chosen_cones(every, order), self.settings.thickness
        radii = np.minimum(cones.readings, cones.reaches) + thickness / 2
        canvas = Canvas(self._lattice)
        canvas.cover(box_about(cones, radii))
        trace = trace_for(cones, radii, self._lattice.resolution)
        claims = claims_of(cones, canvas.raster, trace, thickness=thickness)
        settle_conflicts(claims, canvas.raster, cones, trace, thickness)
        return claims, order, canvas
