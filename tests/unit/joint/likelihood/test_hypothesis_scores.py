from dataclasses import replace

import numpy as np
import pytest

from echoplan.arrays import FloatArray, IntArray
from echoplan.joint.likelihood.hypothesis_scores import HypothesisScore, Occluders, missed, rescore
from echoplan.joint.likelihood.ping_scores import PingScores, score_pings
from echoplan.preprocessing.measurements import Measurements
from helpers.expectations import NOISE, REACH, ROOM, SONAR, corner, cylinder, evidence_for, listening, pings_of, wall

FLOOR = float(np.log(0.04 / REACH))
OPEN = Occluders(np.zeros((0, 4)), np.zeros((0, 2)))
EAST = ROOM[0]


def score_of(
    measurements: Measurements,
    reflector: FloatArray,
    *,
    log_densities: float | FloatArray = FLOOR,
    frame: Occluders = OPEN,
) -> HypothesisScore:
    """Return the score of a landmark, by default when no reading is explained."""
    known = np.broadcast_to(log_densities, measurements.readings.shape).astype(float)
    return rescore(measurements, reflector, evidence_for(measurements, reflector), known, frame)


def without_echoes_at(measurements: Measurements, *stations: int) -> Measurements:
    """Return the measurements without echoes at some stations."""
    gone = np.isin(measurements.stations, stations)
    return measurements._replace(readings=np.where(gone, np.inf, measurements.readings))


def sums_of(measurements: Measurements, evidence: PingScores, log_densities: FloatArray) -> FloatArray:
    """Return the sum of the log-likelihood ratios of the pings of each station [nats]."""
    gained = np.maximum(evidence.densities - log_densities[evidence.pings], 0.0) + evidence.misses
    own, weights = measurements.stations[evidence.pings], measurements.weights[evidence.pings]
    sums: FloatArray = np.bincount(own, weights * gained, minlength=len(measurements.centers)).astype(np.float64)
    return sums


def test_a_landmark_out_of_range_has_no_score(room: Measurements) -> None:
    verdict = score_of(room, wall(0.0, 9.0))
    assert (verdict.llr, verdict.low, verdict.high) == (0.0, 0.0, 0.0)
    assert not verdict.llr_by_station.any()


def test_real_walls_have_a_high_ratio_and_absent_walls_do_not(room: Measurements) -> None:
    assert min(score_of(room, each).llr for each in ROOM) > 50.0
    for absent in (wall(0.0, 1.5), wall(0.8, 1.2), wall(np.pi / 2, 1.4)):
        assert score_of(room, absent).llr < 5.0


def test_the_ratio_is_proportional_to_the_weights() -> None:
    measurements = pings_of(listening(), [EAST])
    halved = measurements._replace(weights=0.5 * measurements.weights)
    assert score_of(halved, EAST).llr_by_station == pytest.approx(0.5 * score_of(measurements, EAST).llr_by_station)


def test_the_ratio_of_a_station_is_the_sum_over_its_pings() -> None:
    measurements = pings_of(listening(), [EAST])
    evidence, verdict = evidence_for(measurements, EAST), score_of(measurements, EAST)
    sums = sums_of(measurements, evidence, np.full(len(measurements.readings), FLOOR))
    assert verdict.llr_by_station == pytest.approx(sums)
    assert verdict.llr == pytest.approx(sums.sum())


def test_readings_that_are_explained_give_no_ratio(room: Measurements) -> None:
    evidence = evidence_for(room, EAST)
    log_densities = np.full(len(room.readings), FLOOR)
    log_densities[evidence.pings] = np.maximum(evidence.densities, FLOOR)
    assert score_of(room, EAST, log_densities=log_densities).llr <= 0.0


def test_one_station_contributes_no_less_than_minus_twelve_nats() -> None:
    silent = listening(step=np.radians(4.0))
    assert score_of(silent, cylinder(0.0, 0.5, 0.3)).llr_by_station == pytest.approx(-12.0)


