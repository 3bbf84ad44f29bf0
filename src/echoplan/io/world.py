"""Worlds in TOML: ``world.toml``."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from pydantic import Field

from echoplan.io.files import by_name, write_text
from echoplan.io.structure import Form, Pair, read_toml
from echoplan.io.text import format_toml
from echoplan.io.units import Radius, check_extent
from echoplan.model import Pillar, Polyline, World

__all__ = ["read_world", "write_world"]


class _WallForm(Form, extra="forbid"):
    points: list[Pair] = Field(description="List of vertices [x, y] in metres, joined in their order.")
    closed: bool = Field(default=False, description="Whether the last vertex joins the first.")
    material: str = Field(default="hard", description="Material of the wall.")

    def value(self) -> Polyline:
        """Make the walls."""
        return Polyline(points_xy=np.array(self.points), closed=self.closed, material=self.material)


class _CylinderForm(Form, extra="forbid"):
    center: Pair = Field(description="Axis of the cylinder [x, y] in metres.")
    radius: Radius = Field(description="Radius of the cylinder [m].")
    material: str = Field(default="hard", description="Material of the cylinder.")

    def value(self) -> Pillar:
        """Make the cylinder."""
        return Pillar(center_xy=np.array(self.center), radius=self.radius, material=self.material)


class _WorldForm(Form, extra="forbid"):
    name: str = Field(default="", description="Name of the world.")
    wall: list[_WallForm] = Field(default=[], description="List of tables [[wall]], one for each run.")
    cylinder: list[_CylinderForm] = Field(default=[], description="List of tables [[cylinder]], one for each.")

    def value(self) -> World:
        """Make the world."""
        world = World(
            name=self.name,
            polylines=tuple(wall.value() for wall in self.wall),
            pillars=tuple(cylinder.value() for cylinder in self.cylinder),
        )
        check_extent(np.concatenate([world.segments_xy.reshape(-1, 2), world.discs[:, :2]]), name="the world")
        return world


@by_name
def read_world(path: Path) -> World:
    """Read a world.

    Parameters
    ----------
    path : Path or str
        The file.

    Returns
    -------
    World
        The world; without a name of its own it is called after the file.

    Raises
    ------
    InputError
        If the file cannot be read or describes no possible world.
    """
    world = read_toml(path, _WorldForm).value()
    return replace(world, name=world.name or path.stem)


@by_name
def write_world(path: Path, world: World) -> None:
    """Write a world.

    Parameters
    ----------
    path : Path or str
        The file.
    world : World
        The world.

    Raises
    ------
    OutputError
        If the file cannot be written.

    Examples
    --------
    >>> from echoplan.io import builtin_world
    >>> path = getfixture("tmp_path") / "world.toml"
    >>> write_world(path, builtin_world("square"))
    >>> read_world(path).name
    'square'
    """
    walls = [
        {"points": wall.points_xy.tolist(), "closed": wall.closed, "material": wall.material}
        for wall in world.polylines
    ]
    cylinders = [
        {"center": pillar.center_xy.tolist(), "radius": pillar.radius, "material": pillar.material}
        for pillar in world.pillars
    ]
    write_text(path, format_toml({"name": world.name, "wall": walls, "cylinder": cylinders}))
