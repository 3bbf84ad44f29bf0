from pathlib import Path
from time import process_time

import numpy as np
import pytest

from echoplan.errors import InputError, OutputError
from echoplan.io import read_grid, write_grid
from echoplan.io.pgm import read_pgm, write_pgm
from echoplan.model import OccupancyGrid

VALUES = np.array([[0.9, 0.5, 0.1, 0.02], [0.66, 0.64, 0.2, 0.19], [1.0, 0.5, 0.5, 0.0]])
GRID = OccupancyGrid(origin_xy=np.array([-1.25, 2.5]), resolution=0.05, values=VALUES)
YAML = "image: map.pgm\nresolution: 0.05\norigin: [-1.25, 2.5, 0.0]\nnegate: 0\n"


def kept(folder: Path, text: str, pixels: object = ((0, 205, 254),)) -> Path:
    """A map as others may have written it."""
    write_pgm(folder / "map.pgm", np.array(pixels, dtype=np.uint8))
    (folder / "map.yaml").write_text(text, encoding="utf-8")
    return folder / "map.yaml"


def test_what_is_read_is_what_was_written_with_each_cell_where_it_was(tmp_path: Path) -> None:
    write_grid(tmp_path / "room.yaml", GRID)
    again = read_grid(tmp_path / "room.yaml")
    assert again.values.tolist() == [[1.0, 0.5, 0.0, 0.0], [1.0, 0.5, 0.5, 0.0], [1.0, 0.5, 0.5, 0.0]]
    assert again.origin_xy.tolist() == [-1.25, 2.5]
    assert again.resolution == 0.05
    write_grid(tmp_path / "again.yaml", again)
    assert read_grid(tmp_path / "again.yaml").values.tolist() == again.values.tolist()


def test_the_origin_is_written_without_the_dust_of_binary_numbers(tmp_path: Path) -> None:
    grid = OccupancyGrid(origin_xy=np.array([-96 * 0.05, 0.1 + 0.2]), resolution=0.05, values=VALUES)
    write_grid(tmp_path / "map.yaml", grid)
    assert "origin: [-4.8, 0.3, 0.0]" in (tmp_path / "map.yaml").read_text(encoding="utf-8")


def test_the_files_say_it_in_the_words_of_map_server(tmp_path: Path) -> None:
    write_grid(tmp_path / "room.yaml", GRID)
    assert (tmp_path / "room.yaml").read_text(encoding="utf-8") == (
        "image: room.pgm\nmode: trinary\nresolution: 0.05\norigin: [-1.25, 2.5, 0.0]\nnegate: 0\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    # Black is occupied, and the first row of a picture is the one with the greatest y.
    assert read_pgm(tmp_path / "room.pgm").tolist() == [[0, 205, 205, 254], [0, 205, 205, 254], [0, 205, 254, 254]]


def test_maps_of_other_programs_are_read_with_quotes_comments_and_without_what_has_a_default(tmp_path: Path) -> None:
    text = "---\n# by hand\nimage: 'map.pgm'  # beside it\nresolution: 5e-2\norigin: [-1.25,2.5, 0]\nvoxel: 3\n"
    grid = read_grid(kept(tmp_path, text))
    assert grid.values.tolist() == [[1.0, 0.5, 0.0]]
    assert grid.resolution == 0.05


@pytest.mark.parametrize(
    ("more", "pixels", "wanted"),
    [
        ("negate: 1\n", [[255, 100, 10]], [1.0, 0.5, 0.0]),
        ("negate: true\n", [[255, 100, 10]], [1.0, 0.5, 0.0]),
        ("occupied_thresh: 0.9\n", [[0, 50, 254]], [1.0, 0.5, 0.0]),
        ("mode: scale\n", [[0, 51, 255]], [1.0, 0.8, 0.0]),
        ("mode: raw\n", [[0, 70, 100, 255]], [0.0, 0.7, 1.0, 0.5]),
    ],
)
def test_every_mode_of_map_server_is_understood(
    tmp_path: Path, more: str, pixels: list[list[int]], wanted: list[float]
) -> None:
    assert read_grid(kept(tmp_path, YAML + more, pixels)).values[0] == pytest.approx(wanted)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("image: map.pgm\nresolution: 0.05\n", "map.yaml, origin: field required, not None; see"),
        (YAML.replace("0.05", "0"), "map.yaml, resolution: input should be greater than 0, not 0"),
        (YAML.replace("0.05", "fine"), "map.yaml, resolution: input should be a valid number.*, not 'fine'"),
        (YAML.replace("[-1.25, 2.5, 0.0]", "[1, 2]"), r"map.yaml, origin: list should have at least 3 items.*\[1, 2\]"),
        (YAML.replace("0.0]", "0.5]"), "map.yaml, origin: the map is turned by 0.5 rad; save it with a yaw of 0"),
        (YAML + "mode: blurred\n", "map.yaml, mode: input should be 'trinary', 'scale' or 'raw', not 'blurred'"),
        (YAML + "what is this\n", "map.yaml, line 5: 'what is this' is no entry of a map; write one entry a line"),
        (YAML.replace("map.pgm", "away.pgm"), "away.pgm: there is no such file"),
    ],
)
def test_a_fault_is_reported_with_its_place_and_the_remedy(tmp_path: Path, text: str, message: str) -> None:
    path = kept(tmp_path, text)
    with pytest.raises(InputError, match=message):
        read_grid(path)


def test_a_picture_without_a_pixel_is_no_map(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"map.pgm: it has no pixel"):
        read_grid(kept(tmp_path, YAML, np.zeros((0, 3))))


def test_a_map_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="it lies below a file, not a folder"):
        write_grid(tmp_path / "file" / "map.yaml", GRID)


@pytest.mark.parametrize(
    "text",
    [
        f"image: map.pgm\nresolution: {'1' * 60_000}x\n",
        f"image: a{' ' * 200_000}b\n",
        f"resolution: {'9' * 5000}\n",
        "image: \0\nresolution: 1\norigin: [0, 0, 0]\n",
        f"{' ' * 200_000}x\n",
        f"image{' #' * 200_000}",
    ],
    ids=["digits", "blanks", "number", "zero byte", "margin", "comments"],
)
def test_files_made_to_keep_a_reader_busy_are_refused_at_once(tmp_path: Path, text: str) -> None:
    path = kept(tmp_path, text)
    start = process_time()
    with pytest.raises(InputError) as caught:
        read_grid(path)
    assert process_time() - start < 1.0
    assert len(str(caught.value)) < 500


def test_only_a_mark_after_a_blank_begins_a_comment(tmp_path: Path) -> None:
    write_pgm(tmp_path / "map#1.pgm", np.array([[0]], dtype=np.uint8))
    (tmp_path / "map.yaml").write_text(YAML.replace("map.pgm", "map#1.pgm #2"), encoding="utf-8")
    assert read_grid(tmp_path / "map.yaml").values.tolist() == [[1.0]]
