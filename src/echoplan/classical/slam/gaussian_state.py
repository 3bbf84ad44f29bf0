"""State of an extended Kalman filter: mean and covariance of named blocks of variables."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from echoplan.arrays import FloatArray, IntArray, checked_covariance, checked_floats, store

__all__ = ["GaussianState", "Innovation"]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Innovation:
    """Measured minus predicted values, with the measurement model linearised about a state.

    Parameters
    ----------
    blocks : tuple of str
        Names of the blocks on which the prediction depends.
    residual : ndarray, shape (m,)
        Measured minus predicted.
    jacobian : ndarray, shape (m, k)
        Derivatives of the prediction by the k variables of those blocks, in that order.
    noise : ndarray, shape (m, m)
        Covariance of the measurement.
    """

    blocks: tuple[str, ...]
    residual: FloatArray
    jacobian: FloatArray
    noise: FloatArray

    def __post_init__(self) -> None:
        count = len(self.residual)
        store(
            self,
            residual=checked_floats(self.residual, name="residual", shape=(count,)),
            jacobian=checked_floats(self.jacobian, name="jacobian", shape=(count, None)),
            noise=checked_covariance(self.noise, name="noise", size=count),
        )


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class GaussianState:
    """A Gaussian over n variables in named blocks.

    Parameters
    ----------
    sizes : mapping of str to int
        Number of variables of each block, in their order.
    mean : ndarray, shape (n,)
        Estimates; the caller chooses the units.
    covariance : ndarray, shape (n, n)
        Their covariance, in the same order.
    """

    sizes: Mapping[str, int]
    mean: FloatArray
    covariance: FloatArray

    def __getitem__(self, block: str) -> FloatArray:
        """Return the mean of a block."""
        return self.mean[self._indices([block])]

    def marginal(self, blocks: Sequence[str]) -> "GaussianState":
        """Marginalise all blocks but some.

        Parameters
        ----------
        blocks : sequence of str
            Blocks to keep, in this order.

        Returns
        -------
        GaussianState
            The marginal distribution of those blocks.
        """
        kept = self._indices(blocks)
        return GaussianState(
            sizes={block: self.sizes[block] for block in blocks},
            mean=self.mean[kept],
            covariance=self.covariance[np.ix_(kept, kept)],
        )

    def extended(
        self, block: str, values: FloatArray, *, given: Sequence[str], jacobian: FloatArray, noise: FloatArray
    ) -> "GaussianState":
        """Augment the state with a block that depends on others: ``y = f(x) + e``.

        Parameters
        ----------
        block : str
            Name of the new block.
        values : ndarray, shape (m,)
            ``f`` of the mean.
        given : sequence of str
            The blocks on which ``f`` depends.
        jacobian : ndarray, shape (m, k)
            Derivatives of ``f`` by their k variables.
        noise : ndarray, shape (m, m)
            Covariance of ``e``.

        Returns
        -------
        GaussianState
            The state with the new block last.

        Examples
        --------
        >>> place = GaussianState(sizes={"a": 1}, mean=np.zeros(1), covariance=np.eye(1))
        >>> place.extended("b", np.ones(1), given=["a"], jacobian=np.eye(1), noise=np.eye(1)).covariance
        array([[1., 1.],
               [1., 2.]])
        """
        chosen = self._indices(given)
        cross = jacobian @ self.covariance[chosen]
        own = cross[:, chosen] @ jacobian.T + noise
        return GaussianState(
            sizes={**self.sizes, block: len(values)},
            mean=np.concatenate([self.mean, values]),
            covariance=np.block([[self.covariance, cross.T], [cross, (own + own.T) / 2]]),
        )

    def squared_distance(self, innovation: Innovation) -> float:
        """Squared Mahalanobis distance of a measurement from its prediction.

        Parameters
        ----------
        innovation : Innovation
            The measurement.

        Returns
        -------
        float
            Chi-squared with m degrees of freedom if the association is correct.
        """
        return float(
            innovation.residual @ np.linalg.solve(self._innovation_covariance(innovation), innovation.residual)
        )

    def deviance(self, innovation: Innovation) -> float:
        """Deviance of a measurement: minus twice the logarithm of its predictive density.

        Parameters
        ----------
        innovation : Innovation
            The measurement.

        Returns
        -------
        float
            Comparable between associations of the same measurement.
        """
        _, logarithm = np.linalg.slogdet(2 * np.pi * self._innovation_covariance(innovation))
        return self.squared_distance(innovation) + float(logarithm)

    def updated(self, innovation: Innovation) -> "GaussianState":
        """Update the state with a measurement, in Joseph's form of the extended Kalman filter.

        Parameters
        ----------
        innovation : Innovation
            The measurement.

        Returns
        -------
        GaussianState
            The posterior over the same blocks.

        Examples
        --------
        >>> place = GaussianState(sizes={"a": 1}, mean=np.zeros(1), covariance=np.eye(1))
        >>> seen = Innovation(blocks=("a",), residual=np.ones(1), jacobian=np.eye(1), noise=np.eye(1))
        >>> place.updated(seen).mean, place.updated(seen).covariance
        (array([0.5]), array([[0.5]]))
        """
        chosen = self._indices(innovation.blocks)
        gain = np.linalg.solve(self._innovation_covariance(innovation), innovation.jacobian @ self.covariance[chosen]).T
        rest = np.eye(len(self.mean))
        rest[:, chosen] -= gain @ innovation.jacobian
        covariance = rest @ self.covariance @ rest.T + gain @ innovation.noise @ gain.T
        return GaussianState(
            sizes=self.sizes,
            mean=self.mean + gain @ innovation.residual,
            covariance=(covariance + covariance.T) / 2,
        )

    def _innovation_covariance(self, innovation: Innovation) -> FloatArray:
        """Covariance of the residual, shape (m, m)."""
        chosen = self._indices(innovation.blocks)
        expected = innovation.jacobian @ self.covariance[np.ix_(chosen, chosen)] @ innovation.jacobian.T
        spread: FloatArray = expected + innovation.noise
        return spread

    def _indices(self, blocks: Sequence[str]) -> IntArray:
        ends = dict(zip(self.sizes, np.cumsum(list(self.sizes.values())), strict=True))
        return np.concatenate([np.arange(ends[block] - self.sizes[block], ends[block]) for block in blocks])
