from math import isnan

import numpy as np
import pytest
from scipy.spatial.distance import cdist, directed_hausdorff

from echoplan.errors import InvalidValueError
from echoplan.evaluation import Outline, map_error

NONE = np.zeros((0, 2))


@pytest.mark.parametrize("seed", range(3))
def test_the_error_is_barshans_sum_written_out(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points, reference = rng.normal(size=(40, 2)), rng.normal(size=(25, 2))
    distances = cdist(points, reference)
    error = map_error(points, reference)
    there, back = distances.min(axis=1), distances.min(axis=0)
    assert error.mean == pytest.approx((there.mean() + back.mean()) / 2)
    assert error.median == pytest.approx((np.median(there) + np.median(back)) / 2)
    wanted = max(directed_hausdorff(points, reference)[0], directed_hausdorff(reference, points)[0])
    assert error.hausdorff == pytest.approx(wanted)


def test_points_and_reference_may_change_places() -> None:
    rng = np.random.default_rng(7)
    points, reference = rng.normal(size=(10, 2)), rng.normal(size=(30, 2))
    assert map_error(points, reference).mean == pytest.approx(map_error(reference, points).mean)
    assert map_error(points, reference).map_to_truth == map_error(reference, points).truth_to_map


def test_what_is_missing_counts_as_what_is_too_much() -> None:
    wall = Outline(segments_xy=np.array([[[0.0, 0.0], [2.0, 0.0]]]), circles=np.zeros((0, 3))).samples(0.01)
    half = wall[wall[:, 0] < 1.0]
    assert map_error(wall, wall).mean == 0.0
    assert map_error(half, wall).map_to_truth.mean == 0.0
    # Half the wall is missing: on average half a metre from what is there.
    assert map_error(half, wall).mean == pytest.approx(0.25 * 0.5, abs=0.002)


def test_without_points_or_reference_the_error_is_unknown() -> None:
    for points, reference in ((NONE, np.zeros((3, 2))), (np.zeros((3, 2)), NONE), (NONE, NONE)):
        assert isnan(map_error(points, reference).mean)


def test_points_without_a_place_are_refused() -> None:
    with pytest.raises(InvalidValueError, match="reference_xy must be finite, not nan"):
        map_error(np.zeros((2, 2)), np.array([[0.0, np.nan]]))
