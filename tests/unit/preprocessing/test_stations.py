import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.geometry import compose
from echoplan.preprocessing.measurements import halfway
from echoplan.preprocessing.stations import Stations, StationSettings, at_stations, group_sweeps, without_repeats
from helpers.expectations import listening

SETTINGS = StationSettings()


def along(*places: float) -> FloatArray:
    return np.column_stack([places, np.zeros(len(places)), np.zeros(len(places))])


def test_sweeps_from_nearly_one_place_are_one_station() -> None:
    found = group_sweeps(along(0.0, 0.05, 0.1, 0.3, 0.35, 2.0), np.full(6, 8), SETTINGS)
    assert found.numbers.tolist() == [0, 0, 0, 1, 1, 2]
    assert found.poses[:, 0].tolist() == [0.0, 0.3, 2.0]


def test_a_turn_makes_another_station() -> None:
    poses = along(0.0, 0.0, 0.0)
    poses[:, 2] = 0.0, 0.1, 1.0
    assert group_sweeps(poses, np.full(3, 8), SETTINGS).numbers.tolist() == [0, 0, 1]


def test_a_heading_across_the_half_turn_is_no_turn() -> None:
    poses = along(0.0, 0.0)
    poses[:, 2] = np.pi - 0.01, -np.pi + 0.01
    assert group_sweeps(poses, np.full(2, 8), SETTINGS).numbers.tolist() == [0, 0]


def test_sweeps_of_many_pings_stay_by_themselves() -> None:
    assert group_sweeps(along(0.0, 0.02, 0.04), np.full(3, 360), SETTINGS).numbers.tolist() == [0, 1, 2]


def test_sweeps_from_the_same_place_are_one_station_however_many_pings_they_have() -> None:
    assert group_sweeps(along(0.0, 0.005, 0.0, 1.0), np.full(4, 360), SETTINGS).numbers.tolist() == [0, 0, 0, 1]


def test_a_station_is_full_at_some_number_of_pings() -> None:
    places = along(*(0.02 * np.arange(7)))
    assert group_sweeps(places, np.full(7, 40), SETTINGS).numbers.tolist() == [0, 0, 1, 1, 2, 2, 3]


def test_pings_that_repeat_each_other_are_one_with_the_median_of_their_readings() -> None:
    measurements = listening([(0.0, 0.0), (0.0, 0.0), (0.0, 0.0), (1.0, 0.0)], rates=[1e-9] * 4)
    readings = np.repeat([2.0, 1.0, 1.5, 3.0], 120)
    # A dropout is outvoted, and two echoes are no less than two that are missing.
    readings[[0, 1, 121]] = np.inf
    stations = Stations(np.array([0, 0, 0, 1]), along(0.0, 1.0))
    found = without_repeats(at_stations(measurements._replace(readings=readings), stations))
    assert np.bincount(found.stations).tolist() == [120, 120]
    assert found.readings[found.stations == 0] == pytest.approx([1.5, np.inf, *[1.5] * 118])
    assert (found.readings[found.stations == 1] == 3.0).all()


def test_pings_of_fixed_sensors_stay() -> None:
    measurements = listening([(0.0, 0.0), (0.0, 0.0)])
    assert without_repeats(measurements) is measurements


def test_pings_of_different_places_are_no_repeats() -> None:
    measurements = listening([(0.0, 0.0), (0.03, 0.0)], rates=[1.0, 1.0])
    assert without_repeats(measurements) is measurements


def test_both_ways_of_a_servo_stay_and_count_as_one() -> None:
    # The servo turns on until the echo comes: pings of one angle look elsewhere there and back.
    both = halfway(listening([(0.0, 0.0)] * 2, rates=[0.7, -0.7])._replace(readings=np.repeat([2.0, 2.1], 120)))
    found = without_repeats(at_stations(both, Stations(np.array([0, 0]), along(0.0))))
    assert (found.readings == both.readings).all()
    assert found.bearings == pytest.approx(both.bearings)
    assert found.weights == pytest.approx(both.weights / 2)


def test_sweeps_are_moved_with_their_station() -> None:
    recorded = along(0.0, 0.1, 1.0)
    stations = Stations(np.array([0, 0, 1]), recorded[[0, 2]])
    shift = np.array([0.2, 0.1, 0.5])
    moved = stations.of_sweeps(recorded, compose(np.broadcast_to(shift, (2, 3)), stations.poses))
    assert moved == pytest.approx(compose(np.broadcast_to(shift, (3, 3)), recorded))


def test_trusted_poses_are_handed_back_as_they_were_recorded() -> None:
    recorded = along(0.0, 0.1, 1.0)
    stations = Stations(np.array([0, 0, 1]), recorded[[0, 2]])
    assert stations.of_sweeps(recorded, stations.poses) is recorded


def test_pings_are_numbered_by_station_about_its_middle() -> None:
    measurements = listening([(0.0, 0.0), (0.1, 0.0), (1.0, 0.0)])
    joined = at_stations(measurements, Stations(np.array([0, 0, 1]), along(0.0, 1.0)))
    assert joined.centers == pytest.approx(np.array([[0.05, 0.0], [1.0, 0.0]]))
    assert np.bincount(joined.stations).tolist() == [2 * 120, 120]
    assert (joined.x == measurements.x).all()
