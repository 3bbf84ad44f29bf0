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
        self._weights = weights.copy()
        # Only cells that are named are kept, so that a stray point a mile away costs no memory.
        self._by_cell = np.argsort(cells, axis=None, kind="stable")
        ordered = cells.ravel()[self._by_cell]
        opens = np.diff(ordered, prepend=ordered[:1] - 1) != 0
        self._names, self._starts = ordered[opens], np.append(np.flatnonzero(opens), len(ordered))
        numbers = np.empty(cells.size, dtype=np.int64)
        numbers[self._by_cell] = np.cumsum(opens) - 1
        self._numbers: IntArray = numbers.reshape(cells.shape)
        self._votes = self._count(np.arange(len(cells)))

    def __len__(self) -> int:
        return len(self._names)

    def leader(self) -> tuple[int, float]:
        """Find the cell with the most votes.

        Returns
        -------
        tuple of int and float
            The cell, the first one if several lead, and the weight of its votes; 0 and no votes if nobody voted.
        """
        if not len(self._votes):
            return 0, 0.0
        number = int(np.argmax(self._votes))
        return int(self._names[number]), float(self._votes[number])

    def voters(self, cell: int) -> IntArray:
        """Return the voters of a cell.

        Parameters
        ----------
        cell : int
            A cell that was named.

        Returns
        -------
        ndarray of int, shape (v,)
            Those who name it and have not withdrawn, in order.
        """
        number = np.searchsorted(self._names, cell)
        named: IntArray = self._by_cell[self._starts[number] : self._starts[number + 1]] // self._numbers.shape[1]
        return named[self._weights[named] > 0]

    def withdraw(self, voters: IntArray) -> None:
        """Take votes back.

        Parameters
        ----------
        voters : ndarray of int
            Whose votes; those who did so before change nothing.
        """
        self._votes -= self._count(voters)
        self._weights[voters] = 0.0

    def strike(self, cells: IntArray) -> None:
        """Take cells off the ballot: they lead no more.

        Parameters
        ----------
        cells : ndarray of int
            Cells that were named.
        """
        self._votes[np.searchsorted(self._names, cells)] = -np.inf

    def _count(self, voters: IntArray) -> FloatArray:
        named = self._numbers[voters]
        weights = np.repeat(self._weights[voters], named.shape[1])
        return np.bincount(named.ravel(), weights=weights, minlength=len(self._names)).astype(np.float64)
