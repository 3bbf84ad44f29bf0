import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.errors import InvalidValueError
from echoplan.joint.optimisation.factors import InformationPrior, LinearFactor, normal_equations, prior
from echoplan.joint.optimisation.solver import solve

SIZE = 7


def some_rows(count: int, width: int, *, seed: int) -> LinearFactor:
    """Return random factors with some unused columns."""
    rng = np.random.default_rng(seed)
    columns = np.array([rng.permutation(SIZE)[:width] for _ in range(count)])
    columns[rng.random(columns.shape) < 0.3] = -1
    jacobian = rng.normal(size=(count, width))
    return LinearFactor(columns, jacobian, rng.normal(size=count), rng.uniform(0.1, 3.0, size=count))


def dense(rows: LinearFactor) -> FloatArray:
    """Return the dense Jacobian."""
    jacobian = np.zeros((len(rows.residuals), SIZE))
    for row, (columns, derivatives) in enumerate(zip(rows.columns, rows.jacobian, strict=True)):
        for column, derivative in zip(columns, derivatives, strict=True):
            if column >= 0:
                jacobian[row, column] += derivative
    return jacobian


def well_posed(size: int) -> tuple[FloatArray, FloatArray]:
    """Return the normal equations of a chain of variables, the first of which has a prior."""
    count = np.arange(size - 1)
    steps = np.column_stack([np.full(size - 1, -1.0), np.ones(size - 1)])
    chain = LinearFactor(np.column_stack([count, count + 1]), steps, np.full(size - 1, 0.5), np.ones(size - 1))
    return normal_equations([prior(0, sigma=0.1, residual=1.0), chain], size)


def test_normal_equations_equal_those_of_the_dense_jacobian() -> None:
    parts = [some_rows(20, 3, seed=1), some_rows(5, 6, seed=2)]
    information, right = normal_equations(parts, SIZE)
    jacobian = np.concatenate([dense(each) for each in parts])
    weights = np.concatenate([each.weights for each in parts])
    residuals = np.concatenate([each.residuals for each in parts])
    assert information == pytest.approx(jacobian.T @ (weights[:, None] * jacobian))
    assert right == pytest.approx(jacobian.T @ (weights * residuals))


def test_a_repeated_column_adds_both_derivatives() -> None:
    rows = LinearFactor(np.array([[2, 2]]), np.array([[1.0, 3.0]]), np.array([2.0]), np.array([1.0]))
    information, right = normal_equations([rows], 3)
    assert information[2, 2] == 16.0
    assert right.tolist() == [0.0, 0.0, 8.0]


def test_no_factors_give_zero_information() -> None:
    information, right = normal_equations([], 3)
    assert not information.any()
    assert not right.any()


def test_a_single_prior_determines_its_variable() -> None:
    information, right = normal_equations([prior(0, sigma=0.3, residual=-2.0)], 1)
    assert solve(information, right) == pytest.approx([-2.0])
    assert solve(information, np.eye(1)) == pytest.approx(np.array([[0.09]]))


def test_two_priors_give_their_weighted_mean() -> None:
    parts = [prior(0, sigma=1.0, residual=0.0), prior(0, sigma=0.5, residual=1.0)]
    assert solve(*normal_equations(parts, 1)) == pytest.approx([0.8])


def test_large_systems_are_solved_like_small_ones() -> None:
    for size in (40, 400):
        information, right = well_posed(size)
        assert solve(information, right) == pytest.approx(1.0 + 0.5 * np.arange(size))


def test_many_right_hand_sides_give_the_inverse() -> None:
    for size in (40, 400):
        information, _ = well_posed(size)
        inverse = solve(information, np.eye(size))
        assert inverse @ information == pytest.approx(np.eye(size), abs=1e-6)
        assert inverse[0, 0] == pytest.approx(0.01)


@pytest.mark.parametrize("size", [40, 400])
def test_an_undetermined_variable_is_an_error(size: int) -> None:
    information, right = well_posed(size)
    information[size // 2], information[:, size // 2] = 0.0, 0.0
    with pytest.raises(InvalidValueError, match="undetermined"):
        solve(information, right)


def summary() -> InformationPrior:
    information, vector = well_posed(5)
    return InformationPrior(np.arange(5), information, vector)


@pytest.mark.parametrize("kept", [[0], [1, 3], [4, 0, 2], [0, 1, 2, 3, 4]])
def test_marginalisation_keeps_values_and_covariance(kept: list[int]) -> None:
    whole, part = summary(), summary().marginalised_onto(np.array(kept))
    covariance = np.linalg.inv(whole.information)
    assert np.linalg.inv(part.information) == pytest.approx(covariance[np.ix_(kept, kept)], rel=1e-6)
    values = np.linalg.solve(part.information, part.vector)
    assert values == pytest.approx((covariance @ whole.vector)[kept], rel=1e-6)
    assert part.columns.tolist() == kept


def test_keeping_all_changes_nothing() -> None:
    whole = summary()
    assert whole.marginalised_onto(np.arange(5)) is whole


def test_variables_without_information_can_be_marginalised() -> None:
    blind = InformationPrior(np.arange(2), np.diag([4.0, 0.0]), np.array([8.0, 0.0]))
    part = blind.marginalised_onto(np.array([0]))
    assert part.information.tolist() == [[4.0]]
    assert part.vector.tolist() == [8.0]


def test_considered_variables_have_their_own_prior_and_the_others_given_them_are_as_before() -> None:
    whole, places, rest = summary(), np.array([1, 4]), np.array([0, 2, 3])
    means, variances = np.array([0.5, -2.0]), np.array([0.25, 0.04])
    after = whole.considered(places, means, 1.0 / variances)
    covariance = np.linalg.inv(after.information)
    assert covariance[np.ix_(places, places)] == pytest.approx(np.diag(variances), abs=1e-6)
    assert (covariance @ after.vector)[places] == pytest.approx(means, abs=1e-6)
    assert np.array_equal(after.information[rest], whole.information[rest])
    assert np.array_equal(after.vector[rest], whole.vector[rest])
