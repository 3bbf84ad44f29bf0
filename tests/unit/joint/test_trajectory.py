import numpy as np
import pytest

from echoplan.joint.trajectory import Trajectory, joined

OPEN = {"first": 2, "last": 4, "direction": 0.1, "along": 0.2, "across": 0.01}


def part(first: int, count: int, *rows: dict[str, float], corrected: bool = True) -> Trajectory:
    sweeps = np.arange(first, first + count)
    covariances = np.tile(np.eye(3), (count, 1, 1)) if corrected else np.zeros((0, 3, 3))
    return Trajectory(sweeps, np.column_stack([sweeps, 0.0 * sweeps, 0.0 * sweeps]), covariances, rows)


def test_parts_of_a_trajectory_are_joined_in_order() -> None:
    whole = joined([part(0, 3), part(3, 2)])
    assert whole.sweeps.tolist() == [0, 1, 2, 3, 4]
    assert whole.poses[:, 0].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert whole.covariances.shape == (5, 3, 3)


def test_joined_fixed_poses_have_no_covariances() -> None:
    assert joined([part(0, 3, corrected=False), part(3, 2, corrected=False)]).covariances.shape == (0, 3, 3)


def test_fixed_poses_before_estimated_ones_have_zero_covariance() -> None:
    whole = joined([part(0, 3, corrected=False), part(3, 2)])
    assert not whole.covariances[:3].any()
    assert whole.covariances[3:].any()


def test_the_first_sweeps_keep_their_undetermined_runs() -> None:
    late = {**OPEN, "first": 6, "last": 7}
    kept = part(0, 9, OPEN, late).first(4)
    assert kept.sweeps.tolist() == [0, 1, 2, 3]
    assert len(kept.poses) == len(kept.covariances) == 4
    assert kept.undetermined == ({**OPEN, "last": 3},)
    assert part(0, 9, OPEN).first(0).undetermined == ()


@pytest.mark.parametrize(("starts", "count"), [(5, 1), (6, 2)])
def test_an_undetermined_run_across_a_border_is_joined(starts: int, count: int) -> None:
    worse = {**OPEN, "first": starts, "last": 8, "along": 0.5}
    whole = joined([part(0, 5, OPEN), part(5, 5, worse)])
    assert len(whole.undetermined) == count
    if count == 1:
        assert whole.undetermined == ({**worse, "first": 2},)
