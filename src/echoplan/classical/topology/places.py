"""Places and the passages between them (after the idea of Werner et al.; as recalled).

A place is a hill of the clearance, which is the distance from whatever is not free; a passage is the saddle over which
one gets from hill to hill.  Flooding from the summits down finds both (watershed; Vincent and Soille 1991).
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray, IntArray, checked_floats, store
from echoplan.classical.topology.free_space import FreeSpace
from echoplan.settings import Settings

__all__ = ["Passage", "Place", "PlaceSettings", "TopologicalGraph", "find_places"]


class PlaceSettings(Settings):
    """What makes a place and what a passage."""

    former_keys: ClassVar = {"narrowing": "max_narrowing"}

    max_narrowing: float = Field(
        default=0.6,
        gt=0.0,
        le=1.0,
        description="Largest clearance of a passage over that of the smaller of its places; beyond it the places "
        "are one.",
    )
    min_clearance: float = Field(
        default=0.4, ge=0.0, description="Smallest clearance at the centre of a place, to turn round [m]."
    )


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Place:
    """A room, or what is like one.

    Parameters
    ----------
    center_xy : ndarray, shape (2,)
        Where there is most room about one [m].
    clearance : float
        Distance from there to what is not free [m].
    area : float
        Free space that belongs to it [m2].
    """

    center_xy: FloatArray
    clearance: float
    area: float

    def __post_init__(self) -> None:
        store(self, center_xy=checked_floats(self.center_xy, name="center_xy", shape=(2,)))


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Passage:
    """A way between two places.

    Parameters
    ----------
    first, second : int
        Numbers of the places, in rising order.
    position_xy : ndarray, shape (2,)
        Where it is [m].
    width : float
        How wide it is there [m].
    """

    first: int
    second: int
    position_xy: FloatArray
    width: float

    def __post_init__(self) -> None:
        store(self, position_xy=checked_floats(self.position_xy, name="position_xy", shape=(2,)))


@dataclass(frozen=True, slots=True, kw_only=True)
class TopologicalGraph:
    """Places and what joins them.

    Parameters
    ----------
    places : tuple of Place
        The nodes.
    passages : tuple of Passage
        The edges.
    """

    places: tuple[Place, ...] = ()
    passages: tuple[Passage, ...] = ()

    def neighbours(self, place: int) -> tuple[int, ...]:
        """Return the places next to a place.

        Parameters
        ----------
        place : int
            Number of a place.

        Returns
        -------
        tuple of int
            Numbers of the places that a passage leads to, in rising order.
        """
        ends = [(each.first, each.second) for each in self.passages]
        return tuple(sorted({other for pair in ends if place in pair for other in pair if other != place}))


def find_places(free: FreeSpace, settings: PlaceSettings | None = None) -> TopologicalGraph:
    """Find places and passages in free space.

    Parameters
    ----------
    free : FreeSpace
        What is free.
    settings : PlaceSettings, optional
        How narrow a passage is.

    Returns
    -------
    TopologicalGraph
        Places by falling clearance, and the widest passage between any two that meet.

    Examples
    --------
    >>> data = np.zeros((22, 50), dtype=bool)
    >>> data[1:21, 1:21] = data[1:21, 25:49] = data[9:15, 21:25] = True
    >>> graph = find_places(FreeSpace(origin_xy=np.zeros(2), resolution=0.1, data=data))
    >>> len(graph.places), graph.neighbours(0)
    (2, (1,))
    """
    settings = settings or PlaceSettings()
    clearances = _clearances(free)
    flood = _Flood(clearances, settings)
    # Flood from the summits down.
    cells = np.argwhere(clearances > 0)
    order = np.argsort(-clearances[tuple(cells.T)], kind="stable")
    for iy, ix in cells[order].tolist():
        flood.reach((iy, ix))
    numbers = {hill: number for number, hill in enumerate(flood.hills())}
    hills = np.array([flood.root(hill) for hill in range(len(flood.summits))], dtype=np.int64)
    return TopologicalGraph(
        places=tuple(
            Place(
                center_xy=_middle(flood.summits[hill], free),
                clearance=float(clearances[flood.summits[hill]]),
                area=float((hills[flood.labels] == hill).sum()) * free.resolution**2,
            )
            for hill in numbers
        ),
        passages=tuple(
            Passage(
                first=min(numbers[first], numbers[second]),
                second=max(numbers[first], numbers[second]),
                position_xy=_middle(cell, free),
                width=2 * float(clearances[cell]),
            )
            for (first, second), cell in flood.passes().items()
            if {first, second} <= numbers.keys()
        ),
    )


class _Flood:
    """Hills that grow down from their summits, and the saddles over which they meet.

    Label 0 stands for what has not been reached, and is the root of nothing else.
    """

    def __init__(self, clearances: FloatArray, settings: PlaceSettings) -> None:
        self.clearances = clearances
        self.settings = settings
        self.labels: IntArray = np.zeros(clearances.shape, dtype=np.int64)
        self.summits: list[tuple[int, int]] = [(0, 0)]
        self._parents = [0]
        self._saddles: dict[tuple[int, int], tuple[int, int]] = {}

    def root(self, hill: int) -> int:
        """Follow a hill to the one that it became part of."""
        while self._parents[hill] != hill:
            hill = self._parents[hill]
        return hill

    def hills(self) -> list[int]:
        """List the hills that are high enough, the highest first."""
        roots = [hill for hill in range(1, len(self.summits)) if self._parents[hill] == hill]
        return [hill for hill in roots if self._height(hill) >= self.settings.min_clearance]

    def passes(self) -> dict[tuple[int, int], tuple[int, int]]:
        """Give the highest saddle between any two hills that meet."""
        found: dict[tuple[int, int], tuple[int, int]] = {}
        for (first, second), cell in self._saddles.items():
            low, high = sorted((self.root(first), self.root(second)))
            if low != high:
                found.setdefault((low, high), cell)
        return found

    def reach(self, cell: tuple[int, int]) -> None:
        """Let the next lower cell join the hills that it touches, or be a summit."""
        iy, ix = cell
        # The lowest label is that of the highest summit: cells come from the summits down.
        around = np.unique(self.labels[iy - 1 : iy + 2, ix - 1 : ix + 2]).tolist()
        near = sorted({self.root(label) for label in around if label})
        if not near:
            near = [len(self.summits)]
            self.summits.append(cell)
            self._parents.append(near[0])
        self.labels[cell] = near[0]
        for other in near[1:]:
            self._meet(near[0], other, cell)

    def _meet(self, hill: int, lower: int, cell: tuple[int, int]) -> None:
        height = self._height(lower)
        if height < self.settings.min_clearance or self.clearances[cell] >= self.settings.max_narrowing * height:
            self._parents[lower] = hill
        else:
            self._saddles.setdefault((hill, lower), cell)

    def _height(self, hill: int) -> float:
        return float(self.clearances[self.summits[hill]])


def _clearances(free: FreeSpace) -> FloatArray:
    """Distance of each cell's middle from what is not free [m], 0 there; with a border of one cell."""
    from scipy.ndimage import distance_transform_edt  # noqa: PLC0415 - only mappers need it

    bordered = np.pad(free.data, 1)
    clearances: FloatArray = free.resolution * (distance_transform_edt(bordered) - 0.5 * bordered)
    return clearances


def _middle(cell: tuple[int, int], free: FreeSpace) -> FloatArray:
    # Cells count from the border, which free space itself does not have.
    center: FloatArray = free.centers(np.array([cell]) - 1)[0]
    return center
