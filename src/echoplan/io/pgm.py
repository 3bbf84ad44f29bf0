"""Grey pictures in the portable graymap format: binary, one byte a pixel (P5)."""

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from echoplan.errors import InputError
from echoplan.io.files import check_file, readable, write_bytes

__all__ = ["read_pgm", "write_pgm"]

# The kind, then width, height and greatest value between white space and comments, then one white space.
_GAP = rb"(?:\s|#[^\n]*\n)+"
_HEAD = re.compile(rb"(P\d)" + (_GAP + rb"(\d{1,9})") * 3 + rb"\s")
_REMEDY = "save it as a binary PGM with one byte a pixel"


def read_pgm(path: Path) -> NDArray[np.uint8]:
    """Read a picture.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    ndarray of uint8, shape (height, width)
        The grey values, 0 for black, from top to bottom.

    Raises
    ------
    InputError
        If the file cannot be read, is of another kind or is cut off.
    """
    check_file(path)
    with readable(path):
        data = path.read_bytes()
    head = _HEAD.match(data)
    if head is None:
        raise InputError(path, f"it is no PGM: it begins with {data[:8]!r}", remedy=_REMEDY)
    kind, (width, height, greatest) = head[1].decode(), map(int, head.groups()[1:])
    if kind != "P5" or greatest != 255:
        raise InputError(path, f"it is of kind {kind} with values up to {greatest}", place="head", remedy=_REMEDY)
    if len(data) - head.end() < width * height:
        problem = f"{width} x {height} pixels are announced, {len(data) - head.end()} are there"
        raise InputError(path, problem, place="pixels", remedy="write the file again")
    return np.frombuffer(data, dtype=np.uint8, count=width * height, offset=head.end()).reshape(height, width)


def write_pgm(path: Path, pixels: NDArray[np.uint8]) -> None:
    """Write a picture.

    Parameters
    ----------
    path : Path
        The file.
    pixels : ndarray of uint8, shape (height, width)
        The grey values, 0 for black, from top to bottom.

    Raises
    ------
    OutputError
        If the file cannot be written.

    Examples
    --------
    >>> path = getfixture("tmp_path") / "map.pgm"
    >>> write_pgm(path, np.array([[0, 205, 254]], dtype=np.uint8))
    >>> read_pgm(path).tolist()
    [[0, 205, 254]]
    """
    height, width = pixels.shape
    write_bytes(path, f"P5\n{width} {height}\n255\n".encode() + np.ascontiguousarray(pixels, dtype=np.uint8).tobytes())
