"""AcceptanceTest: when a reflector is taken to be there."""

import numpy as np
from pydantic import BaseModel, Field

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import BoolArray, FloatArray
from echoplan.geometry import wrap
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.search.ray_paths import unoccluded_stations
from echoplan.joint.trace import Reason
from echoplan.preprocessing.measurements import Measurements, step_of

__all__ = ["AcceptanceSettings", "AcceptanceTest"]


class AcceptanceSettings(BaseModel, frozen=True, extra="forbid"):
    """When a reflector is believed."""

    accept: float = Field(default=12.0, gt=0.0, description="least gain in log likelihood [nats]")
    second_station: float = Field(default=5.0, description="least gain of the second best station [nats]")
    without_best: float = Field(default=6.0, description="least gain without the best station [nats]")
    radius_cost: float = Field(default=2.0, ge=0.0, description="cost of the third parameter of a cylinder [nats]")
    hit_share: float = Field(
        default=0.75, gt=0.0, description="of the unmasked pings that must hear a wall known from one station"
    )
    heard_share: float = Field(
        default=0.4, gt=0.0, description="of the pings of the best station that must hear what only two stations know"
    )
    seen_share: float = Field(default=0.6, gt=0.0, description="of all such pings")
    usual_share: float = Field(
        default=0.9, gt=0.0, description="of what is usual, that must hear such a wall where it may be a phantom"
    )


