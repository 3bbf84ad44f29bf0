"""The occupancy grid of a feature map: walls and cylinders occupied, free where sound or the robot passed."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil, floor, pi

import numpy as np
from pydantic import Field

from echoplan.arrays import BoolArray, FloatArray
from echoplan.errors import InvalidValueError
from echoplan.grids.ray_casting import Fans, cells_on_segments, fans_of, join_fans, rays_per_cell
from echoplan.model import FeatureMap, OccupancyGrid, Opening, Pings, Rig, Sweep, UnobservedStretch, Wall
from echoplan.preprocessing import placed_sweeps, valid_ranges
from echoplan.settings import Settings

__all__ = ["MapGridSettings", "grid_from_map"]

_UNKNOWN = 0.5


class MapGridSettings(Settings):
    """How a feature map becomes a grid."""

    resolution: float = Field(
        default=0.05,
        gt=0.0,
        description="Side of a cell [m], as is common for navigation; doubled until there are at most max_cells.",
    )
    padding: float = Field(default=0.25, ge=0.0, description="Width of the unknown border about all known cells [m].")
    max_cells: int = Field(
        default=16_000_000, gt=0, description="Largest number of cells of a map: 200 m by 200 m at 5 cm."
    )
    range_margin: float = Field(
        default=0.1,
        ge=0.0,
        description="Part of each range that does not count as free [m]: weak echoes read up to 5 cm too far, and a "
        "ray clears the whole of the cell in which it ends.",
    )
    beam_fraction: float = Field(
        default=0.5,
        gt=0.0,
        le=1.0,
        description="Share of the half aperture of a sensor within which a ping clears cells. At half the angle a "
        "piston loses a quarter of the decibels that it loses at the edge, so that weaker reflectors than walls are "
        "detected too.",
    )
    min_pings: int = Field(
        default=2, ge=1, description="Smallest number of pings that must pass through a free cell: one may be false."
    )
    robot_radius: float = Field(
        default=0.0, ge=0.0, description="Radius of the robot, which clears the cells where it was [m]; 0 if unknown."
    )
    station_reach: float = Field(
        default=5.0,
        gt=0.0,
        description="Without sweeps: how far from a pose the space before a wall is free [m].",
    )


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class _Lattice:
    """Where the cells lie: the origin is a whole number of cells from that of the map."""

    resolution: float
    first_xy: FloatArray
    shape: tuple[int, int]

    def cells(self, points_xy: FloatArray) -> FloatArray:
        """Take points, shape (..., 2) [m], to columns and rows with fractions."""
        cells: FloatArray = points_xy / self.resolution - self.first_xy
        return cells

    def fans(self, fans: Fans) -> Fans:
        """Take sectors from metres to cells."""
        x, y = self.cells(np.stack([fans.x, fans.y], axis=-1)).T
        return fans._replace(
            x=x.copy(), y=y.copy(), reaches=fans.reaches / self.resolution, horizons=fans.horizons / self.resolution
        )


def grid_from_map(
    feature_map: FeatureMap,
    *,
    rig: Rig | None = None,
    sweeps: Sequence[Sweep] | None = None,
    settings: MapGridSettings | None = None,
) -> OccupancyGrid:
    """Make an occupancy grid of a feature map.

    **Occupied** are walls, cylinders and corners.  Inferred pieces of walls are occupied too: a robot must not plan
    through them.

    **Free** is what rays cross before the first occupied cell, so that nothing behind a wall is free, whatever a
    reading says.  A ray counts only if it would meet an occupied cell within the reach of the sensor: one that meets
    none may have passed through a wall that the map lacks.  Rays also end at unobserved stretches, which stay unknown.
    Openings are free, as is the straight path from pose to pose, as wide as the robot or, if its radius is unknown, as
    a cell.  Where the path crosses a wall, the wall is occupied.

    - With sweeps, each ping that detected an echo casts rays within its beam, up to its range, from the corrected pose
      of its sweep.  A cell is free if several pings clear it.  Pings without an echo clear nothing, since a smooth wall
      that is met at a slant reflects sound away.
    - Without sweeps, rays run from each pose in all directions, up to ``station_reach``.  Niches that no sensor looked
      into may then be free.

    Everything else is **unknown**.

    Parameters
    ----------
    feature_map : FeatureMap
        The map.
    rig : Rig, optional
        What made the sweeps.
    sweeps : sequence of Sweep, optional
        The sweeps of the map, without faulty readings; those that are not in the map are skipped.
    settings : MapGridSettings, optional
        Size of the cells, and what is free.

    Returns
    -------
    OccupancyGrid
        Occupied 1, free 0, unknown 1/2, in the frame of the map; one unknown cell for an empty map.

    Raises
    ------
    InvalidValueError
        If there are sweeps without a rig.

    Examples
    --------
    >>> from echoplan.model import Wall
    >>> wall = Wall(normal_angle=0.0, offset=2.0, endpoints_xy=[[2.0, -1.0], [2.0, 1.0]], covariance=np.eye(2))
    >>> grid = grid_from_map(FeatureMap(method="none", walls=(wall,), sweeps=[0], poses=[[0.0, 0.0, 0.0]]))
    >>> [float(grid.values[row, column]) for row, column in grid.cells_of([[1.9, 0.0], [2.0, 0.0], [2.1, 0.0]])]
    [0.0, 1.0, 0.5]
    """
    settings = settings or MapGridSettings()
    if sweeps is None:
        poses = feature_map.poses
        fans = fans_of(poses[:, :2], reaches=settings.station_reach, horizons=settings.station_reach)
    elif rig is None:
        raise InvalidValueError("sweeps need the rig that made them")
    else:
        placed = placed_sweeps(sweeps, feature_map)
        poses = np.concatenate([np.zeros((0, 3)), *(sweep.map_from_base for sweep in placed)])
        fans = join_fans([_fans_of_echoes(sweep, rig, settings=settings) for sweep in placed])
    lattice = _lattice(feature_map, settings, poses=poses, fans=fans)
    occupied = _occupied(feature_map, lattice)
    barriers = occupied | _drawn(feature_map.unobserved, lattice)
    counts = rays_per_cell(lattice.fans(fans), barriers)
    seen = counts >= (1 if sweeps is None else settings.min_pings)
    driven = _driven(poses, occupied, lattice=lattice, robot_radius=settings.robot_radius)
    free = (seen | driven | _drawn(feature_map.openings, lattice)) & ~occupied
    values = np.select([occupied, free], [1.0, 0.0], _UNKNOWN)
    return replace(_cropped(values, lattice, padding=settings.padding), frame=feature_map.frame)


def _fans_of_echoes(sweep: Sweep, rig: Rig, *, settings: MapGridSettings) -> Fans:
    """Return the beams of the pings of a sweep that detected an echo, up to it."""
    pings = Pings.from_sweep(sweep, rig)
    ranges = valid_ranges(pings, rig)
    reaches = np.where(np.isfinite(ranges), ranges, 0.0) - settings.range_margin
    # No sensor detects what is behind it.
    half_apertures = np.minimum([sensor.half_aperture for sensor in rig.sensors], pi / 2)[pings.sensors]
    chosen = reaches > 0.0
    return fans_of(
        pings.origins_xy[chosen],
        bearings=pings.bearings[chosen],
        half_angles=settings.beam_fraction * half_apertures[chosen],
        reaches=reaches[chosen],
        horizons=rig.max_ranges[pings.sensors][chosen],
    )


def _lattice(feature_map: FeatureMap, settings: MapGridSettings, *, poses: FloatArray, fans: Fans) -> _Lattice:
    """Lay cells under everything that is drawn."""
    long: tuple[Wall | Opening | UnobservedStretch, ...]
    long = (*feature_map.walls, *feature_map.openings, *feature_map.unobserved)
    ends = np.array([each.endpoints_xy for each in long]).reshape(-1, 2)
    centers = np.concatenate([_discs(feature_map)[:, :2], poses[:, :2], np.stack([fans.x, fans.y], axis=-1)])
    around = np.full(len(poses), settings.robot_radius)
    radii = np.concatenate([_discs(feature_map)[:, 2], around, fans.reaches])[:, None]
    corners_xy = np.concatenate([ends, centers - radii, centers + radii])
    if not len(corners_xy):
        return _Lattice(resolution=settings.resolution, first_xy=np.zeros(2), shape=(1, 1))
    # A border of one cell on each side: what lies on a side is rounded to either of its cells.
    extent = np.ptp(corners_xy, axis=0)
    doublings = np.arange(64)
    counts = np.prod(np.ceil(extent / (settings.resolution * 2.0 ** doublings[:, None])) + 3.0, axis=1)
    resolution = settings.resolution * 2.0 ** int(doublings[counts <= settings.max_cells][0])
    low, high = np.floor(corners_xy.min(axis=0) / resolution) - 1.0, np.floor(corners_xy.max(axis=0) / resolution) + 2.0
    width, height = (high - low).tolist()
    return _Lattice(resolution=resolution, first_xy=low, shape=(int(height), int(width)))


def _discs(feature_map: FeatureMap) -> FloatArray:
    """Return centres and radii of cylinders and corners [m], shape (k, 3)."""
    discs = [[*each.center_xy, each.radius] for each in feature_map.cylinders]
    return np.array([*discs, *([*each.position_xy, 0.0] for each in feature_map.corners)]).reshape(-1, 3)


def _drawn(long: Sequence[Wall | Opening | UnobservedStretch], lattice: _Lattice) -> BoolArray:
    """Mark the cells that segments of a map touch."""
    ends = np.array([each.endpoints_xy for each in long]).reshape(-1, 2, 2)
    return cells_on_segments(lattice.cells(ends), shape=lattice.shape)


def _occupied(feature_map: FeatureMap, lattice: _Lattice) -> BoolArray:
    """Mark the cells that walls, cylinders and corners touch."""
    occupied = _drawn(feature_map.walls, lattice)
    for *center_xy, radius in _discs(feature_map):
        (x, y), reach = lattice.cells(np.array(center_xy)).tolist(), radius / lattice.resolution
        columns, rows = (np.arange(floor(middle - reach), floor(middle + reach) + 1) for middle in (x, y))
        # How far the nearest point of each cell is from the centre.
        aside, above = x - np.clip(x, columns, columns + 1), y - np.clip(y, rows, rows + 1)
        occupied[np.ix_(rows, columns)] |= np.hypot(aside, above[:, None]) <= reach
    return occupied


def _driven(poses: FloatArray, occupied: BoolArray, *, lattice: _Lattice, robot_radius: float) -> BoolArray:
    """Mark the cells in which the robot was on its straight way from pose to pose, up to walls from either side."""
    places = lattice.cells(poses[:, :2])
    starts = np.concatenate([places, places[:-1], places[1:]])
    spans = np.concatenate([places, places[1:], places[:-1]]) - starts
    bearings, lengths = np.arctan2(spans[:, 1], spans[:, 0]), np.hypot(*spans.T)
    path = rays_per_cell(fans_of(starts, bearings=bearings, half_angles=0.0, reaches=lengths), occupied) > 0
    centers = np.argwhere(path)[:, ::-1] + 0.5
    reach = robot_radius / lattice.resolution
    return path | (rays_per_cell(fans_of(centers, reaches=reach), occupied) > 0)


def _cropped(values: FloatArray, lattice: _Lattice, *, padding: float) -> OccupancyGrid:
    """Cut a grid to its known cells and the unknown border about them."""
    cells = np.argwhere(values != _UNKNOWN)
    if not len(cells):
        return OccupancyGrid(origin_xy=np.zeros(2), resolution=lattice.resolution, values=np.full((1, 1), _UNKNOWN))
    border = ceil(padding / lattice.resolution)
    low, high = cells.min(axis=0), cells.max(axis=0) + 1
    known = values[low[0] : high[0], low[1] : high[1]]
    return OccupancyGrid(
        origin_xy=lattice.resolution * (lattice.first_xy + low[::-1] - border),
        resolution=lattice.resolution,
        values=np.pad(known, border, constant_values=_UNKNOWN),
    )
