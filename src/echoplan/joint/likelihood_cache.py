"""Cache of ping likelihoods that estimates with the same pings, sonar and noise share."""

from collections import deque

from echoplan.acoustics.predicted_echo import EchoModel
from echoplan.joint.likelihood.ping_likelihood import PingLikelihood
from echoplan.preprocessing.measurements import Measurements

__all__ = ["LikelihoodCache"]

# Compared estimates alternate, so the last likelihood alone is not enough.
_LIKELIHOODS = 4


class LikelihoodCache:
    """The last few likelihoods; a cached one keeps the multipath echoes that it has computed."""

    def __init__(self) -> None:
        self._recent: deque[tuple[tuple[Measurements, EchoModel, float], PingLikelihood]] = deque(maxlen=_LIKELIHOODS)

    def of(self, measurements: Measurements, model: EchoModel, *, noise: float) -> PingLikelihood:
        """Return the likelihood of pings, from the cache if it was computed for these very objects."""
        inputs = (measurements, model, noise)
        for known, likelihood in self._recent:
            if all(one is other for one, other in zip(inputs, known, strict=True)):
                return likelihood
        before = self._recent[-1][1] if self._recent else None
        self._recent.append((inputs, PingLikelihood(measurements, model.tabulated(), noise, before=before)))
        return self._recent[-1][1]
