import numpy as np
import pytest

from echoplan.evaluation import IntervalErrors


def test_errors_have_a_mean_without_sign_and_a_bias_with_sign() -> None:
    errors = IntervalErrors(errors=np.array([0.03, -0.01]), sigmas=np.array([0.01, 0.01]))
    assert [errors.mean, errors.bias] == pytest.approx([0.02, 0.01])


def test_only_errors_with_an_interval_can_be_inside_one() -> None:
    errors = IntervalErrors(errors=np.array([0.5, 0.019, -0.020]), sigmas=np.array([np.nan, 0.01, 0.01]))
    assert errors.share_inside == 0.5
    assert np.isnan(IntervalErrors(errors=np.array([0.5]), sigmas=np.array([np.nan])).share_inside)


def test_errors_of_several_maps_add_up() -> None:
    one = IntervalErrors(errors=np.array([0.03]), sigmas=np.array([0.01]))
    both = one + IntervalErrors(errors=np.array([-0.01]), sigmas=np.array([0.01])) + IntervalErrors()
    assert both.errors.tolist() == [0.03, -0.01]
    assert both.share_inside == 0.5


def test_without_estimates_interval_errors_are_unknown() -> None:
    nothing = IntervalErrors()
    assert np.isnan([nothing.mean, nothing.bias, nothing.share_inside]).all()
