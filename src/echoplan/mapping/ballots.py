"""Ballots: voters that each name several cells, the cell named most, and votes taken back."""

import numpy as np

from echoplan.arrays import FloatArray, IntArray

__all__ = ["Ballot"]


class Ballot:
    """Weighted votes for cells of an accumulator (Hough 1962; Duda and Hart 1972).

    Parameters
    ----------
    cells : ndarray of int, shape (n, k)
        The cells that each of n voters names; one cell may occur once in a row.
    weights : ndarray, shape (n,)
        What the vote of each voter counts, not negative.

    Examples
    --------
    >>> ballot = Ballot(np.array([[0, 3], [1, 3], [0, 2]]), np.array([1.0, 1.0, 0.5]))
    >>> ballot.leader(), ballot.voters(3)
    ((3, 2.0), array([0, 1]))
    >>> ballot.withdraw(np.array([1]))
    >>> ballot.leader()
    (0, 1.5)
    """

    def __init__(self, cells: IntArray, weights: FloatArray) -> None:
        self._cells = cells
        self._weights = weights.copy()
        self._votes = self._count(np.arange(len(cells)), size=int(cells.max(initial=0)) + 1)
        self._by_cell = np.argsort(cells, axis=None, kind="stable")
        self._starts = np.searchsorted(cells.ravel()[self._by_cell], np.arange(len(self._votes) + 1))

    def leader(self) -> tuple[int, float]:
        """Find the cell with the most votes.

        Returns
        -------
        tuple of int and float
            The cell, the first one if several lead, and the weight of its votes.
        """
        cell = int(np.argmax(self._votes))
        return cell, float(self._votes[cell])

    def voters(self, cell: int) -> IntArray:
        """Tell who votes for a cell.

        Parameters
        ----------
        cell : int
            The cell.

        Returns
        -------
        ndarray of int, shape (v,)
            Those who name it and have not withdrawn, in order.
        """
        named: IntArray = self._by_cell[self._starts[cell] : self._starts[cell + 1]] // self._cells.shape[1]
        return named[self._weights[named] > 0]

    def withdraw(self, voters: IntArray) -> None:
        """Take votes back.

        Parameters
        ----------
        voters : ndarray of int
            Whose votes; those who did so before change nothing.
        """
        self._votes -= self._count(voters, size=len(self._votes))
        self._weights[voters] = 0.0

    def strike(self, cells: IntArray) -> None:
        """Take cells off the ballot: they lead no more.

        Parameters
        ----------
        cells : ndarray of int
            The cells.
        """
        self._votes[cells] = -np.inf

    def _count(self, voters: IntArray, *, size: int) -> FloatArray:
        named = self._cells[voters]
        weights = np.repeat(self._weights[voters], named.shape[1])
        return np.bincount(named.ravel(), weights=weights, minlength=size).astype(np.float64)
