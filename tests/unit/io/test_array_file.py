"""Arrays in files: what is read back, and what is refused."""

from pathlib import Path

import numpy as np
import pytest

from echoplan.errors import InputError
from echoplan.io import read_arrays, write_arrays


def test_arrays_are_read_as_they_were_written(tmp_path: Path) -> None:
    arrays = {"one": np.arange(6.0).reshape(2, 3), "none": np.zeros((0, 2))}
    write_arrays(tmp_path / "file.npz", arrays)
    read = read_arrays(tmp_path / "file.npz")
    assert read.keys() == arrays.keys()
    assert all(np.array_equal(read[name], values) for name, values in arrays.items())


def test_the_same_arrays_give_the_same_bytes(tmp_path: Path) -> None:
    for name in ("one.npz", "two.npz"):
        write_arrays(tmp_path / name, {"values": np.arange(4.0)})
    assert (tmp_path / "one.npz").read_bytes() == (tmp_path / "two.npz").read_bytes()


@pytest.mark.parametrize("damage", [b"", b"no archive", None, "text", "objects", "one array"])
def test_what_holds_no_arrays_is_refused(tmp_path: Path, damage: bytes | str | None) -> None:
    path = tmp_path / "file.npz"
    write_arrays(path, {"values": np.arange(1000.0)})
    if damage is None:
        path.write_bytes(path.read_bytes()[:-100])
    elif damage == "text":
        np.savez(path, values=np.array(["no number"]))
    elif damage == "objects":
        np.savez(path, values=np.array([{}], dtype=object))
    elif damage == "one array":
        with path.open("wb") as stream:
            np.save(stream, np.arange(3.0))
    elif isinstance(damage, bytes):
        path.write_bytes(damage)
    with pytest.raises(InputError, match="it is damaged, or no file of arrays; make the map again"):
        read_arrays(path)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"file\.npz"):
        read_arrays(tmp_path / "file.npz")