class AcceptanceTest:
    """Tells whether a reflector is believed.

    Parameters
    ----------
    measurements : Measurements
        The pings.
    half_aperture : float
        Of the sensors [rad].
    settings : AcceptanceSettings
        When it is.
    """

    def __init__(self, measurements: Measurements, *, half_aperture: float, settings: AcceptanceSettings) -> None:
        self.settings = settings
        self.step = step_of(measurements)
        self._measurements = measurements
        self._half_aperture = half_aperture

    def log_evidence_without_bias(self, hypothesis: Hypothesis) -> float:
        """Tell the gain less the cost of parameters.

        Parameters
        ----------
        hypothesis : Hypothesis
            What was judged.

        Returns
        -------
        float
            Its worth [nats].
        """
        return hypothesis.total - (self.settings.radius_cost if hypothesis.kind is Kind.CYLINDER else 0.0)

    def is_accepted(self, hypothesis: Hypothesis, log_densities: FloatArray) -> bool:
        """Whether a feature is believed: three stations speak for it, or fewer that heard as much of it as they should.

        Two arcs that nothing explains share some tangent by chance; three hardly do.  What was believed when all its
        stations were at hand stays believed until others speak against it.  A cylinder, which sends sound back all
        around, must be heard by most stations with a free view.

        Parameters
        ----------
        hypothesis : Hypothesis
            What was judged.
        log_densities : ndarray, shape (n,)
            What all others explain.

        Returns
        -------
        bool
            Whether it is.
        """
        return self.refusal(hypothesis, log_densities) is None

    def refusal(self, hypothesis: Hypothesis, log_densities: FloatArray) -> Reason | None:
        """Return the test that a hypothesis fails beside what all others explain, None if it is accepted."""
        settings = self.settings
        if self.log_evidence_without_bias(hypothesis) <= settings.accept:
            return Reason.EVIDENCE
        if hypothesis.is_known:
            return None
        if not self._is_overdetermined(hypothesis, log_densities):
            return Reason.UNDERDETERMINED
        if self._is_missed(hypothesis):
            return Reason.MISSED
        return self._lacks_stations(hypothesis, log_densities)

    def _lacks_stations(self, hypothesis: Hypothesis, log_densities: FloatArray) -> Reason | None:
        """Return the test of the stations that support a hypothesis that it fails, None if they suffice."""
        if self.has_single_station(hypothesis):
            is_whole = hypothesis.is_wall and self._is_whole(hypothesis, log_densities)
            return None if is_whole else Reason.SINGLE_STATION
        many = hypothesis.supporting(self.settings.second_station) > 2
        return None if many or self._is_detected(hypothesis, log_densities) else Reason.WEAKLY_DETECTED

    def has_single_station(self, hypothesis: Hypothesis) -> bool:
        """Whether hardly more than one station speaks for a reflector.

        Parameters
        ----------
        hypothesis : Hypothesis
            What was judged.

        Returns
        -------
        bool
            Whether it is so.
        """
        supporting = hypothesis.supporting(self.settings.second_station)
        return supporting < 2 or hypothesis.total - hypothesis.best <= self.settings.without_best

    def detection_rate(self, hypothesis: Hypothesis, log_densities: FloatArray) -> float:
        """Tell how fully the best station hears a reflector.

        Parameters
        ----------
        hypothesis : Hypothesis
            What was judged.
        log_densities : ndarray, shape (n,)
            What all others explain.

        Returns
        -------
        float
            Share of the pings that do, of those that could.
        """
        return float(self._hits(hypothesis, log_densities).sum() / max(self._at_best_station(hypothesis).sum(), 1))

    def _is_detected(self, hypothesis: Hypothesis, log_densities: FloatArray) -> bool:
        """Whether the best station hears a good part of a reflector; of a wall, of what nothing known hides.

        Walls go on behind other things; a cylinder that seems to stand behind a wall is an image in it.
        """
        evidence = hypothesis.ping_scores
        hidden = hypothesis.is_wall & ~evidence.unmasked & (log_densities[evidence.pings] > 0.0)
        asked = (self._at_best_station(hypothesis) & ~hidden).sum()
        return bool(self._hits(hypothesis, log_densities).sum() >= self.settings.heard_share * max(asked, 1))

    def _hits(self, hypothesis: Hypothesis, log_densities: FloatArray) -> BoolArray:
        """Tell which pings of the best station hear a reflector better than anything else."""
        return hypothesis.newly_explained(log_densities) & self._at_best_station(hypothesis)

    def _is_overdetermined(self, hypothesis: Hypothesis, log_densities: FloatArray) -> bool:
        """Whether more readings speak for a feature than it has parameters: through as many it can always be laid."""
        supporting = (hypothesis.llr_by_station > 0.0)[self._measurements.stations[hypothesis.ping_scores.pings]]
        return bool((hypothesis.newly_explained(log_densities) & supporting).sum() > len(hypothesis.parameters))

    def _is_missed(self, hypothesis: Hypothesis) -> bool:
        """Whether most stations that should hear a cylinder do not; walls may seem so while poses are in error."""
        if hypothesis.kind is not Kind.CYLINDER:
            return False
        clear = hypothesis.llr_by_station > self.settings.second_station
        missing = unoccluded_stations(hypothesis, self._measurements, step=self.step) & ~clear
        return bool(missing.sum() > clear.sum())

    def _is_whole(self, wall: Hypothesis, log_densities: FloatArray) -> bool:
        """Whether one station heard a wall all over the beam, as it should."""
        if not len(wall.ping_scores.pings):
            return False
        here, detected = self._at_best_station(wall), self._hits(wall, log_densities)
        unmasked, hits = int((here & wall.ping_scores.unmasked).sum()), int(detected.sum())
        return bool(
            here.sum() >= self._half_aperture / self.step
            and self._ways(wall, detected) > len(wall.parameters)
            and hits >= self.settings.hit_share * max(unmasked, 1)
            and hits >= self.settings.seen_share * here.sum()
        )

    def _ways(self, wall: Hypothesis, detected: BoolArray) -> int:
        """Count the directions from which a wall is heard: a second sweep of a ring from there says nothing new."""
        turns = wrap(self._measurements.bearings[wall.ping_scores.pings[detected]] - wall.line[0])
        return len(np.unique(np.round((turns - turns.min(initial=np.inf)) / self.step)))

    def _at_best_station(self, hypothesis: Hypothesis) -> BoolArray:
        evidence = hypothesis.ping_scores
        here: BoolArray = self._measurements.stations[evidence.pings] == np.argmax(hypothesis.llr_by_station)
        return here & evidence.audible
