import numpy as np
import pytest

from echoplan.live.survey import PackedSweep, Survey
from echoplan.model import Sweep
from helpers.fed import RIG, swept

PLACES = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, np.pi / 2)]


@pytest.fixture
def survey() -> Survey:
    """Two sweeps at the first station, one at each of two others."""
    found = Survey(name="bench", rig=RIG)
    for number, pose in enumerate([PLACES[0], *PLACES]):
        found = found.with_sweep(swept(pose=pose, start_ns=number * 3_000_000_000))
    return found


def columns(sweep: Sweep) -> list[object]:
    names = ("stamps_ns", "sensor_ids", "servo_angles", "ranges", "map_from_base")
    return [sweep.index, *(getattr(sweep, name).tolist() for name in names)]


def test_a_sweep_comes_out_of_the_survey_as_it_went_in() -> None:
    ranges = np.where(np.arange(364) % 7, 1.0, np.inf)
    sweep = swept(ranges=ranges, start_ns=1_763_700_000_000_000_000, temperature=21.5)
    again = PackedSweep.pack(sweep).unpack()
    assert columns(again) == columns(sweep)
    assert again.temperature == 21.5


def test_a_packed_sweep_takes_a_fifth_of_the_memory() -> None:
    rng = np.random.default_rng(1)
    sweep = swept(ranges=np.round(rng.uniform(0.1, 3.0, 364), 3))
    assert len(PackedSweep.pack(sweep).data) < 364 * 56 / 5


def test_sweeps_are_numbered_and_their_times_go_on() -> None:
    survey = Survey(name="bench", rig=RIG).with_sweep(swept()).with_sweep(swept())
    first, second = survey
    assert (first.index, second.index) == (0, 1)
    assert second.stamps_ns[0] > first.stamps_ns[-1]
    assert np.diff(second.stamps_ns).tolist() == np.diff(first.stamps_ns).tolist()


def test_sweeps_from_one_pose_are_one_station(survey: Survey) -> None:
    assert survey.stations.tolist() == [0, 0, 1, 2]
    assert survey.station_poses.tolist() == [list(place) for place in PLACES]


def test_a_station_moves_with_all_its_sweeps_and_no_other(survey: Survey) -> None:
    moved = survey.with_station_at(0, map_from_base=np.array([0.5, -0.25, 1.0]))
    assert moved.station_poses.tolist() == [[0.5, -0.25, 1.0], *(list(place) for place in PLACES[1:])]
    assert moved.stations.tolist() == survey.stations.tolist()
    assert [sweep.ranges.tolist() for sweep in moved] == [sweep.ranges.tolist() for sweep in survey]


def test_undo_takes_the_whole_last_station_away_and_nothing_else(survey: Survey) -> None:
    assert [len(survey)] + [len(survey := survey.without_last_station()) for _ in range(4)] == [4, 3, 2, 0, 0]


def test_numbers_of_sweeps_are_not_used_twice_for_different_times(survey: Survey) -> None:
    again = survey.without_last_station().with_sweep(swept(pose=(3.0, 0.0, 0.0)))
    assert [sweep.index for sweep in again] == [0, 1, 2, 3]
    assert (np.diff([sweep.stamps_ns[0] for sweep in again]) > 0).all()


def test_many_repeats_of_a_station_are_thinned_out_for_the_mapper(survey: Survey) -> None:
    many = survey
    for _ in range(20):
        many = many.with_sweep(swept(pose=PLACES[2]))
    assert survey.thinned() == survey
    assert np.bincount(many.thinned().stations).tolist() == [2, 1, 9]
    assert many.thinned().sweeps == many.sweeps[: len(many.thinned())]
