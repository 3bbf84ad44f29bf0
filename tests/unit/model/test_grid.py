import numpy as np
import pytest

from echoplan.errors import InvalidValueError
from echoplan.model import OccupancyGrid

VALUES = np.array([[0.0, 0.5, 1.0], [0.25, 0.5, 0.75]])


def grid(**changed: object) -> OccupancyGrid:
    given: dict[str, object] = {"origin_xy": [-1.0, 2.0], "resolution": 0.5, "values": VALUES}
    return OccupancyGrid(**(given | changed))  # type: ignore[arg-type]


def test_rows_go_up_and_columns_to_the_right() -> None:
    assert grid().centers_xy[0].tolist() == [[-0.75, 2.25], [-0.25, 2.25], [0.25, 2.25]]
    assert grid().centers_xy[1, 0].tolist() == [-0.75, 2.75]
    assert grid().size_xy.tolist() == [1.5, 1.0]


def test_each_centre_lies_in_its_own_cell() -> None:
    assert grid().cells_of(grid().centers_xy).tolist() == [[[0, 0], [0, 1], [0, 2]], [[1, 0], [1, 1], [1, 2]]]


def test_points_on_a_border_belong_above_and_right_of_it_and_points_beyond_have_no_cell() -> None:
    points = [[-1.0, 2.0], [-0.5, 2.5], [0.5, 2.2], [-1.01, 2.2], [0.0, 3.0]]
    assert grid().cells_of(points).tolist() == [[0, 0], [1, 1], [0, 3], [0, -1], [2, 2]]
    assert grid().contains(points).tolist() == [True, True, False, False, False]
    assert bool(grid().contains([0.0, 2.1])) is True


def test_a_grid_keeps_its_own_read_only_values() -> None:
    values = VALUES.copy()
    made = grid(values=values)
    values[0, 0] = 0.9
    assert made.values[0, 0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        made.values[0, 0] = 0.9


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"resolution": 0.0}, "resolution must be greater than 0, not 0"),
        ({"values": [[0.5, 1.1]]}, "values must be at most 1, not 1.1"),
        ({"values": [[0.5, -0.1]]}, "values must be at least 0, not -0.1"),
        ({"values": [[0.5, np.nan]]}, "values must be finite, not nan"),
        ({"values": np.zeros((0, 3))}, r"at least one cell, not shape \(0, 3\)"),
        ({"values": [0.5]}, r"values must have shape \(n, n\), not \(1,\)"),
        ({"origin_xy": [0.0, 0.0, 0.0]}, r"origin_xy must have shape \(2\)"),
    ],
)
def test_what_is_no_grid_is_refused(changed: dict[str, object], message: str) -> None:
    with pytest.raises(InvalidValueError, match=message):
        grid(**changed)
