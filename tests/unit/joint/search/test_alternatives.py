from dataclasses import replace

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.search.alternatives import class_probabilities
from echoplan.model import ClassProbabilities
from echoplan.preprocessing.measurements import Measurements
from helpers.expectations import (
    NOISE,
    ROOM,
    STATIONS,
    corner,
    cylinder,
    likelihood,
    listening,
    pings_of,
    rescored,
    wall,
)

COLUMN = cylinder(0.2, 0.9, 0.1)
VERTEX = corner(2.0, 1.5)
COST = 2.0


def detected(*truth: FloatArray, stations: int = 4, pings: int = 10_000) -> Measurements:
    """Return pings of landmarks, with at most a number of echoes per station."""
    measurements = pings_of(listening(STATIONS[:stations]), truth, noise=NOISE, rng=np.random.default_rng(1))
    echo = np.isfinite(measurements.readings)
    order = (
        np.cumsum(echo) - np.append(0, np.cumsum(echo))[np.searchsorted(measurements.stations, measurements.stations)]
    )
    return measurements._replace(readings=np.where(order <= pings, measurements.readings, np.inf))


def probabilities(
    measurements: Measurements, *known: FloatArray, radius_cost: float = COST
) -> list[ClassProbabilities]:
    estimate = likelihood(measurements)
    return class_probabilities(estimate, rescored(estimate, known), radius_cost=radius_cost)


def test_landmarks_of_many_stations_have_certain_classes() -> None:
    truth = [*ROOM, COLUMN, VERTEX]
    found = probabilities(detected(*truth), *truth)
    assert [each.wall for each in found[:4]] == pytest.approx([1.0] * 4, abs=5e-3)
    assert found[4].cylinder == pytest.approx(1.0, abs=5e-3)
    assert found[5].corner == pytest.approx(1.0, abs=5e-3)


def test_the_classes_of_each_feature_sum_to_one() -> None:
    truth = [ROOM[1], COLUMN]
    found = probabilities(detected(*truth, stations=1), *truth)
    assert len(found) == 2
    assert [each.wall + each.corner + each.cylinder for each in found] == pytest.approx([1.0, 1.0])


def test_class_probabilities_are_bounded_by_the_number_of_stations() -> None:
    chances = [probabilities(detected(ROOM[1], stations=count), ROOM[1])[0].wall for count in (1, 2, 3, 4)]
    assert chances[0] <= chances[1] < 0.961
    assert 0.99 < chances[2] < 0.9961
    assert 0.999 < chances[3] < 0.99961


def test_no_class_is_ruled_out_altogether() -> None:
    found = probabilities(detected(ROOM[1]), corner(0.1, 1.5))[0]
    assert min(found.wall, found.corner, found.cylinder) > 1e-5


def test_a_few_pings_of_one_station_leave_the_class_open() -> None:
    many = probabilities(detected(ROOM[1]), ROOM[1])[0]
    few = probabilities(detected(ROOM[1], stations=1, pings=4), ROOM[1])[0]
    assert many.wall > 0.999
    assert few.wall < 0.9
    assert few.corner > 0.05


def test_more_stations_reduce_the_probability_of_a_cylinder() -> None:
    chances = [probabilities(detected(ROOM[1], stations=count), ROOM[1])[0].cylinder for count in (2, 3, 4)]
    assert chances[0] > chances[1] > chances[2]


def test_a_cylinder_has_a_cost_for_its_radius() -> None:
    measurements = detected(COLUMN, stations=2, pings=4)
    cheap, dear = (probabilities(measurements, COLUMN, radius_cost=cost)[0].cylinder for cost in (0.0, 3.0))
    assert 0.0 < dear < cheap < 1.0
    # Without the share of unmodelled echoes, as for a thin cylinder of two stations.
    cheap, dear = ((each - 0.06 / 3.0) / 0.94 for each in (cheap, dear))
    odds = (cheap / (1 - cheap)) / (dear / (1 - dear))
    assert odds == pytest.approx(np.exp(3.0))


def test_a_wrong_class_has_a_low_probability() -> None:
    # Classified as a corner at the point of a wall nearest to the stations.
    found = probabilities(detected(ROOM[1]), corner(0.1, 1.5))[0]
    assert found.wall > 0.95


def test_a_duplicate_of_a_wall_has_no_certain_class() -> None:
    measurements = detected(*ROOM)
    estimate = likelihood(measurements)
    known = rescored(estimate, [*ROOM, wall(0.0, 2.0005)])
    log_densities = estimate.log_densities(known[:4])
    copy = estimate.rescored(known[4], log_densities, known[:4])
    doubled = class_probabilities(estimate, [*known[:4], copy], radius_cost=COST)
    assert doubled[1].wall > 0.999
    assert copy.llr < 5.0
    assert doubled[4].wall < 0.999


def test_a_landmark_without_support_has_class_probabilities() -> None:
    estimate = likelihood(listening())
    lonely: Hypothesis = replace(rescored(estimate, [COLUMN])[0], llr_by_station=np.zeros(4))
    (found,) = class_probabilities(estimate, [lonely], radius_cost=COST)
    assert found.wall + found.corner + found.cylinder == pytest.approx(1.0)


def test_without_landmarks_there_are_no_class_probabilities() -> None:
    assert class_probabilities(likelihood(detected(ROOM[0])), [], radius_cost=COST) == []
