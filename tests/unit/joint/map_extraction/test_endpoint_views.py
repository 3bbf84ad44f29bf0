import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.joint.likelihood.track_history import LineEvidence
from echoplan.joint.map_extraction.endpoint_views import OFFSETS, line_evidence
from echoplan.preprocessing.measurements import Measurements
from helpers.expectations import likelihood, listening, pings_of, rescored, wall

EAST = wall(0.0, 1.0)
BEFORE = listening([(0.0, 0.3)])
PAST_END = int(np.argmin(np.abs(OFFSETS - 0.3)))


def evidence_and_ratio(measurements: Measurements) -> tuple[LineEvidence, float]:
    """Return the line evidence of x = 1, and the log-likelihood ratio of a wall without ends [nats]."""
    estimate = likelihood(measurements)
    (east,) = rescored(estimate, [EAST])
    log_densities, evidence = np.full(len(measurements.readings), estimate.floor), east.ping_scores
    ratios = np.maximum(evidence.densities - log_densities[evidence.pings], 0.0) + evidence.misses
    whole = float((measurements.weights[evidence.pings] * ratios).sum())
    return line_evidence(estimate, east, len(measurements.centers), log_densities), whole


def by_offset(measurements: Measurements) -> FloatArray:
    """Return the log-likelihood ratios of the first station by the offset of the end, averaged over both ends."""
    mean: FloatArray = evidence_and_ratio(measurements)[0].log_ratios[0].mean(axis=0)
    return mean


def test_line_evidence_lies_at_the_foot_of_the_perpendicular() -> None:
    evidence, _ = evidence_and_ratio(pings_of(BEFORE, [EAST]))
    assert evidence.feet == pytest.approx([0.3])
    assert evidence.centers_xy.tolist() == [[0.0, 0.3]]
    assert evidence.log_ratios.shape == (1, 2, len(OFFSETS))


@pytest.mark.parametrize("detected", [True, False])
def test_an_end_a_decimetre_past_the_foot_has_no_effect(*, detected: bool) -> None:
    evidence, whole = evidence_and_ratio(pings_of(BEFORE, [EAST]) if detected else BEFORE)
    assert evidence.log_ratios[0, :, 0] == pytest.approx([whole, whole])
    assert (whole > 20.0) if detected else (whole < -5.0)


@pytest.mark.parametrize("detected", [True, False])
def test_a_wall_that_ends_three_decimetres_before_the_foot_has_no_ratio(*, detected: bool) -> None:
    evidence, _ = evidence_and_ratio(pings_of(BEFORE, [EAST]) if detected else BEFORE)
    assert evidence.log_ratios[0, :, PAST_END] == pytest.approx([0.0, 0.0], abs=0.01)


def test_the_ratio_of_detections_decreases_across_the_end() -> None:
    ratios = by_offset(pings_of(BEFORE, [EAST]))
    assert (np.diff(ratios) <= 0.05).all()
    assert 0.0 < ratios[np.argmin(np.abs(OFFSETS))] < 0.9 * ratios[0]


def test_the_penalty_of_non_detections_decreases_across_the_end() -> None:
    ratios = by_offset(BEFORE)
    assert (np.diff(ratios) >= -0.05).all()


def test_masked_pings_give_no_line_evidence() -> None:
    nearer = BEFORE._replace(readings=np.full(len(BEFORE.readings), 0.4))
    assert np.abs(evidence_and_ratio(nearer)[0].log_ratios).max() < 1e-9


def test_explained_readings_give_no_line_evidence() -> None:
    measurements = pings_of(BEFORE, [EAST])
    estimate = likelihood(measurements)
    (east,) = rescored(estimate, [EAST])
    log_densities = np.full(len(measurements.readings), estimate.floor)
    log_densities[east.ping_scores.pings] = np.maximum(east.ping_scores.densities, estimate.floor)
    # Only pings at the edge of the beam remain as non-detections.
    assert line_evidence(estimate, east, 1, log_densities).log_ratios.max() < 0.5


def test_line_evidence_is_that_of_the_first_stations_in_range() -> None:
    measurements = pings_of(listening([(0.0, 0.0), (-20.0, 0.0), (0.0, 0.5), (0.0, 0.8)]), [EAST])
    estimate = likelihood(measurements)
    (east,) = rescored(estimate, [EAST])
    log_densities = np.full(len(measurements.readings), estimate.floor)
    assert line_evidence(estimate, east, 3, log_densities).feet == pytest.approx([0.0, 0.5])


def test_line_evidence_can_be_joined_and_selected() -> None:
    one, other = (evidence_and_ratio(pings_of(listening([(0.0, y)]), [EAST]))[0] for y in (0.1, 0.7))
    both = one.joined(other)
    assert both.feet == pytest.approx([0.1, 0.7])
    assert both.chosen(np.array([False, True])).log_ratios == pytest.approx(other.log_ratios)
