"""Free space: where echoes show that nothing stands, as cells of a grid."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import ceil
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from echoplan.arrays import BoolArray, FloatArray, IntArray, checked_floats, checked_number, store
from echoplan.errors import InvalidValueError
from echoplan.geometry import directions
from echoplan.model import Pings
from echoplan.settings import Settings

__all__ = ["FreeSpace", "FreeSpaceSettings", "find_free_space"]

# Pings whose rays are laid out at once: a whole recording would fill the memory.
_BLOCK = 500


class FreeSpaceSettings(Settings):
    """What counts as free."""

    former_keys: ClassVar = {"share": "free_fraction", "body": "robot_radius"}

    resolution: float = Field(default=0.05, gt=0.0, description="Side of a cell [m].")
    max_cells: int = Field(
        default=16_000_000, gt=0, description="Largest number of cells of a map: 200 m by 200 m at 5 cm."
    )
    free_fraction: float = Field(
        default=0.7,
        gt=0.0,
        le=1.0,
        description="Share of a range that is surely free: a corner behind a wall at 45 degrees that gives no "
        "echo is detected 1.4 times as far.",
    )
    half_width: float = Field(default=0.05, gt=0.0, description="Half the angle of the free sector [rad]: 3 degrees.")
    min_votes: int = Field(
        default=3, ge=1, description="Smallest number of rays that must cross a free cell: one may be an outlier."
    )
    robot_radius: float = Field(
        default=0.15, ge=0.0, description="Radius of the robot, which clears the cells where it was [m]."
    )


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class FreeSpace:
    """Cells that are free, and the others, which are taken or unknown.

    Parameters
    ----------
    origin_xy : ndarray, shape (2,)
        Lower left corner of cell (0, 0) [m].
    resolution : float
        Side of a cell [m].
    data : ndarray of bool, shape (height, width)
        ``data[iy, ix]`` is True where a cell is free.
    """

    origin_xy: FloatArray
    resolution: float
    data: BoolArray

    def __post_init__(self) -> None:
        checked_number(self.resolution, name="resolution", above=0.0)
        data = np.array(self.data, dtype=np.bool_)
        data.setflags(write=False)
        store(self, origin_xy=checked_floats(self.origin_xy, name="origin_xy", shape=(2,)), data=data)

    @property
    def area(self) -> float:
        """How much is free [m2]."""
        return float(self.data.sum()) * self.resolution**2

    def cells(self, points_xy: ArrayLike) -> IntArray:
        """Cells in which points are, be they in the grid or not.

        Parameters
        ----------
        points_xy : array_like, shape (n, 2)
            Points [m].

        Returns
        -------
        ndarray of int, shape (n, 2)
            ``(iy, ix)`` of each.
        """
        places = (np.asarray(points_xy, dtype=np.float64) - self.origin_xy) / self.resolution
        cells: IntArray = np.floor(places).astype(np.int64)[:, ::-1]
        return cells

    def centers(self, cells: IntArray) -> FloatArray:
        """Middles of cells.

        Parameters
        ----------
        cells : ndarray of int, shape (n, 2)
            ``(iy, ix)`` of each.

        Returns
        -------
        ndarray, shape (n, 2)
            ``(x, y)`` [m].
        """
        centers: FloatArray = self.origin_xy + self.resolution * (cells[:, ::-1] + 0.5)
        return centers

    def at(self, points_xy: ArrayLike) -> BoolArray:
        """Return whether points are in free cells.

        Parameters
        ----------
        points_xy : array_like, shape (n, 2)
            Points [m].

        Returns
        -------
        ndarray of bool, shape (n,)
            False also beyond the grid.
        """
        cells = self.cells(points_xy)
        inside = ((cells >= 0) & (cells < self.data.shape)).all(axis=1)
        found = np.zeros(len(cells), dtype=np.bool_)
        found[inside] = self.data[tuple(cells[inside].T)]
        return found


def find_free_space(pings_by_sweep: Sequence[Pings], settings: FreeSpaceSettings | None = None) -> FreeSpace:
    """Find where nothing stands: before reflectors, and where the robot was.

    A range is that of the nearest thing in the beam that faces the sensor.  A smooth wall that is met at a slant does
    not answer, and what is detected instead lies farther away; so only a share of each range counts.

    Parameters
    ----------
    pings_by_sweep : sequence of Pings
        Valid pings of each sweep.
    settings : FreeSpaceSettings, optional
        What counts as free.

    Returns
    -------
    FreeSpace
        Just large enough for all of it, with a border that is not free.

    Raises
    ------
    InvalidValueError
        If that would have more cells than it may.

    Examples
    --------
    >>> zero = np.zeros((1, 2))
    >>> ping = Pings(origins_xy=zero, hubs_xy=zero, bearings=[0.0], ranges=[2.0], sensors=[0])
    >>> find_free_space([ping], FreeSpaceSettings(min_votes=1)).at([[1.3, 0.0], [1.9, 0.0], [0.0, 1.3]])
    array([ True, False, False])
    """
    from scipy.ndimage import median_filter  # noqa: PLC0415 - SciPy is slow to import

    settings = settings or FreeSpaceSettings()
    blocks = [pings[start : start + _BLOCK] for pings in pings_by_sweep for start in range(0, len(pings), _BLOCK)]
    if not blocks:
        return FreeSpace(origin_xy=np.zeros(2), resolution=settings.resolution, data=np.zeros((1, 1), dtype=np.bool_))
    empty = _empty(blocks, settings)
    votes = np.zeros(empty.data.size, dtype=np.int64)
    for points in _rays(blocks, settings):
        cells = np.ravel_multi_index(tuple(empty.cells(points).T), empty.data.shape)
        votes += np.bincount(cells, minlength=len(votes))
    swept = replace(empty, data=(votes >= settings.min_votes).reshape(empty.data.shape))
    free = _with_bodies(swept, np.concatenate([pings.hubs_xy for pings in blocks]), settings.robot_radius)
    # Single cells follow their neighbours.
    return replace(free, data=median_filter(free.data, size=3))


def _empty(pings_by_sweep: Sequence[Pings], settings: FreeSpaceSettings) -> FreeSpace:
    """Allocate a grid that holds all pings."""
    reaches = np.concatenate([pings.ranges for pings in pings_by_sweep])[:, None] * settings.free_fraction
    places = np.concatenate([np.concatenate([pings.origins_xy, pings.hubs_xy], axis=1) for pings in pings_by_sweep])
    border = np.maximum(reaches, settings.robot_radius) + 2 * settings.resolution
    low = (places - border).min(axis=0).reshape(2, 2).min(axis=0)
    high = (places + border).max(axis=0).reshape(2, 2).max(axis=0)
    width, height = map(int, np.ceil((high - low) / settings.resolution))
    if width * height > settings.max_cells:
        raise InvalidValueError(
            f"a grid of {width * settings.resolution:.5g} m by {height * settings.resolution:.5g} m would have more "
            f"cells than max_cells = {settings.max_cells}; check the poses or choose a greater resolution"
        )
    return FreeSpace(origin_xy=low, resolution=settings.resolution, data=np.zeros((height, width), dtype=np.bool_))


def _rays(pings_by_sweep: Sequence[Pings], settings: FreeSpaceSettings) -> Iterator[FloatArray]:
    """Lay points along the rays of pings, a cell apart at most, block by block."""
    for pings in pings_by_sweep:
        reaches = settings.free_fraction * pings.ranges
        beside = ceil(settings.half_width * float(reaches.max()) / settings.resolution)
        angles = pings.bearings[:, None] + np.linspace(-settings.half_width, settings.half_width, 2 * beside + 1)
        depths = np.arange(settings.resolution / 2, max(float(reaches.max()), settings.resolution), settings.resolution)
        points = pings.origins_xy[:, None, None] + depths[:, None] * directions(angles)[:, :, None]
        yield points[np.broadcast_to(depths < reaches[:, None, None], points.shape[:3])]


def _with_bodies(free: FreeSpace, bodies_xy: FloatArray, radius: float) -> FreeSpace:
    """Mark discs around the poses as free: the robot was there."""
    from scipy.spatial import cKDTree  # noqa: PLC0415 - only mappers need it

    cells = np.argwhere(~free.data)
    distances, _ = cKDTree(bodies_xy).query(free.centers(cells))
    data = free.data.copy()
    data[tuple(cells[distances <= radius].T)] = True
    return replace(free, data=data)
