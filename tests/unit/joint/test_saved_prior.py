"""What of a prior is saved, and what is refused when it is read."""

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.errors import InvalidValueError
from echoplan.io import builtin_rig
from echoplan.joint.mapper import JointMapper
from echoplan.joint.marginal_prior import MarginalPrior
from echoplan.joint.saved_prior import arrays_of, prior_of_arrays
from echoplan.mapping import map_source


@pytest.fixture(scope="module")
def prior() -> MarginalPrior:
    """What is known of a square room."""
    known = map_source("sim:square,seed=1").known
    assert known is not None
    return known.prior


@pytest.fixture
def arrays(prior: MarginalPrior) -> dict[str, FloatArray]:
    """Its arrays."""
    return arrays_of(prior)


def test_what_is_read_is_what_was_written(arrays: dict[str, FloatArray]) -> None:
    again = arrays_of(prior_of_arrays(arrays))
    assert again.keys() == arrays.keys()
    for name, values in arrays.items():
        assert np.array_equal(again[name], values), name


def test_landmarks_are_saved_without_sonar_and_poses(prior: MarginalPrior, arrays: dict[str, FloatArray]) -> None:
    read = prior_of_arrays(arrays)
    landmarks = sum(len(each.parameters) for each in prior.features)
    assert len(read.summary.columns) == landmarks == len(prior.summary.columns)
    assert read.model is None
    assert not len(read.poses)


def test_a_path_of_two_recordings_keeps_its_gap(arrays: dict[str, FloatArray]) -> None:
    path = np.array([[0.0, 0.0], [1.0, 0.0], [np.nan, np.nan], [5.0, 5.0]])
    read = prior_of_arrays({**arrays, "path": path[[0, 1, 3]], "path_of": np.array([0.0, 0.0, 1.0])})
    assert np.array_equal(read.path_xy, path, equal_nan=True)


def test_a_prior_without_landmarks_is_saved() -> None:
    read = prior_of_arrays(arrays_of(MarginalPrior(noise=0.003, range_scale=0.01)))
    assert (len(read.features), read.noise, read.range_scale) == (0, 0.003, 0.01)


@pytest.mark.parametrize(
    "name", ["landmarks", "information", "line_log_ratios", "corner_echoes", "path_of", "histories", "feet_of"]
)
def test_arrays_that_do_not_fit_are_refused_by_name(arrays: dict[str, FloatArray], name: str) -> None:
    with pytest.raises(InvalidValueError, match=name):
        prior_of_arrays({**arrays, name: arrays[name][1:]} if name != "landmarks" else {**arrays, name: np.ones(3)})


def test_a_missing_array_is_named(arrays: dict[str, FloatArray]) -> None:
    with pytest.raises(InvalidValueError, match="extents is missing"):
        prior_of_arrays({name: each for name, each in arrays.items() if name != "extents"})


def test_an_unknown_kind_of_landmark_is_refused(arrays: dict[str, FloatArray]) -> None:
    landmarks = arrays["landmarks"].copy()
    landmarks[0, 0] = 99.0
    with pytest.raises(InvalidValueError, match="landmarks has a class"):
        prior_of_arrays({**arrays, "landmarks": landmarks})


def test_nothing_is_known_before_the_first_echo() -> None:
    assert JointMapper(builtin_rig("rotary-array")).prior() is None


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_what_is_no_information_matrix_is_refused(arrays: dict[str, FloatArray], sign: float) -> None:
    information = sign * arrays["information"]
    information[0, 1] += 0.1 * information[0, 0] * (sign > 0.0)
    with pytest.raises(InvalidValueError, match="information must be symmetric"):
        prior_of_arrays({**arrays, "information": information})
