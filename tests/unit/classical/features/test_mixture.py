import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.classical.features.mixture import Mixture, MixtureSettings, learn

SETTINGS = MixtureSettings()


def taught(points: FloatArray, settings: MixtureSettings = SETTINGS) -> Mixture:
    mixture = Mixture.empty()
    for point in points:
        mixture = learn(mixture, point, settings)
    return mixture


def test_a_novel_point_makes_a_new_component() -> None:
    mixture = taught(np.array([[0.0, 0.0], [1.0, 0.0]]))
    assert mixture.means_xy.tolist() == [[0.0, 0.0], [1.0, 0.0]]
    assert mixture.covariances[1] == pytest.approx(SETTINGS.sigma**2 * np.eye(2))


def test_novelty_is_a_part_of_the_peak() -> None:
    reach = np.hypot(SETTINGS.sigma, SETTINGS.min_sigma) * np.sqrt(-2 * np.log(SETTINGS.novelty))
    assert len(taught(np.array([[0.0, 0.0], [0.999 * reach, 0.0]]))) == 1
    assert len(taught(np.array([[0.0, 0.0], [1.001 * reach, 0.0]]))) == 2


def test_a_familiar_point_moves_its_component() -> None:
    mixture = taught(np.array([[0.0, 0.0], [0.1, 0.0]]))
    assert mixture.means_xy[0] == pytest.approx([0.05, 0.0])
    assert mixture.masses.tolist() == [2.0]


def test_one_component_learns_mean_and_covariance_of_its_points() -> None:
    points = np.random.default_rng(3).normal([1.0, 2.0], [0.1, 0.05], size=(400, 2))
    mixture = taught(points, MixtureSettings(novelty=1e-9))
    assert len(mixture) == 1
    assert mixture.means_xy[0] == pytest.approx(points.mean(axis=0))
    prior = SETTINGS.sigma**2 * np.eye(2) / 400
    assert mixture.covariances[0] == pytest.approx(np.cov(points.T, bias=True) + prior, rel=1e-6)


def test_masses_count_the_points() -> None:
    points = np.random.default_rng(4).uniform(-1, 1, size=(300, 2))
    mixture = taught(points, MixtureSettings(min_mass=1e-6))
    assert mixture.masses.sum() == pytest.approx(300)


def test_a_component_that_explains_little_is_dropped_in_time() -> None:
    stray = np.concatenate([[[5.0, 5.0]], np.zeros((28, 2))])
    assert len(taught(stray)) == 2
    assert len(taught(np.concatenate([stray, np.zeros((1, 2))]))) == 1


def test_the_same_point_over_and_over_breaks_nothing() -> None:
    mixture = taught(np.ones((500, 2)))
    assert len(mixture) == 1
    assert np.isfinite(mixture.covariances).all()


def test_a_component_is_spread_along_itself_with_all_its_mass() -> None:
    wall = np.column_stack([np.linspace(-0.2, 0.2, 200), np.zeros(200)])
    mixture = taught(np.random.default_rng(5).permutation(wall), MixtureSettings(novelty=1e-9))
    points, weights = mixture.spread(spacing=0.05)
    assert weights.sum() == pytest.approx(200)
    assert np.abs(points[:, 1]).max() < 0.01
    assert [points[:, 0].min(), points[:, 0].max()] == pytest.approx([-0.2, 0.2], abs=0.01)
    assert np.diff(np.sort(points[:, 0])).max() <= 0.05


def test_an_empty_mixture_has_no_points() -> None:
    points, weights = Mixture.empty().spread(spacing=0.05)
    assert points.shape == (0, 2)
    assert len(weights) == 0
