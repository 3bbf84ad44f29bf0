"""Acceptance test: when the log-likelihood ratio of a landmark is enough."""

import math
from typing import ClassVar

import numpy as np
from pydantic import Field

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import BoolArray, FloatArray
from echoplan.geometry import wrap
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.proposals import ROUND_STATIONS
from echoplan.joint.search.ray_paths import unoccluded_stations
from echoplan.joint.trace import Reason
from echoplan.preprocessing.measurements import Measurements, step_of
from echoplan.settings import Settings

__all__ = ["AcceptanceSettings", "AcceptanceTest"]


# Least number of sectors of this size, as seen from its centre, in which a round wall must be detected [rad].
_SECTORS, _SECTOR = 6, math.radians(15.0)


class AcceptanceSettings(Settings):
    """Thresholds of the acceptance test."""

    former_keys: ClassVar = {
        "accept": "min_log_likelihood_ratio",
        "second_station": "min_second_station_llr",
        "without_best": "min_llr_without_best_station",
        "hit_share": "min_unmasked_detection_rate",
        "heard_share": "min_two_station_detection_rate",
        "seen_share": "min_one_station_detection_rate",
        "usual_share": "min_relative_detection_rate",
    }

    min_log_likelihood_ratio: float = Field(
        default=12.0, gt=0.0, description="Smallest log-likelihood ratio of a landmark that is accepted [nats]."
    )
    min_second_station_llr: float = Field(
        default=5.0, description="Smallest log-likelihood ratio from a station that supports a landmark [nats]."
    )
    # Smallest log-likelihood ratio of a landmark without its best station [nats].
    min_llr_without_best_station: ClassVar[float] = 6.0
    radius_cost: float = Field(default=2.0, ge=0.0, description="Penalty of the third parameter of a cylinder [nats].")
    # Smallest detection rate, among unmasked pings, of a wall that only one station supports.
    min_unmasked_detection_rate: ClassVar[float] = 0.75
    # Smallest detection rate, at its best station, of a landmark that only two stations support.
    min_two_station_detection_rate: ClassVar[float] = 0.4
    # Smallest detection rate, among all pings in its beam, of a wall that only one station supports.
    min_one_station_detection_rate: ClassVar[float] = 0.6
    # Smallest detection rate, over the median of all walls, of a wall that may be crosstalk.
    min_relative_detection_rate: ClassVar[float] = 0.9


