import numpy as np
import pytest

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import BoolArray, FloatArray
from echoplan.joint.likelihood.ping_scores import NO_ECHO, PingScores, detection_probability
from echoplan.preprocessing.measurements import Measurements
from helpers.expectations import (
    NOISE,
    REACH,
    ROOM,
    SONAR,
    corner,
    cylinder,
    edge,
    evidence_for,
    expected,
    listening,
    pings_of,
    wall,
)

HEARING = SONAR.tabulated()
EAST = ROOM[0]


def reference_scores(measurements: Measurements, reflector: FloatArray, noise: float) -> PingScores:
    """Return the scores of all pings by vectorised equations."""
    excess, reading = expected(measurements, reflector)
    if reflector[0] == Kind.WALL:
        normal = np.array([np.cos(reflector[1]), np.sin(reflector[1])])
        depth = reflector[2] - normal @ [measurements.x, measurements.y]
        ahead = np.broadcast_to(normal[:, None], (2, len(depth)))
        feet = normal[0] * measurements.y - normal[1] * measurements.x
    else:
        away = reflector[1:3, None] - [measurements.x, measurements.y]
        depth, ahead, feet = np.hypot(*away) - reflector[3], away / np.hypot(*away), np.zeros(len(measurements.x))
    cosine = ahead[0] * measurements.ux + ahead[1] * measurements.uy
    able = (cosine >= 0.2588) & (depth > 0) & (depth <= REACH) & (excess > -4)
    able &= (reading >= measurements.min_range) & (reading <= REACH)
    chance = 1 / (1 + np.exp(-excess / 1.2))
    scatter = noise * np.where(excess < 6, 1.6, 1.0)
    late, within = measurements.readings - reading, reading < REACH - 4 * scatter
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        normal_log = np.log(chance) - np.log(np.sqrt(2 * np.pi) * scatter) - 0.5 * (late / scatter) ** 2
        densities = np.where(np.abs(late) < 6 * scatter, normal_log, NO_ECHO)
        misses = np.where(within & (late > 4 * scatter), np.log(np.maximum(1 - 0.97 * chance, 0.06)), 0.0)
    columns = (densities, misses, within & (excess > 0), late > -0.03, feet)
    return PingScores(np.flatnonzero(able), *(each[able] for each in columns))


@pytest.mark.parametrize(
    "reflector", [EAST, wall(0.1, 1.6), cylinder(0.4, 1.0, 0.1), corner(2.0, 1.5), edge(0.3, 0.9), wall(2.0, 3.9)]
)
def test_ping_scores_agree_with_the_equations(room: Measurements, reflector: FloatArray) -> None:
    noisy = pings_of(listening(), [*ROOM, cylinder(0.4, 1.0, 0.1)], noise=0.006, rng=np.random.default_rng(4))
    for measurements in (room, noisy):
        for found, truth in zip(
            evidence_for(measurements, reflector), reference_scores(measurements, reflector, NOISE), strict=True
        ):
            assert found == pytest.approx(truth, abs=1e-6)


def test_half_of_the_echoes_at_the_threshold_are_detected() -> None:
    assert detection_probability(0.0) == 0.5
    assert detection_probability(1.2) == pytest.approx(1 / (1 + np.exp(-1)))
    assert detection_probability(3.0) + detection_probability(-3.0) == pytest.approx(1.0)
    assert detection_probability(-1e6) == pytest.approx(0.0, abs=1e-12)


def test_a_detection_has_the_normal_density_about_the_expected_reading() -> None:
    measurements = pings_of(listening(), [EAST])
    late = measurements._replace(readings=measurements.readings + NOISE)
    exact, shifted = evidence_for(measurements, EAST), evidence_for(late, EAST)
    excess = expected(measurements, EAST)[0][exact.pings]
    sure = (excess > 12.0) & (exact.densities > 0.0)
    assert sure.any()
    assert exact.densities[sure] == pytest.approx(-np.log(np.sqrt(2 * np.pi) * NOISE), abs=1e-3)
    assert shifted.densities[sure] == pytest.approx(exact.densities[sure] - 0.5, abs=1e-3)
    assert not exact.misses[exact.densities > 0].any()


def test_a_non_detection_counts_more_with_a_higher_excess_but_is_bounded() -> None:
    silent = listening()
    scores = evidence_for(silent, EAST)
    excess = expected(silent, EAST)[0][scores.pings]
    order = np.argsort(excess)
    assert (np.diff(scores.misses[order]) <= 1e-12).all()
    assert scores.misses.min() == pytest.approx(np.log(0.06))
    assert (scores.densities == NO_ECHO).all()


def scores_of_shifted_readings(shift: float) -> tuple[PingScores, BoolArray]:
    """Return the scores of pings that detect a wall, with shifted readings, and which pings these are."""
    measurements = pings_of(listening(), [EAST])
    scores = evidence_for(measurements._replace(readings=measurements.readings + shift), EAST)
    return scores, np.isfinite(measurements.readings)[scores.pings]


@pytest.mark.parametrize("shift", [-0.2, -0.05])
def test_masked_pings_have_no_score(shift: float) -> None:
    scores, detected = scores_of_shifted_readings(shift)
    assert not scores.unmasked[detected].any()
    assert not scores.misses[detected].any()
    assert (scores.densities[detected] == NO_ECHO).all()


def test_slightly_short_readings_are_neither_detections_nor_masked() -> None:
    scores, detected = scores_of_shifted_readings(-0.0295)
    assert scores.unmasked[detected].all()
    assert not scores.misses[detected].any()
    assert (scores.densities[detected] == NO_ECHO).all()


def test_longer_readings_are_non_detections() -> None:
    scores, detected = scores_of_shifted_readings(0.2)
    assert scores.unmasked[detected].all()
    assert (scores.misses[detected] < -0.5).all()
    assert (scores.densities[detected] == NO_ECHO).all()


def test_echoes_above_the_threshold_are_audible(room: Measurements) -> None:
    scores = evidence_for(room, EAST)
    assert (scores.audible == (expected(room, EAST)[0][scores.pings] > 0.0)).all()
    assert scores.audible.any()
    assert not scores.audible.all()


@pytest.mark.parametrize("reflector", [wall(0.0, -3.0), wall(0.0, 9.0), cylinder(6.0, 0.0, 0.1)])
def test_landmarks_behind_the_sensor_or_out_of_range_have_no_pings(room: Measurements, reflector: FloatArray) -> None:
    assert len(evidence_for(room, reflector).pings) == 0


@pytest.mark.parametrize(("margin", "counts"), [(1.0, 0), (30.0, 1)])
def test_at_the_range_limit_a_missing_echo_is_no_non_detection(margin: float, counts: int) -> None:
    ahead = listening([(0.0, 0.0)], arm=0.0)
    late = expected(ahead, wall(0.0, REACH - 0.1))[1].max() - (REACH - 0.1)
    rim = wall(0.0, REACH - late - margin * NOISE)
    echoes, silence = evidence_for(pings_of(ahead, [rim]), rim), evidence_for(ahead, rim)
    assert echoes.densities.max() > 0.0
    assert bool(silence.misses.any()) == bool(silence.audible.any()) == counts


def test_feet_are_where_perpendiculars_meet_a_wall(room: Measurements) -> None:
    scores = evidence_for(room, EAST)
    assert scores.feet == pytest.approx(room.y[scores.pings])
    assert not evidence_for(room, cylinder(1.0, 0.0, 0.1)).feet.any()
