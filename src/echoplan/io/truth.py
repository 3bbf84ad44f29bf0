"""What a map of a recording should say, in JSON: ``truth.json``."""

from os import PathLike
from pathlib import Path

import numpy as np
from pydantic import Field

from echoplan.arrays import IntArray
from echoplan.errors import InvalidValueError
from echoplan.io.files import by_name, inside, write_text
from echoplan.io.structure import Count, Form, Quadruple, Triple, read_json
from echoplan.io.text import format_json
from echoplan.io.units import check_extent
from echoplan.io.world import read_world
from echoplan.model import EVERYWHERE, Truth

__all__ = ["as_truth", "read_truth", "write_truth"]


class _TruthForm(Form):
    walls: list[Quadruple] = Field(description="List of faces [x1, y1, x2, y2] in metres.")
    walls_heard: list[Count] | None = Field(default=None, description="Number of stations that can detect each wall.")
    cylinders: list[Triple] = Field(default=[], description="List of cylinders [x, y, radius] in metres.")
    cylinders_heard: list[Count] | None = Field(
        default=None, description="Number of stations that can detect each cylinder."
    )
    poses: list[Triple] = Field(default=[], description="True pose [x, y, yaw] of each sweep.")
    given: list[Triple] = Field(default=[], description="Recorded pose [x, y, yaw] of each sweep.")
    temperature: float | None = Field(default=None, description="Temperature of the air in degrees Celsius.")

    def value(self) -> Truth:
        """Make the truth."""
        places = [each[:2] for each in (*self.cylinders, *self.poses)]
        check_extent([*np.reshape(self.walls, (-1, 2)), *places], name="the truth")
        return Truth(
            walls_xy=np.reshape(self.walls, (-1, 2, 2)),
            walls_detected_by=_counts(self.walls_heard, len(self.walls)),
            cylinders=np.reshape(self.cylinders, (-1, 3)),
            cylinders_detected_by=_counts(self.cylinders_heard, len(self.cylinders)),
            poses=np.reshape(self.poses, (-1, 3)),
            given=np.reshape(self.given or self.poses, (-1, 3)),
            temperature=self.temperature,
        )


def _counts(detected_by: list[int] | None, count: int) -> IntArray:
    return np.full(count, EVERYWHERE) if detected_by is None else np.array(detected_by, dtype=np.int64)


@by_name
def read_truth(path: Path) -> Truth:
    """Read the truth of a recording.

    Parameters
    ----------
    path : Path or str
        The file, or the folder with ``truth.json``; or a world, all of whose faces and cylinders count.

    Returns
    -------
    Truth
        The truth; objects without a count are detectable everywhere, and poses given that are left out are
        the true ones.

    Raises
    ------
    InputError
        If the file cannot be read or its lists do not go together.
    """
    if path.suffix == ".toml":
        world = read_world(path)
        walls, cylinders = world.segments_xy, world.discs
        return Truth(
            walls_xy=walls,
            walls_detected_by=_counts(None, len(walls)),
            cylinders=cylinders,
            cylinders_detected_by=_counts(None, len(cylinders)),
        )
    return read_json(inside(path, "truth.json"), _TruthForm).value()


def as_truth(truth: Truth | str | PathLike[str]) -> Truth:
    """Return a truth, or read it from its file.

    Raises
    ------
    InvalidValueError
        If it is neither.
    """
    if isinstance(truth, Truth):
        return truth
    if not isinstance(truth, str | PathLike):
        raise InvalidValueError(f"truth must be a Truth or the path of a truth.json, not {type(truth).__name__}")
    return read_truth(truth)


@by_name
def write_truth(path: Path, truth: Truth) -> None:
    """Write the truth of a recording.

    Parameters
    ----------
    path : Path or str
        The file.
    truth : Truth
        The truth.

    Raises
    ------
    OutputError
        If the file cannot be written.

    Examples
    --------
    >>> path = getfixture("tmp_path") / "truth.json"
    >>> write_truth(path, Truth(walls_xy=[[[0, 0], [4, 0]]], walls_detected_by=[3]))
    >>> read_truth(path).walls_detected_by
    array([3])
    """
    known = {
        "walls": truth.walls_xy.reshape(-1, 4).tolist(),
        "walls_heard": truth.walls_detected_by.tolist(),
        "cylinders": truth.cylinders.tolist(),
        "cylinders_heard": truth.cylinders_detected_by.tolist(),
        "poses": truth.poses.tolist(),
        "given": truth.given.tolist(),
    }
    air = {} if truth.temperature is None else {"temperature": truth.temperature}
    write_text(path, format_json(known | air) + "\n")
