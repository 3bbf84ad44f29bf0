"""Occupancy grids as ROS keeps them: a picture and a YAML file beside it that says where it lies (map_server)."""

import re
import reprlib
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, ValidationError

from echoplan.arrays import FloatArray
from echoplan.errors import InputError
from echoplan.io.files import by_name, read_text, write_text
from echoplan.io.pgm import read_pgm, write_pgm
from echoplan.io.structure import Form
from echoplan.io.units import Coordinate
from echoplan.model import OccupancyGrid

__all__ = ["read_grid", "trinary_cells", "write_grid"]

# Grey values of map_saver.  205 stands for a probability of 0.1961: the threshold below is just less.
_OCCUPIED, _UNKNOWN, _FREE = 0, 205, 254
_OCCUPIED_THRESHOLD, _FREE_THRESHOLD = 0.65, 0.196

_NUMBER = re.compile(r"[-+]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]+)?")
Origin = Annotated[list[Coordinate], Field(min_length=3, max_length=3)]


class _GridForm(Form):
    image: str = Field(min_length=1)
    resolution: float = Field(gt=0.0, le=100.0)
    origin: Origin
    negate: Literal[0, 1] = 0
    occupied_thresh: float = Field(default=_OCCUPIED_THRESHOLD, ge=0.0, le=1.0)
    free_thresh: float = Field(default=_FREE_THRESHOLD, ge=0.0, le=1.0)
    mode: Literal["trinary", "scale", "raw"] = "trinary"


@by_name
def read_grid(path: Path) -> OccupancyGrid:
    """Read a grid of map_server.

    Parameters
    ----------
    path : Path or str
        The YAML file; the picture that it names must be a binary PGM.

    Returns
    -------
    OccupancyGrid
        In the mode ``trinary`` 0, 1/2 and 1; in ``scale`` the grey values as probabilities, in ``raw`` as per cent.

    Raises
    ------
    InputError
        If a file cannot be read, an entry is missing or wrong, or the map is turned.
    """
    form = _read_form(path)
    x, y, yaw = form.origin
    if yaw != 0.0:
        raise InputError(path, f"the map is turned by {yaw:g} rad", place="origin", remedy="save it with a yaw of 0")
    pixels = read_pgm(path.parent / form.image)
    if not pixels.size:
        raise InputError(path.parent / form.image, "it has no pixel", remedy="write the file again")
    values = _probabilities(pixels, form)
    return OccupancyGrid(origin_xy=np.array([x, y]), resolution=form.resolution, values=np.flipud(values))


@by_name
def write_grid(path: Path, grid: OccupancyGrid) -> None:
    """Write a grid for map_server and whatever else reads its files.

    Parameters
    ----------
    path : Path or str
        The YAML file; the picture lies beside it under the same name with ``.pgm``.
    grid : OccupancyGrid
        The grid; of the probabilities only occupied, free and unknown are kept.

    Raises
    ------
    OutputError
        If a file cannot be written.

    Examples
    --------
    >>> path = getfixture("tmp_path") / "map.yaml"
    >>> write_grid(path, OccupancyGrid(origin_xy=[-1, 2], resolution=0.05, values=[[0.5, 0.1, 0.9]]))
    >>> read_grid(path).values.tolist()
    [[0.5, 0.0, 1.0]]
    """
    cells = trinary_cells(grid)
    shades = np.select([cells > 0, cells == 0], [_OCCUPIED, _FREE], _UNKNOWN)
    picture = path.with_suffix(".pgm")
    # To a nanometre: whole cells are seldom whole numbers of metres in binary.
    x, y = grid.origin_xy.round(9).tolist()
    entries = {
        "image": picture.name,
        "mode": "trinary",
        "resolution": grid.resolution,
        "origin": [x, y, 0.0],
        "negate": 0,
        "occupied_thresh": _OCCUPIED_THRESHOLD,
        "free_thresh": _FREE_THRESHOLD,
    }
    write_pgm(picture, np.flipud(shades).astype(np.uint8))
    write_text(path, "".join(f"{name}: {value}\n" for name, value in entries.items()))


def trinary_cells(grid: OccupancyGrid) -> NDArray[np.int8]:
    """Return the cells as map_server publishes them: 100 occupied, 0 free, -1 unknown; shape (rows, columns)."""
    cells = np.select([grid.values > _OCCUPIED_THRESHOLD, grid.values < _FREE_THRESHOLD], [100, 0], -1)
    return cells.astype(np.int8)


def _read_form(path: Path) -> _GridForm:
    entries: dict[str, object] = {}
    for number, line in enumerate(read_text(path).split("\n"), start=1):
        # A comment begins with the line or after a blank; elsewhere # is a character like others.
        content = re.split(r"(?:^|(?<=\s))#", line, maxsplit=1)[0].strip()
        if content in ("", "---"):
            continue
        name, colon, text = content.partition(":")
        if not colon:
            remedy = "write one entry a line: name: value"
            problem = f"{reprlib.repr(content)} is no entry of a map"
            raise InputError(path, problem, place=f"line {number}", remedy=remedy)
        entries[name.strip()] = _value(text.strip())
    try:
        return _GridForm.model_validate(entries)
    except ValidationError as error:
        fault = error.errors()[0]
        place = str(fault["loc"][0])
        problem = f"{fault['msg'].lower()}, not {reprlib.repr(entries.get(place))}"
        raise InputError(path, problem, place=place, remedy="see the documentation of map_server") from error


def _value(text: str) -> object:
    """Read a scalar or a list of numbers, as far as YAML is needed here."""
    if text.startswith("[") and text.endswith("]"):
        return [_value(item.strip()) for item in text[1:-1].split(",")]
    if _NUMBER.fullmatch(text):
        return int(text) if re.fullmatch(r"[-+]?[0-9]{1,18}", text) else float(text)
    return {"true": 1, "false": 0}.get(text.lower(), text.strip("\"'"))


def _probabilities(pixels: NDArray[np.uint8], form: _GridForm) -> FloatArray:
    if form.mode == "raw":
        return np.where(pixels <= 100, pixels / 100.0, 0.5)
    shades: FloatArray = pixels / 255.0 if form.negate else (255 - pixels) / 255.0
    if form.mode == "scale":
        return shades
    return np.select([shades >= form.occupied_thresh, shades <= form.free_thresh], [1.0, 0.0], 0.5)
