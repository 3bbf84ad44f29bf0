"""Named arrays of numbers in a file of NumPy, ``.npz``."""

import io
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.errors import InputError
from echoplan.io.files import by_name, check_file, readable, write_bytes

__all__ = ["read_arrays", "write_arrays"]


@by_name
def read_arrays(path: Path) -> dict[str, FloatArray]:
    """Read named arrays.

    Parameters
    ----------
    path : Path or str
        The file.

    Returns
    -------
    dict of str to ndarray
        The arrays.

    Raises
    ------
    InputError
        If the file cannot be read, or holds anything else than numbers.
    """
    check_file(path)
    try:
        with readable(path), path.open("rb") as stream, np.load(stream, allow_pickle=False) as found:
            return {name: np.asarray(found[name], dtype=np.float64) for name in found.files}
    except (ValueError, TypeError, AttributeError, EOFError, KeyError, zipfile.BadZipFile, zlib.error):
        problem = "it is damaged, or no file of arrays"
        raise InputError(path, problem, remedy="make the map again") from None


@by_name
def write_arrays(path: Path, arrays: Mapping[str, FloatArray]) -> None:
    """Write named arrays, compressed; the same arrays give the same bytes.

    Parameters
    ----------
    path : Path or str
        The file.
    arrays : mapping of str to ndarray
        The arrays.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **dict(arrays))  # type: ignore[arg-type]
    write_bytes(path, buffer.getvalue())