def test_missed_detections_are_bounded_by_twelve_nats_per_station() -> None:
    silent, post = listening(step=np.radians(4.0)), cylinder(0.0, 0.5, 0.3)
    evidence = evidence_for(silent, post)
    alone = np.bincount(silent.stations[evidence.pings], evidence.misses)
    assert alone.max() < -12.0
    assert missed(silent, evidence, (0.0, 0.0)) == pytest.approx(-12.0 * len(alone))
    quiet = silent._replace(weights=0.01 * silent.weights)
    assert missed(quiet, evidence, (0.0, 0.0)) == pytest.approx(0.01 * alone.sum())


def test_walls_are_missed_only_between_their_ends() -> None:
    silent = listening(step=np.radians(4.0))
    evidence = evidence_for(silent, EAST)
    quiet = silent._replace(weights=0.01 * silent.weights)
    low, high = evidence.feet.min(), evidence.feet.max()
    middle = 0.5 * (low + high)
    whole = missed(quiet, evidence, (low, high))
    assert whole == pytest.approx(0.01 * evidence.misses.sum())
    beyond = np.nextafter(middle, high)
    assert missed(quiet, evidence, (low, middle)) + missed(quiet, evidence, (beyond, high)) == pytest.approx(whole)
    assert whole < missed(quiet, evidence, (low, middle)) < 0.0
    assert missed(quiet, evidence, (high + 0.1, high + 0.2)) == 0.0


def test_a_detected_wall_is_hardly_missed(room: Measurements) -> None:
    silent = room._replace(readings=np.full(len(room.readings), np.inf))
    everywhere = -9.0, 9.0
    latent = missed(silent, evidence_for(silent, EAST), everywhere)
    assert 0.1 * latent < missed(room, evidence_for(room, EAST), everywhere) <= 0.0


def test_a_station_with_mostly_non_detections_does_not_support_a_landmark() -> None:
    post = cylinder(0.2, 1.0, 0.1)
    measurements = pings_of(listening(), [post])
    complete = score_of(measurements, post).llr_by_station[1]
    own = np.flatnonzero((measurements.stations == 1) & np.isfinite(measurements.readings))
    readings = measurements.readings.copy()
    readings[own[: round(0.7 * len(own))]] = np.inf
    partial = score_of(measurements._replace(readings=readings), post).llr_by_station[1]
    assert complete > 0.0 >= partial


def test_the_extent_of_a_wall_is_where_it_was_detected() -> None:
    verdict = score_of(pings_of(listening(arm=0.0), [EAST]), EAST)
    assert (verdict.low, verdict.high) == pytest.approx((-0.5, 0.3))


def in_a_row(count: int) -> Measurements:
    """Return stations before the east wall, half a metre apart, in random order."""
    places = np.random.default_rng(count).permutation(count)
    return pings_of(listening([(0.5, 0.5 * place) for place in places], arm=0.0), [EAST])


def places_of(measurements: Measurements) -> IntArray:
    """Return the position of each station in the row, from the south."""
    return np.round(measurements.centers[:, 1] / 0.5).astype(np.int64)


def test_the_score_of_a_wall_is_that_of_the_best_run_of_stations() -> None:
    measurements = in_a_row(7)
    places = places_of(measurements)
    broken = without_echoes_at(measurements, *np.flatnonzero(np.isin(places, [1, 2])))
    # The readings of the southernmost station are nearly explained: they do not outweigh two non-detecting stations.
    log_densities = np.where(places[broken.stations] == 0, FLOOR + 8.0, FLOOR)
    verdict = score_of(broken, EAST, log_densities=log_densities)
    assert sorted(places[verdict.llr_by_station != 0.0]) == [3, 4, 5, 6]
    assert (verdict.low, verdict.high) == pytest.approx((1.5, 3.0))


def test_a_run_spans_a_station_whose_penalty_is_outweighed() -> None:
    measurements = in_a_row(5)
    places = places_of(measurements)
    verdict = score_of(without_echoes_at(measurements, int(np.flatnonzero(places == 2)[0])), EAST)
    assert (verdict.low, verdict.high) == pytest.approx((0.0, 2.0))
    assert verdict.llr_by_station[places == 2] < 0.0


