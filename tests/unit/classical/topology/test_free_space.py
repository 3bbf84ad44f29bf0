"""What pings show to be free."""

import numpy as np
import pytest

from echoplan.classical.topology import FreeSpace, FreeSpaceSettings, find_free_space
from echoplan.errors import InvalidValueError
from echoplan.model import Pings
from helpers.scenes import around, pings, wall_ranges

BEARINGS = around(0.0, 0.5)
WALL = pings(BEARINGS, wall_ranges(BEARINGS, normal=0.0, distance=2.0), hub=(1.0, 0.5))
LENIENT = FreeSpaceSettings(min_votes=1)


def one_ping(reading: float) -> Pings:
    return pings(np.array([np.pi / 2]), np.array([reading]), arm=0.0)


def test_the_way_to_a_wall_is_free_and_what_is_behind_it_is_not() -> None:
    free = find_free_space([WALL])
    assert free.at([[1.2, 0.5], [2.3, 0.5]]).all()
    assert not free.at([[2.7, 0.5], [3.2, 0.5], [0.5, 0.5], [1.5, 2.0]]).any()


def test_free_is_a_share_of_the_range_to_a_cell() -> None:
    for share in (0.5, 0.9):
        free = find_free_space([one_ping(2.0)], LENIENT.model_copy(update={"free_fraction": share}))
        column = free.data[:, int(-free.origin_xy[0] / free.resolution)]
        high = free.origin_xy[1] + free.resolution * (np.flatnonzero(column)[-1] + 1)
        assert high == pytest.approx(2.0 * share, abs=0.1)


def test_a_room_is_free_where_it_was_observed_and_no_larger() -> None:
    corners = np.radians([0, 90, 180, 270])
    pings_by_sweep = [
        pings(around(normal, 0.6), wall_ranges(around(normal, 0.6), normal=normal, distance=1.5)) for normal in corners
    ]
    free = find_free_space(pings_by_sweep)
    assert 0.5 * (0.7 * 1.5) ** 2 * 4 * 1.2 < free.area < 3.0**2
    assert not free.data[[0, -1]].any()
    assert not free.data[:, [0, -1]].any()


def test_one_stray_reading_shows_nothing() -> None:
    clean, spoilt = find_free_space([WALL]), find_free_space([WALL, one_ping(2.5)])
    # Rays are a cell apart where they end, so near the sensor several cross a cell; far off one does.
    assert not spoilt.at([[0.0, 1.6]])[0]
    np.testing.assert_array_equal(clean.at([[1.8, 0.5]]), spoilt.at([[1.8, 0.5]]))


def test_the_place_of_the_robot_is_free_whatever_was_detected() -> None:
    free = find_free_space([one_ping(0.05)])
    assert free.at([[0.0, 0.0], [0.1, 0.0], [0.0, -0.1]]).all()
    assert free.area == pytest.approx(np.pi * 0.15**2, rel=0.35)


def test_many_pings_at_once_show_what_they_show_one_by_one() -> None:
    turns = np.linspace(0.0, 2 * np.pi, 1201)
    together = pings(turns, np.full(1201, 1.0))
    apart = [together[start : start + 7] for start in range(0, 1201, 7)]
    np.testing.assert_array_equal(find_free_space([together]).data, find_free_space(apart).data)


def test_without_echoes_there_is_no_free_space() -> None:
    free = find_free_space([WALL[:0]])
    assert free.area == 0.0
    assert not free.at([[0.0, 0.0]]).any()


def test_rows_are_y_and_columns_are_x() -> None:
    data = np.zeros((2, 3), dtype=np.bool_)
    data[1, 2] = True
    free = FreeSpace(origin_xy=np.array([10.0, 20.0]), resolution=0.5, data=data)
    assert free.centers(np.argwhere(data)).tolist() == [[11.25, 20.75]]
    assert free.at([[11.25, 20.75], [10.75, 20.75], [9.0, 20.0], [11.25, 21.2]]).tolist() == [True, False, False, False]


def test_a_grid_without_size_is_refused() -> None:
    with pytest.raises(InvalidValueError, match="resolution must be greater than 0"):
        FreeSpace(origin_xy=np.zeros(2), resolution=0.0, data=np.zeros((1, 1), dtype=np.bool_))


def test_pings_a_thousand_kilometres_apart_are_refused() -> None:
    far = pings(np.array([0.0]), np.array([2.0]), hub=(1e6, 1e6))
    with pytest.raises(InvalidValueError, match="max_cells = 16000000; check the poses"):
        find_free_space([WALL, far])