class AcceptanceTest:
    """Acceptance test of landmarks; ``half_aperture`` is that of the sensors [rad]."""

    def __init__(self, measurements: Measurements, *, half_aperture: float, settings: AcceptanceSettings) -> None:
        self.settings = settings
        self.step = step_of(measurements)
        self._measurements = measurements
        self._half_aperture = half_aperture

    def penalised_llr(self, hypothesis: Hypothesis) -> float:
        """Return the log-likelihood ratio less the cost of a radius [nats]."""
        return hypothesis.llr - (self.settings.radius_cost if hypothesis.type.has_radius else 0.0)

    def is_accepted(self, hypothesis: Hypothesis, log_densities: FloatArray) -> bool:
        """Return True if a hypothesis passes all tests, given the log densities of all readings without it.

        Three stations that support it are enough; fewer must detect as much of it as they should, since two unexplained
        arcs share a tangent by chance, but three hardly do. A landmark with a track history only needs its
        log-likelihood ratio. A cylinder returns sound in all directions, so most stations with a free view must detect
        it.
        """
        return self.refusal(hypothesis, log_densities) is None

    def refusal(self, hypothesis: Hypothesis, log_densities: FloatArray) -> Reason | None:
        """Return the test that a hypothesis fails, given the log densities without it; None if it is accepted."""
        settings = self.settings
        if self.penalised_llr(hypothesis) <= settings.min_log_likelihood_ratio:
            return Reason.EVIDENCE
        if hypothesis.is_known:
            return None
        if not self._is_overdetermined(hypothesis, log_densities):
            return Reason.UNDERDETERMINED
        if self._is_missed(hypothesis):
            return Reason.MISSED
        if not hypothesis.has_credible_loss:
            return Reason.WEAKLY_DETECTED
        return self._lacks_stations(hypothesis, log_densities)

    def _lacks_stations(self, hypothesis: Hypothesis, log_densities: FloatArray) -> Reason | None:
        """Return the test of supporting stations that a hypothesis fails; None if they suffice."""
        if hypothesis.kind is Kind.ROUND:
            return None if self._is_round(hypothesis) else Reason.UNDERDETERMINED
        if self.has_single_station(hypothesis):
            is_whole = hypothesis.is_wall and self._is_whole(hypothesis, log_densities)
            return None if is_whole else Reason.SINGLE_STATION
        many = hypothesis.supporting(self.settings.min_second_station_llr) > 2
        return None if many or self._is_detected(hypothesis, log_densities) else Reason.WEAKLY_DETECTED

    def _is_round(self, wall: Hypothesis) -> bool:
        """Return True if a round wall was detected in enough directions: any three walls touch a circle."""
        supporting = wall.llr_by_station > self.settings.min_second_station_llr
        detected = (wall.ping_scores.densities > 0.0) & supporting[self._measurements.stations[wall.ping_scores.pings]]
        directions = np.unique(np.floor(wall.ping_scores.feet[detected] / _SECTOR))
        return bool(len(directions) >= _SECTORS and supporting.sum() >= ROUND_STATIONS)

    def has_single_station(self, hypothesis: Hypothesis) -> bool:
        """Return True if hardly more than one station supports a hypothesis."""
        supporting = hypothesis.supporting(self.settings.min_second_station_llr)
        return supporting < 2 or hypothesis.llr - hypothesis.best_llr <= self.settings.min_llr_without_best_station

    def detection_rate(self, hypothesis: Hypothesis, log_densities: FloatArray) -> float:
        """Return the share of pings that detect a landmark, of those of the best station that should."""
        return float(self._hits(hypothesis, log_densities).sum() / max(self._at_best_station(hypothesis).sum(), 1))

    def _is_detected(self, hypothesis: Hypothesis, log_densities: FloatArray) -> bool:
        """Return True if the best station detects enough of a landmark; of a wall, enough of what nothing known masks.

        Walls continue behind other objects; a cylinder that seems to be behind a wall is an image.
        """
        evidence = hypothesis.ping_scores
        hidden = hypothesis.is_wall & ~evidence.unmasked & (log_densities[evidence.pings] > 0.0)
        asked = (self._at_best_station(hypothesis) & ~hidden).sum()
        return bool(
            self._hits(hypothesis, log_densities).sum() >= self.settings.min_two_station_detection_rate * max(asked, 1)
        )

    def _hits(self, hypothesis: Hypothesis, log_densities: FloatArray) -> BoolArray:
        """Return which pings of the best station the hypothesis explains better than anything else, shape (m,)."""
        return hypothesis.newly_explained(log_densities) & self._at_best_station(hypothesis)

    def _is_overdetermined(self, hypothesis: Hypothesis, log_densities: FloatArray) -> bool:
        """Return True if more readings support a hypothesis than it has parameters: as many as these fit exactly."""
        supporting = (hypothesis.llr_by_station > 0.0)[self._measurements.stations[hypothesis.ping_scores.pings]]
        return bool((hypothesis.newly_explained(log_densities) & supporting).sum() > len(hypothesis.parameters))

    def _is_missed(self, hypothesis: Hypothesis) -> bool:
        """Return True if most stations that should detect a cylinder do not; pose errors may cause that for walls."""
        if not hypothesis.type.is_omnidirectional:
            return False
        clear = hypothesis.llr_by_station > self.settings.min_second_station_llr
        missing = unoccluded_stations(hypothesis, self._measurements, step=self.step) & ~clear
        return bool(missing.sum() > clear.sum())

    def _is_whole(self, wall: Hypothesis, log_densities: FloatArray) -> bool:
        """Return True if one station detected a wall over the whole beam."""
        if not len(wall.ping_scores.pings):
            return False
        here, detected = self._at_best_station(wall), self._hits(wall, log_densities)
        unmasked, hits = int((here & wall.ping_scores.unmasked).sum()), int(detected.sum())
        return bool(
            here.sum() >= self._half_aperture / self.step
            and self._ways(wall, detected) > len(wall.parameters)
            and hits >= self.settings.min_unmasked_detection_rate * max(unmasked, 1)
            and hits >= self.settings.min_one_station_detection_rate * here.sum()
        )

    def _ways(self, wall: Hypothesis, detected: BoolArray) -> int:
        """Count the directions from which a wall was detected; a second sweep of a ring repeats the same ones."""
        turns = wrap(self._measurements.bearings[wall.ping_scores.pings[detected]] - wall.line[0])
        return len(np.unique(np.round((turns - turns.min(initial=np.inf)) / self.step)))

    def _at_best_station(self, hypothesis: Hypothesis) -> BoolArray:
        """Return which pings are of the best station and should detect the landmark, shape (m,)."""
        evidence = hypothesis.ping_scores
        here: BoolArray = self._measurements.stations[evidence.pings] == np.argmax(hypothesis.llr_by_station)
        return here & evidence.audible
