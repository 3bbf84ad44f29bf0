"""Outcome of a ping: detection, non-detection, or masked, which carries no information."""

import numpy as np
import pytest

from echoplan.joint.likelihood.ping_scores import detection_probability
from echoplan.joint.optimisation.hit_window import log_chance, outcome_of


@pytest.mark.parametrize(
    ("late", "outcome"),
    [(-0.5, 0.0), (-0.01, 1.0), (0.0, 1.0), (0.02, 1.0), (0.035, 0.0), (0.2, -1.0), (np.inf, -1.0), (-np.inf, 0.0)],
)
def test_readings_near_the_depth_are_detections_and_longer_ones_are_not(late: float, outcome: float) -> None:
    # The weakest echo reads one centimetre long.
    assert outcome_of(late, 0.01) == outcome


@pytest.mark.parametrize("excess", [-3.0, -1.0, 0.0, 2.0, 4.0])
def test_detection_and_non_detection_probabilities_are_symmetric(excess: float) -> None:
    detected, missed = np.exp(log_chance(excess)), np.exp(log_chance(-excess))
    assert detected == pytest.approx(detection_probability(excess))
    assert detected + missed == pytest.approx(1.0)


def test_detection_probabilities_are_bounded() -> None:
    assert np.exp([log_chance(-40.0), log_chance(40.0)]) == pytest.approx([0.03, 0.97])
