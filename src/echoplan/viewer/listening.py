"""Echoes kept for pictures while sweeps pass by on their way to a mapper."""

from collections.abc import Iterable, Iterator

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.model import Pings, Rig, Sweep
from echoplan.preprocessing import echo_points, valid_pings

__all__ = ["EchoListener"]


class EchoListener:
    """Keeps echoes as points, evenly thinned so that a long recording takes no more room than a short one.

    Parameters
    ----------
    rig : Rig
        What makes the sweeps.
    most : int, optional
        More points than this would only blacken the picture.

    Examples
    --------
    >>> from echoplan.sources import open_source
    >>> source = open_source("sim:square")
    >>> listener = EchoListener(source.rig, most=100)
    >>> len(list(listener.listen(source)))
    5
    >>> len(listener.points_xy) <= 100
    True
    """

    def __init__(self, rig: Rig, *, most: int = 6000) -> None:
        self.rig = rig
        self.most = most
        self._stride = 1
        self._received = 0
        self._kept: list[FloatArray] = []

    @property
    def points_xy(self) -> FloatArray:
        """Points that the readings would mean if sound were a ray [m], shape (n, 2)."""
        return np.concatenate([np.zeros((0, 2)), *self._kept])

    def listen(self, sweeps: Iterable[Sweep]) -> Iterator[Sweep]:
        """Pass sweeps on and keep their echoes.

        Parameters
        ----------
        sweeps : iterable of Sweep
            The sweeps.

        Yields
        ------
        Sweep
            The same sweeps.
        """
        for sweep in sweeps:
            self._keep(echo_points(valid_pings(Pings.from_sweep(sweep, self.rig), self.rig)))
            yield sweep

    def _keep(self, points_xy: FloatArray) -> None:
        first = -self._received % self._stride
        self._received += len(points_xy)
        self._kept.append(points_xy[first :: self._stride])
        while sum(map(len, self._kept)) > self.most:
            self._stride *= 2
            self._kept = [self.points_xy[::2]]
