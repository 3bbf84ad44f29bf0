"""A ping heard what it faced, missed it, or heard something nearer, which tells nothing."""

import numpy as np
import pytest

from echoplan.joint.likelihood.ping_scores import detection_probability
from echoplan.joint.optimisation.hit_window import log_chance, outcome_of


@pytest.mark.parametrize(
    ("late", "outcome"),
    [(-0.5, 0.0), (-0.01, 1.0), (0.0, 1.0), (0.02, 1.0), (0.035, 0.0), (0.2, -1.0), (np.inf, -1.0), (-np.inf, 0.0)],
)
def test_readings_about_the_depth_are_hits_and_later_ones_misses(late: float, outcome: float) -> None:
    # The faintest echo is read a centimetre too far.
    assert outcome_of(late, 0.01) == outcome


@pytest.mark.parametrize("excess", [-3.0, -1.0, 0.0, 2.0, 4.0])
def test_an_echo_is_missed_as_likely_as_one_as_far_below_the_threshold_is_heard(excess: float) -> None:
    detected, missed = np.exp(log_chance(excess)), np.exp(log_chance(-excess))
    assert detected == pytest.approx(detection_probability(excess))
    assert detected + missed == pytest.approx(1.0)


def test_no_ping_is_quite_sure() -> None:
    assert np.exp([log_chance(-40.0), log_chance(40.0)]) == pytest.approx([0.03, 0.97])
