from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from echoplan.errors import InputError
from echoplan.io.pgm import read_pgm, write_pgm

PIXELS = np.array([[0, 10, 32], [205, 254, 255]], dtype=np.uint8)


def test_other_programs_see_the_same_picture(tmp_path: Path) -> None:
    write_pgm(tmp_path / "a.pgm", PIXELS)
    assert np.array_equal(np.asarray(Image.open(tmp_path / "a.pgm")), PIXELS)
    Image.fromarray(PIXELS).save(tmp_path / "b.pgm")
    assert np.array_equal(read_pgm(tmp_path / "b.pgm"), PIXELS)


def test_comments_of_other_programs_are_passed_over(tmp_path: Path) -> None:
    path = tmp_path / "map.pgm"
    path.write_bytes(b"P5\n# CREATOR: map_saver 0.050 m/pix\n3  2\n#\n255\n" + PIXELS.tobytes())
    assert np.array_equal(read_pgm(path), PIXELS)


def test_pixels_that_look_like_white_space_are_pixels(tmp_path: Path) -> None:
    pixels = np.array([[32, 10, 35, 32]], dtype=np.uint8)
    write_pgm(tmp_path / "map.pgm", pixels)
    assert np.array_equal(read_pgm(tmp_path / "map.pgm"), pixels)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"\x89PNG\r\n\x1a\n", r"it is no PGM: it begins with .*PNG.*; save it as a binary PGM"),
        (b"", "it is no PGM: it begins with b''"),
        (b"P2\n1 1\n255\n0\n", "head: it is of kind P2 with values up to 255; save it"),
        (b"P5\n1 1\n65535\n00", "head: it is of kind P5 with values up to 65535"),
        (b"P5\n3 2\n255\n12345", "pixels: 3 x 2 pixels are announced, 5 are there; write the file again"),
    ],
)
def test_what_is_no_picture_of_this_kind_is_refused_in_one_line(tmp_path: Path, data: bytes, message: str) -> None:
    path = tmp_path / "map.pgm"
    path.write_bytes(data)
    with pytest.raises(InputError, match=message):
        read_pgm(path)


def test_a_missing_picture_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no such file; check the name"):
        read_pgm(tmp_path / "map.pgm")


def test_a_head_with_thousands_of_digits_is_refused(tmp_path: Path) -> None:
    (tmp_path / "map.pgm").write_bytes(b"P5 " + b"9" * 5000 + b" 1 255 x")
    with pytest.raises(InputError, match="it is no PGM"):
        read_pgm(tmp_path / "map.pgm")
