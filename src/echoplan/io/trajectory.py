"""Trajectories as the TUM benchmark writes them: ``trajectory.tum``, which evo and others read."""

from pathlib import Path

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.errors import InputError
from echoplan.io.files import by_name, read_text, write_text

__all__ = ["read_trajectory", "write_trajectory"]

_COLUMNS = 8


@by_name
def write_trajectory(path: Path, times: FloatArray, poses: FloatArray) -> None:
    """Write poses in the plane as lines ``t x y z qx qy qz qw``.

    Parameters
    ----------
    path : Path or str
        The file.
    times : ndarray, shape (n,)
        When the robot was there [s].
    poses : ndarray, shape (n, 3)
        Where [m, m, rad].

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    half = poses[:, 2] / 2
    zeros = np.zeros(len(poses))
    rows = np.column_stack([times, poses[:, :2], zeros, zeros, zeros, np.sin(half), np.cos(half)])
    lines = [" ".join(map(repr, row)) for row in rows.tolist()]
    write_text(path, "\n".join(["# t x y z qx qy qz qw", *lines]) + "\n")


@by_name
def read_trajectory(path: Path) -> tuple[FloatArray, FloatArray]:
    """Read poses in the plane.

    Parameters
    ----------
    path : Path or str
        A file as ``write_trajectory`` or evo write it; height, roll and pitch are left out.

    Returns
    -------
    times : ndarray, shape (n,)
        When [s].
    poses : ndarray, shape (n, 3)
        Where [m, m, rad].

    Raises
    ------
    InputError
        If the file cannot be read or a line has not eight numbers.
    """
    rows = [
        _numbers(path, number, line)
        for number, line in enumerate(read_text(path).splitlines(), start=1)
        if line.strip() and not line.startswith("#")
    ]
    table = np.array(rows, dtype=np.float64).reshape(-1, _COLUMNS)
    x, y, z, w = table[:, 4:].T
    yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return table[:, 0], np.column_stack([table[:, 1:3], yaw])


def _numbers(path: Path, number: int, line: str) -> list[float]:
    remedy = "write t x y z qx qy qz qw, eight numbers with blanks between them"
    try:
        values = [float(text) for text in line.split()]
    except ValueError:
        raise InputError(path, f"line {number} has {line.strip()!r}, which is not all numbers", remedy=remedy) from None
    if len(values) != _COLUMNS:
        raise InputError(path, f"line {number} has {len(values)} numbers", remedy=remedy)
    return values
