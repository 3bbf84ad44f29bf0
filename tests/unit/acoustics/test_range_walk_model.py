import numpy as np
import pytest

from echoplan.acoustics.detection import crossing_delay, peak_delay
from echoplan.acoustics.range_walk_model import EXCESS_STEP, WalkCurve, fitted_walk, physical_walk
from echoplan.arrays import FloatArray
from echoplan.errors import InvalidValueError
from echoplan.model import Transducer
from helpers.simulated_worlds import PAPER

GRID = EXCESS_STEP * np.arange(1401)


def scattered(count: int, *, seed: int = 0) -> tuple[FloatArray, FloatArray, WalkCurve]:
    """Excesses, residuals of a walk of 25 mm with a noise of 1 mm, and the curve behind them."""
    rng = np.random.default_rng(seed)
    truth = physical_walk(PAPER)
    excess = rng.uniform(0.0, 30.0, count)
    return excess, 0.025 * truth(excess) + rng.normal(0.0, 0.001, count), truth


def test_a_table_is_straight_between_its_points_and_scaled_from_one_to_nought() -> None:
    curve = WalkCurve.from_table([0.0, 10.0, 40.0], [35.0, 15.0, 5.0])
    assert curve([0.0, 5.0, 10.0, 25.0, 40.0]) == pytest.approx([1.0, 2 / 3, 1 / 3, 1 / 6, 0.0])


def test_a_table_is_level_beyond_its_points() -> None:
    curve = WalkCurve.from_table([3.0, 10.0], [2.0, 1.0])
    assert curve([0.0, 2.9, 11.0, 70.0]) == pytest.approx([1.0, 1.0, 0.0, 0.0])


def test_below_the_threshold_and_above_the_grid_a_curve_stays_what_it_is_at_its_ends() -> None:
    curve = physical_walk(PAPER)
    assert curve([-20.0, 0.0]) == pytest.approx(1.0)
    assert curve([70.0, 200.0]).tolist() == [curve.values[-1]] * 2


@pytest.mark.parametrize(
    ("excess", "values"),
    [([0.0, 0.0], [2.0, 1.0]), ([5.0, 1.0], [2.0, 1.0]), ([0.0, 5.0], [1.0, 1.0]), ([0.0, 5.0], [1.0, 2.0])],
)
def test_a_table_out_of_order_or_without_a_fall_is_refused(excess: list[float], values: list[float]) -> None:
    with pytest.raises(InvalidValueError, match="increasing excesses and falling values"):
        WalkCurve.from_table(excess, values)


def test_a_table_that_rises_on_the_way_is_refused() -> None:
    with pytest.raises(InvalidValueError, match="must not rise"):
        WalkCurve.from_table([0.0, 10.0, 20.0], [3.0, 1.0, 2.0])


def test_a_table_of_columns_that_differ_in_length_is_refused() -> None:
    with pytest.raises(InvalidValueError, match="values"):
        WalkCurve.from_table([0.0, 10.0, 20.0], [3.0, 1.0])


def test_a_curve_of_another_grid_is_refused() -> None:
    with pytest.raises(InvalidValueError, match="values"):
        WalkCurve(values=np.linspace(1.0, 0.0, 1400))


def test_the_values_of_a_curve_cannot_be_changed() -> None:
    with pytest.raises(ValueError, match="read-only"):
        physical_walk(PAPER).values[0] = 2.0


@pytest.mark.parametrize("transducer", [PAPER, Transducer(), Transducer(burst_cycles=16)])
def test_the_physical_walk_is_the_delay_of_the_threshold_over_that_of_the_peak(transducer: Transducer) -> None:
    curve, shares = physical_walk(transducer), crossing_delay(GRID, transducer) / peak_delay(transducer)
    assert curve.values == pytest.approx(shares, abs=1e-9)
    assert curve.values[0] == pytest.approx(1.0)
    assert 0.0 < curve.values[-1] < 0.02
    assert (np.diff(curve.values) <= 0.0).all()


