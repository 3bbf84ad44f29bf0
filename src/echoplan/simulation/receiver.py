"""Receivers of the simulator: echoes at each, and when they cross the threshold."""

from dataclasses import dataclass

import numpy as np

from echoplan.arrays import FloatArray, IntArray
from echoplan.simulation.detector import Detector, Echoes
from echoplan.simulation.stage import Stage

__all__ = ["ReceiverSimulation"]

# Rounding of an instant is less than this [s].
_MOMENT = 1e-6


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class ReceiverSimulation:
    """The receivers: they turn the echoes of each ping into threshold crossings.

    Parameters
    ----------
    stage : Stage
        What stands around, transducer and air, all pings.
    detector : Detector
        What trips.
    """

    stage: Stage
    detector: Detector

    def instants(self, pings: IntArray) -> FloatArray:
        """Find when pings first reach their thresholds, after their own bursts.

        What arrives later than that changes nothing.  So the loudest paths, which are the cheapest, are traced first,
        and the others only as far as they can matter.

        Parameters
        ----------
        pings : ndarray of int, shape (n,)
            Which pings.

        Returns
        -------
        ndarray, shape (n,)
            Instants [s]; ``-inf`` if the threshold is exceeded when listening begins, ``inf`` if it never is.
        """
        openings, until = self.stage.shots.openings[pings], self.stage.shots.deadlines[pings]
        enough = np.clip(self._crossings(_alone(self.stage), pings, until) + _MOMENT, openings, until)
        instants = self._crossings(self.stage, pings, enough)
        unsettled = (instants == np.inf) & (enough < until)
        instants[unsettled] = self._crossings(self.stage, pings[unsettled], until[unsettled])
        return instants

    def detected_alone(self, pings: IntArray) -> IntArray:
        """Find the reflectors each of which, all by itself, would answer at least one of some pings.

        Parameters
        ----------
        pings : ndarray of int, shape (n,)
            Which pings.

        Returns
        -------
        ndarray of int
            Faces, and cylinders counted on behind them, each once.
        """
        from echoplan.simulation.echoes import find_echoes  # noqa: PLC0415 - numba is slow to import
        from echoplan.simulation.threshold import first_crossings  # noqa: PLC0415 - as above

        shots = self.stage.shots
        echoes = find_echoes(_alone(self.stage), pings, shots.deadlines[pings])
        listeners = np.repeat(pings, np.diff(echoes.bounds))
        each = echoes._replace(bounds=np.arange(len(echoes.times) + 1))
        instants = first_crossings(self.detector, each, shots.openings[listeners], shots.deadlines[listeners])
        return np.unique(echoes.reflectors[np.isfinite(instants)])

    def _crossings(self, stage: Stage, pings: IntArray, deadlines: FloatArray) -> FloatArray:
        from echoplan.simulation.echoes import find_echoes  # noqa: PLC0415 - numba is slow to import
        from echoplan.simulation.threshold import first_crossings  # noqa: PLC0415 - as above

        echoes = find_echoes(stage, pings, deadlines)
        listeners = np.repeat(np.arange(len(echoes.bounds) - 1), np.diff(echoes.bounds))
        order = np.lexsort((echoes.times, listeners))
        ordered = Echoes(echoes.times[order], echoes.strengths[order], echoes.reflectors[order], echoes.bounds)
        return first_crossings(self.detector, ordered, stage.shots.openings[pings], deadlines)


def _alone(stage: Stage) -> Stage:
    # Every ping receives its own burst, reflected once.
    pings = np.arange(len(stage.shots.instants))
    return Stage(
        scene=stage.scene,
        sonar=stage.sonar._replace(order=min(stage.sonar.order, 1), diffraction=False),
        shots=stage.shots._replace(first_burst=pings, last_burst=pings + 1),
    )