def test_the_best_run_has_the_greatest_sum_of_all_runs() -> None:
    rng, measurements = np.random.default_rng(8), in_a_row(6)
    for _ in range(20):
        muted = without_echoes_at(measurements, *np.flatnonzero(rng.random(6) < 0.5))
        log_densities = FLOOR + rng.uniform(0.0, 6.0, 6)[measurements.stations]
        llr_by_station = np.maximum(sums_of(muted, evidence_for(muted, EAST), log_densities), -12.0)[
            np.argsort(places_of(muted))
        ]
        runs = [llr_by_station[first:last].sum() for first in range(7) for last in range(first, 7)]
        assert score_of(muted, EAST, log_densities=log_densities).llr == pytest.approx(max(runs))


SCREEN = Occluders(np.array([wall(0.0, 1.0)]), np.array([[-0.8, -0.2]]))
POST = Occluders(np.array([cylinder(1.0, -0.5, 0.1)]), np.zeros((1, 2)))


@pytest.mark.parametrize("frame", [SCREEN, POST])
@pytest.mark.parametrize("reflector", [EAST, cylinder(2.0, -0.5, 0.1)])
def test_an_occluded_station_does_not_contradict_a_landmark(frame: Occluders, reflector: FloatArray) -> None:
    stations = [(0.0, -0.5), (1.5, -0.45), (1.5, 0.0), (1.4, 0.4)]
    measurements = without_echoes_at(pings_of(listening(stations), [reflector]), 0)
    assert score_of(measurements, cylinder(2.0, -0.5, 0.1)).llr_by_station[0] <= 0.0
    free, blocked = score_of(measurements, reflector), score_of(measurements, reflector, frame=frame)
    assert blocked.llr_by_station[0] == 0.0
    assert blocked.llr_by_station[1:] == pytest.approx(free.llr_by_station[1:])
    assert blocked.llr >= free.llr


@pytest.mark.parametrize(
    "frame",
    [
        Occluders(np.array([wall(0.0, 1.0)]), np.array([[0.2, 0.8]])),
        Occluders(np.array([wall(0.0, 2.5)]), np.array([[-2.0, 2.0]])),
        Occluders(np.array([wall(np.pi / 2, -0.5)]), np.array([[-3.0, 3.0]])),
        Occluders(np.array([cylinder(1.0, -0.2, 0.1)]), np.zeros((1, 2))),
        Occluders(np.array([corner(1.0, -0.5)]), np.zeros((1, 2))),
    ],
)
def test_landmarks_beside_or_behind_the_line_of_sight_do_not_occlude(frame: Occluders) -> None:
    post = cylinder(2.0, -0.5, 0.1)
    measurements = without_echoes_at(pings_of(listening([(0.0, -0.5), (1.5, -0.45), (1.5, 0.0)]), [post]), 0)
    free = score_of(measurements, post).llr_by_station
    assert free[0] < -1.0
    assert score_of(measurements, post, frame=frame).llr_by_station == pytest.approx(free)


def test_a_wall_behind_a_wall_does_not_occlude_it() -> None:
    measurements = without_echoes_at(pings_of(listening([(0.0, 0.0), (0.5, 0.2), (0.5, 0.4)]), [EAST]), 1)
    behind = Occluders(np.array([wall(0.0, 2.2)]), np.array([[-2.0, 2.0]]))
    free = score_of(measurements, EAST).llr_by_station
    assert free[1] < -1.0
    assert score_of(measurements, EAST, frame=behind).llr_by_station == pytest.approx(free)


def test_an_occluded_station_may_support_a_landmark() -> None:
    post = cylinder(2.0, -0.5, 0.1)
    measurements = without_echoes_at(pings_of(listening([(0.0, -0.5), (1.5, -0.45), (1.5, 0.0)]), [post]), 2)
    assert score_of(measurements, post, frame=SCREEN).llr_by_station[0] == pytest.approx(
        score_of(measurements, post).llr_by_station[0]
    )


def test_short_readings_support_a_landmark_after_scaling() -> None:
    warm = replace(SONAR, range_scale=0.02)
    measurements = pings_of(listening(), [EAST], sonar=warm)
    log_densities = np.full(len(measurements.readings), FLOOR)
    right, wrong = (
        rescore(measurements, EAST, score_pings(measurements, each.tabulated(), EAST, NOISE), log_densities, OPEN)
        for each in (warm, SONAR)
    )
    assert right.llr > 50.0 > wrong.llr