def test_the_physical_walk_is_steepest_at_the_threshold() -> None:
    falls = -np.diff(physical_walk(PAPER)([0.0, 3.0, 6.0, 12.0, 24.0])) / [3.0, 3.0, 6.0, 12.0]
    assert (np.diff(falls) < 0.0).all()


@pytest.mark.parametrize("excess", [0.0, 0.2, 1.0, 6.0, 40.0])
def test_the_walk_of_detected_echoes_is_a_mean_above_the_threshold(excess: float) -> None:
    curve, excess_scale = physical_walk(PAPER), 0.3
    excesses = excess + np.random.default_rng(3).logistic(0.0, excess_scale, 200_000)
    walks = curve(excesses[excesses > 0.0])
    assert curve.blurred(excess_scale)(excess) == pytest.approx(walks.mean(), abs=2e-3)
    assert curve.sigma_from_excess(excess, excess_scale) == pytest.approx(walks.std(), abs=3e-3)


def test_what_is_known_exactly_scatters_no_more() -> None:
    curve = physical_walk(PAPER)
    assert curve.blurred(0.0)(GRID).tolist() == curve(GRID).tolist()
    assert not curve.sigma_from_excess(GRID, 0.0).any()


def test_the_fainter_an_echo_the_more_its_walk_scatters() -> None:
    assert np.all(np.diff(physical_walk(PAPER).sigma_from_excess([0.0, 1.0, 2.0, 4.0, 8.0, 16.0], 0.3)) < 0.0)


def test_a_fit_follows_the_walk_behind_a_recording() -> None:
    excess, residuals, truth = scattered(4000)
    curve, fall = fitted_walk(excess, residuals, weights=np.ones(len(excess)))
    # Of the first and the last piece, only the medians are known.
    assert fall == pytest.approx(0.025 * (truth(0.6) - truth(29.4)), rel=0.05)
    middle = np.linspace(3.0, 27.0, 25)
    # A fitted curve runs from 1 to 0 over what was detected, so both are compared with their own fall.
    shape, fitted = ((each(middle) - each(27.0)) / (each(3.0) - each(27.0)) for each in (truth, curve))
    assert fitted == pytest.approx(shape, abs=0.03)


def test_a_fit_never_rises_even_where_the_recording_does() -> None:
    excess = np.repeat([1.0, 5.0, 9.0, 13.0], 10)
    residuals = np.repeat([0.03, 0.01, 0.02, 0.0], 10)
    curve, fall = fitted_walk(excess, residuals, weights=np.ones(40), pieces=4)
    assert fall == pytest.approx(0.03)
    assert curve([1.0, 5.0, 7.0, 9.0, 13.0]) == pytest.approx([1.0, 0.5, 0.5, 0.5, 0.0])


def test_a_few_strays_do_not_bend_a_fit() -> None:
    excess, residuals, _ = scattered(800)
    clean, _ = fitted_walk(excess, residuals, weights=np.ones(800), pieces=8)
    strays = np.random.default_rng(1).choice(800, 60, replace=False)
    residuals[strays] += 1.0
    bent, _ = fitted_walk(excess, residuals, weights=np.ones(800), pieces=8)
    assert bent.values == pytest.approx(clean.values, abs=0.08)


def test_a_ping_without_weight_does_not_count_in_a_fit() -> None:
    excess = np.array([1.0, 1.0, 1.0, 9.0, 9.0, 9.0, 20.0, 20.0, 20.0])
    residuals = np.array([0.03, 0.03, 9.0, 0.01, 0.01, -9.0, 0.0, 0.0, 5.0])
    weights = np.array([1.0, 1.0, 0.0] * 3)
    curve, _ = fitted_walk(excess, residuals, weights=weights, pieces=3)
    assert curve([1.0, 9.0, 20.0]) == pytest.approx([1.0, 1 / 3, 0.0])


def test_residuals_that_rise_with_the_excess_are_refused() -> None:
    excess = np.linspace(0.0, 30.0, 64)
    with pytest.raises(InvalidValueError, match="falling values"):
        fitted_walk(excess, 0.001 * excess, weights=np.ones(64))
