"""The robust kernel is that of Geman and McClure (1985)."""

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.joint.optimisation.optimiser import geman_mcclure_variances

SIGMA, SCALE = 0.003, 2.5


def test_the_weight_is_the_derivative_of_the_kernel() -> None:
    residuals = SIGMA * np.linspace(0.1, 12.0, 50)
    squares = (residuals / SIGMA) ** 2

    def kernel(squares: FloatArray) -> FloatArray:
        cost: FloatArray = SCALE**2 * squares / (SCALE**2 + squares)
        return cost

    slopes = (kernel(squares + 1e-6) - kernel(squares - 1e-6)) / 2e-6
    weights = SIGMA**2 / geman_mcclure_variances(residuals, np.full(50, SIGMA**2), scale=SCALE)
    assert weights == pytest.approx(slopes, rel=1e-4, abs=1e-9)


def test_a_residual_of_one_scale_counts_a_quarter() -> None:
    inflated = geman_mcclure_variances(np.array([0.0, SCALE * SIGMA]), np.full(2, SIGMA**2), scale=SCALE)
    assert inflated / SIGMA**2 == pytest.approx([1.0, 4.0])


def test_outliers_have_a_bounded_cost() -> None:
    far = np.array([10.0, 100.0])
    pull = far / geman_mcclure_variances(far, np.full(2, SIGMA**2), scale=SCALE)
    assert pull[1] == pytest.approx(pull[0] / 1000.0, rel=1e-3)
