"""Beliefs: what an extended Kalman filter knows, a Gaussian over blocks of variables that have names."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from echoplan.arrays import FloatArray, IntArray, checked_covariance, checked_floats, store

__all__ = ["Belief", "Innovation"]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Innovation:
    """What a measurement says that was not expected, linearised about a belief.

    Parameters
    ----------
    blocks : tuple of str
        Names of the blocks on which the expectation depends.
    residual : ndarray, shape (m,)
        Measured less expected.
    jacobian : ndarray, shape (m, k)
        Derivatives of the expectation by the k variables of those blocks, in that order.
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
class Belief:
    """A Gaussian over n variables in blocks that have names.

    Parameters
    ----------
    sizes : mapping of str to int
        How many variables each block has, in their order.
    mean : ndarray, shape (n,)
        Best guesses; units are the caller's.
    covariance : ndarray, shape (n, n)
        Of the variables, in the same order.
    """

    sizes: Mapping[str, int]
    mean: FloatArray
    covariance: FloatArray

    def __getitem__(self, block: str) -> FloatArray:
        """Return the mean of a block."""
        return self.mean[self._places([block])]

    def of(self, blocks: Sequence[str]) -> "Belief":
        """Forget all but some blocks.

        Parameters
        ----------
        blocks : sequence of str
            Which to keep, in the order wanted.

        Returns
        -------
        Belief
            The marginal over them.
        """
        kept = self._places(blocks)
        return Belief(
            sizes={block: self.sizes[block] for block in blocks},
            mean=self.mean[kept],
            covariance=self.covariance[np.ix_(kept, kept)],
        )

    def extended(
        self, block: str, values: FloatArray, *, given: Sequence[str], jacobian: FloatArray, noise: FloatArray
    ) -> "Belief":
        """Add a block that depends on those there are: ``y = f(x) + e``.

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
        Belief
            With the new block last.

        Examples
        --------
        >>> place = Belief(sizes={"a": 1}, mean=np.zeros(1), covariance=np.eye(1))
        >>> place.extended("b", np.ones(1), given=["a"], jacobian=np.eye(1), noise=np.eye(1)).covariance
        array([[1., 1.],
               [1., 2.]])
        """
        chosen = self._places(given)
        cross = jacobian @ self.covariance[chosen]
        own = cross[:, chosen] @ jacobian.T + noise
        return Belief(
            sizes={**self.sizes, block: len(values)},
            mean=np.concatenate([self.mean, values]),
            covariance=np.block([[self.covariance, cross.T], [cross, (own + own.T) / 2]]),
        )

    def squared_distance(self, innovation: Innovation) -> float:
        """Mahalanobis distance of a measurement from its expectation, squared.

        Parameters
        ----------
        innovation : Innovation
            The measurement.

        Returns
        -------
        float
            Distributed as chi squared with m degrees of freedom if the measurement is of what it is taken for.
        """
        return float(innovation.residual @ np.linalg.solve(self._spread(innovation), innovation.residual))

    def surprise(self, innovation: Innovation) -> float:
        """How unlikely a measurement is: minus twice the logarithm of its density.

        Parameters
        ----------
        innovation : Innovation
            The measurement.

        Returns
        -------
        float
            Comparable between explanations of the same measurement.
        """
        _, logarithm = np.linalg.slogdet(2 * np.pi * self._spread(innovation))
        return self.squared_distance(innovation) + float(logarithm)

    def corrected(self, innovation: Innovation) -> "Belief":
        """Learn from a measurement: the update of the extended Kalman filter, in Joseph's form.

        Parameters
        ----------
        innovation : Innovation
            The measurement.

        Returns
        -------
        Belief
            Over the same blocks, surer of them.

        Examples
        --------
        >>> place = Belief(sizes={"a": 1}, mean=np.zeros(1), covariance=np.eye(1))
        >>> seen = Innovation(blocks=("a",), residual=np.ones(1), jacobian=np.eye(1), noise=np.eye(1))
        >>> place.corrected(seen).mean, place.corrected(seen).covariance
        (array([0.5]), array([[0.5]]))
        """
        chosen = self._places(innovation.blocks)
        gain = np.linalg.solve(self._spread(innovation), innovation.jacobian @ self.covariance[chosen]).T
        rest = np.eye(len(self.mean))
        rest[:, chosen] -= gain @ innovation.jacobian
        covariance = rest @ self.covariance @ rest.T + gain @ innovation.noise @ gain.T
        return Belief(
            sizes=self.sizes,
            mean=self.mean + gain @ innovation.residual,
            covariance=(covariance + covariance.T) / 2,
        )

    def _spread(self, innovation: Innovation) -> FloatArray:
        """Covariance of the residual."""
        chosen = self._places(innovation.blocks)
        expected = innovation.jacobian @ self.covariance[np.ix_(chosen, chosen)] @ innovation.jacobian.T
        spread: FloatArray = expected + innovation.noise
        return spread

    def _places(self, blocks: Sequence[str]) -> IntArray:
        ends = dict(zip(self.sizes, np.cumsum(list(self.sizes.values())), strict=True))
        return np.concatenate([np.arange(ends[block] - self.sizes[block], ends[block]) for block in blocks])
