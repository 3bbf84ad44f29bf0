import numpy as np
import pytest

from echoplan.classical.features import Stack, fit_circle, fit_line
from echoplan.geometry import signed_distances
from helpers import scenes

HUBS = [(0.2, 0.1), (1.4, -0.3), (2.2, 0.4)]


def noisy(stack: Stack, rng: np.random.Generator) -> Stack:
    return Stack(
        hubs_xy=stack.hubs_xy,
        bearings=stack.bearings + rng.normal(0, stack.bearing_sigmas),
        distances=stack.distances + rng.normal(0, stack.distance_sigmas),
        bearing_sigmas=stack.bearing_sigmas,
        distance_sigmas=stack.distance_sigmas,
    )


@pytest.mark.parametrize("line", [(0.3, 4.0), (np.pi, 1.0), (-2.0, 3.0)])
def test_a_line_is_recovered_from_its_observations(line: tuple[float, float]) -> None:
    stack = Stack.of([scenes.observed_wall(line, hub) for hub in HUBS])
    fit = fit_line(stack)
    assert np.allclose(np.exp(1j * fit.parameters[0]), np.exp(1j * line[0]))
    assert fit.parameters[1] == pytest.approx(line[1])
    assert np.abs(fit.distance_residuals).max() < 1e-9


def test_one_sweep_alone_gives_a_line_by_its_normal() -> None:
    fit = fit_line(Stack.of([scenes.observed_wall((1.0, 2.0), (0.5, 0.5))]))
    assert fit.parameters == pytest.approx([1.0, 2.0])


def test_a_circle_comes_back_from_three_sides() -> None:
    circle = (1.0, 1.2, 0.15)
    fit = fit_circle(Stack.of([scenes.observed_circle(circle, hub) for hub in HUBS]), radius=0.1, radius_sigma=10.0)
    assert fit.parameters == pytest.approx(circle, abs=1e-6)


def test_from_one_side_the_radius_stays_what_was_expected() -> None:
    stack = Stack.of([scenes.observed_circle((2.0, 0.0, 0.3), (0.0, 0.0))])
    fit = fit_circle(stack, radius=0.1, radius_sigma=0.05)
    assert fit.parameters[2] == pytest.approx(0.1, abs=1e-6)
    assert np.sqrt(fit.covariance[2, 2]) == pytest.approx(0.05, rel=0.01)
    assert fit.parameters[0] == pytest.approx(1.8, abs=1e-6)


def test_the_stated_covariance_of_a_line_holds() -> None:
    rng = np.random.default_rng(3)
    line = np.array([0.3, 4.0])
    stack = Stack.of([scenes.observed_wall((0.3, 4.0), hub) for hub in HUBS])
    fits = [fit_line(noisy(stack, rng)) for _ in range(300)]
    errors = np.array([fit.parameters - line for fit in fits])
    squares = [error @ np.linalg.solve(fit.covariance, error) for error, fit in zip(errors, fits, strict=True)]
    assert np.mean(squares) == pytest.approx(2.0, rel=0.15)


def test_the_stated_covariance_of_a_circle_holds() -> None:
    rng = np.random.default_rng(4)
    circle = (1.0, 1.2, 0.15)
    stack = Stack.of([scenes.observed_circle(circle, hub) for hub in HUBS])
    fits = [fit_circle(noisy(stack, rng), radius=0.1, radius_sigma=10.0) for _ in range(300)]
    squares = [(fit.parameters - circle) @ np.linalg.solve(fit.covariance, fit.parameters - circle) for fit in fits]
    assert np.mean(squares) == pytest.approx(3.0, rel=0.15)


def test_hubs_lie_on_the_near_side_of_their_line() -> None:
    fit = fit_line(Stack.of([scenes.observed_wall((0.3, 4.0), hub) for hub in HUBS]))
    assert (signed_distances(fit.parameters, np.array(HUBS)) < 0).all()
