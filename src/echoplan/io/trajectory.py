"""Trajectories as the TUM benchmark writes them: ``trajectory.tum``, which evo and others read."""

from decimal import Decimal
from pathlib import Path

import numpy as np

from echoplan.arrays import FloatArray, IntArray
from echoplan.errors import InputError
from echoplan.io.files import by_name, read_text, write_text
from echoplan.io.text import format_seconds

__all__ = ["read_trajectory", "write_trajectory"]

_COLUMNS = 8


@by_name
def write_trajectory(path: Path, stamps_ns: IntArray, poses: FloatArray) -> None:
    """Write poses in the plane as lines ``t x y z qx qy qz qw``.

    Parameters
    ----------
    path : Path or str
        The file.
    stamps_ns : ndarray of int, shape (n,)
        When the robot was there [ns].
    poses : ndarray, shape (n, 3)
        Where [m, m, rad].

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    half = poses[:, 2] / 2
    zeros = np.zeros(len(poses))
    rows = np.column_stack([poses[:, :2], zeros, zeros, zeros, np.sin(half), np.cos(half)])
    times = map(format_seconds, stamps_ns.tolist())
    lines = [" ".join([time, *map(repr, row)]) for time, row in zip(times, rows.tolist(), strict=True)]
    write_text(path, "\n".join(["# t x y z qx qy qz qw", *lines]) + "\n")


@by_name
def read_trajectory(path: Path) -> tuple[IntArray, FloatArray]:
    """Read poses in the plane.

    Parameters
    ----------
    path : Path or str
        A file as ``write_trajectory`` or evo write it; height, roll and pitch are left out.

    Returns
    -------
    stamps_ns : ndarray of int, shape (n,)
        When [ns].
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
    stamps_ns = np.array([stamp for stamp, _ in rows], dtype=np.int64)
    table = np.array([pose for _, pose in rows], dtype=np.float64).reshape(-1, _COLUMNS - 1)
    x, y, z, w = table[:, 3:].T
    yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return stamps_ns, np.column_stack([table[:, :2], yaw])


def _numbers(path: Path, number: int, line: str) -> tuple[int, list[float]]:
    """Read the time [ns] and the other numbers of a line."""
    remedy = "write t x y z qx qy qz qw, eight numbers with blanks between them"
    try:
        values = [float(text) for text in line.split()]
        # A double holds times since 1970 to a quarter of a microsecond only.
        stamp_ns = int(Decimal(line.split(maxsplit=1)[0]).scaleb(9).to_integral_value())
    except (ValueError, ArithmeticError):
        raise InputError(path, f"line {number} has {line.strip()!r}, which is not all numbers", remedy=remedy) from None
    if len(values) != _COLUMNS:
        raise InputError(path, f"line {number} has {len(values)} numbers", remedy=remedy)
    return stamp_ns, values[1:]
