import numpy as np
import pytest

import maps
from echoplan.evaluation.trajectory import compare_poses


def test_positions_and_headings_are_root_mean_squares() -> None:
    # True: (1, 1, 0) and (1, 2, 3).  Off by 3 and 4 cm, then by 12 cm; by 0.1 rad, then by -0.2 across the seam.
    poses = [[1.03, 1.04, 0.1], [1.0, 2.12, 2.8 - 2 * np.pi]]
    trajectory = compare_poses(maps.drawn(poses=poses), maps.ROOM)
    assert trajectory is not None
    assert trajectory.distances == pytest.approx([0.05, 0.12])
    assert trajectory.angles == pytest.approx([0.1, -0.2])
    assert trajectory.absolute_error == pytest.approx(np.sqrt((0.0025 + 0.0144) / 2))
    assert trajectory.heading_error == pytest.approx(np.sqrt(0.025))


@pytest.mark.parametrize("count", [0, 1, 3])
def test_poses_that_differ_in_number_are_not_compared(count: int) -> None:
    assert compare_poses(maps.drawn(poses=np.zeros((count, 3))), maps.ROOM) is None


def test_no_poses_are_not_compared_with_none() -> None:
    assert compare_poses(maps.drawn(), maps.NOWHERE) is None
