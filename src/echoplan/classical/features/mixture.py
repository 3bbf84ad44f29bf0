"""Gaussian mixtures that grow with each point: IGMM (Engel and Heinen 2010; Heinen and Engel 2011; as recalled)."""

from dataclasses import dataclass

import numpy as np
from pydantic import Field

from echoplan.arrays import BoolArray, FloatArray, chosen_items
from echoplan.settings import Settings

__all__ = ["Mixture", "MixtureSettings", "learn"]


class MixtureSettings(Settings):
    """When a point is new, and how a component starts."""

    novelty: float = Field(
        default=0.01,
        gt=0.0,
        lt=1.0,
        description="Share of every component's peak below which the likelihood of a point starts a component, "
        "as recalled.",
    )
    sigma: float = Field(default=0.1, gt=0.0, description="Standard deviation of a new component [m].")
    min_sigma: float = Field(
        default=0.005, gt=0.0, description="Smallest standard deviation of a component [m]: a step of a module."
    )
    min_age: int = Field(
        default=30, ge=1, description="Number of points after which a component must reach the mass min_mass."
    )
    min_mass: float = Field(
        default=3.0, gt=0.0, description="Smallest number of points that a component explains after min_age points."
    )


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Mixture:
    """Gaussian components in the plane.

    Parameters
    ----------
    means_xy : ndarray, shape (k, 2)
        Their middles [m].
    covariances : ndarray, shape (k, 2, 2)
        Their shapes [m].
    masses : ndarray, shape (k,)
        How many points each explains: the accumulated posterior.
    ages : ndarray, shape (k,)
        How many points came since each was made, its own included.
    """

    means_xy: FloatArray
    covariances: FloatArray
    masses: FloatArray
    ages: FloatArray

    @classmethod
    def empty(cls) -> "Mixture":
        """Return a mixture of nothing."""
        return cls(means_xy=np.zeros((0, 2)), covariances=np.zeros((0, 2, 2)), masses=np.zeros(0), ages=np.zeros(0))

    def __len__(self) -> int:
        return len(self.masses)

    def __getitem__(self, chosen: BoolArray) -> "Mixture":
        """Return some of the components."""
        return chosen_items(self, chosen)

    def spread(self, *, spacing: float) -> tuple[FloatArray, FloatArray]:
        """Spread points along the long axes of the components.

        A wall patch of length L has the standard deviation ``L / sqrt(12)`` along itself, so that its points reach
        ``sqrt(3)`` of them to either side.

        Parameters
        ----------
        spacing : float
            Distance between the points of a component [m].

        Returns
        -------
        tuple of ndarray, shapes (n, 2) and (n,)
            Points [m] and weights; those of a component sum to its mass.
        """
        values, axes = np.linalg.eigh(self.covariances)
        points, weights = [np.zeros((0, 2))], [np.zeros(0)]
        for mean, sigma, axis, mass in zip(
            self.means_xy, np.sqrt(values[:, 1]), axes[:, :, 1], self.masses, strict=True
        ):
            reach = np.sqrt(3) * sigma
            steps = np.linspace(-reach, reach, 2 + int(2 * reach / spacing))
            points.append(mean + steps[:, None] * axis)
            weights.append(np.full(len(steps), mass / len(steps)))
        return np.concatenate(points), np.concatenate(weights)


def learn(mixture: Mixture, point_xy: FloatArray, settings: MixtureSettings) -> Mixture:
    """Let a mixture learn one point.

    A point that is novel to all components makes a new one.  A familiar one moves each component by its posterior
    w: with ``e = x - m`` and ``g = w / sum(w)``, the mean becomes ``m + g e`` and the covariance
    ``(1 - g) (C + g e e')``, which is the recursion of the weighted mean and covariance.

    Parameters
    ----------
    mixture : Mixture
        What was learnt so far.
    point_xy : ndarray, shape (2,)
        The point [m].
    settings : MixtureSettings
        What is novel.

    Returns
    -------
    Mixture
        With the point; without the components that proved spurious.
    """
    away = point_xy - mixture.means_xy
    shapes = mixture.covariances + settings.min_sigma**2 * np.eye(2)
    squares = np.einsum("ki,ki->k", away, np.linalg.solve(shapes, away[..., None])[..., 0])
    if not (np.exp(-squares / 2) >= settings.novelty).any():
        return _with_component(mixture, point_xy, settings)
    # Prior times density; the constant factor of the plane cancels.
    likelihoods = mixture.masses * np.exp(-squares / 2) / np.sqrt(np.linalg.det(shapes))
    posteriors = likelihoods / likelihoods.sum()
    masses, ages = mixture.masses + posteriors, mixture.ages + 1
    gains = posteriors / masses
    outer = away[:, :, None] * away[:, None, :]
    moved = Mixture(
        means_xy=mixture.means_xy + gains[:, None] * away,
        covariances=(1 - gains)[:, None, None] * (mixture.covariances + gains[:, None, None] * outer),
        masses=masses,
        ages=ages,
    )
    return moved[(ages < settings.min_age) | (masses >= settings.min_mass)]


def _with_component(mixture: Mixture, point_xy: FloatArray, settings: MixtureSettings) -> Mixture:
    return Mixture(
        means_xy=np.concatenate([mixture.means_xy, point_xy[None]]),
        covariances=np.concatenate([mixture.covariances, settings.sigma**2 * np.eye(2)[None]]),
        masses=np.append(mixture.masses, 1.0),
        ages=np.append(mixture.ages + 1, 1.0),
    )
