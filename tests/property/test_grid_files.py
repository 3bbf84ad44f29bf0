"""Laws of kept grids: what was written is read, and what was read is written alike."""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from echoplan.arrays import FloatArray
from echoplan.io import read_grid, write_grid
from echoplan.io.pgm import read_pgm, write_pgm
from echoplan.model import OccupancyGrid

shapes = array_shapes(min_dims=2, max_dims=2, max_side=7)
pictures = arrays(np.uint8, shapes)
metres = st.floats(-1e4, 1e4).map(lambda value: round(value, 6))
grids = st.builds(
    lambda x, y, resolution, values: OccupancyGrid(origin_xy=np.array([x, y]), resolution=resolution, values=values),
    metres,
    metres,
    st.sampled_from([0.01, 0.025, 0.05, 0.1, 1.0]),
    arrays(np.float64, shapes, elements=st.floats(0.0, 1.0)),
)


@given(pictures)
def test_a_picture_is_read_as_it_was_written(pixels: np.ndarray[tuple[int, int], np.dtype[np.uint8]]) -> None:
    with TemporaryDirectory() as folder:
        write_pgm(Path(folder) / "map.pgm", pixels)
        assert np.array_equal(read_pgm(Path(folder) / "map.pgm"), pixels)


@given(grids)
def test_a_grid_keeps_its_place_and_what_is_occupied_free_and_unknown(grid: OccupancyGrid) -> None:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "map.yaml"
        write_grid(path, grid)
        again = read_grid(path)
        assert (again.resolution, again.origin_xy.tolist()) == (grid.resolution, grid.origin_xy.tolist())
        assert np.array_equal(again.values, verdicts(grid.values))
        write_grid(path, again)
        assert np.array_equal(read_grid(path).values, again.values)


def verdicts(values: FloatArray) -> FloatArray:
    """What map_server makes of probabilities."""
    return np.where(values > 0.65, 1.0, np.where(values < 0.196, 0.0, 0.5))
