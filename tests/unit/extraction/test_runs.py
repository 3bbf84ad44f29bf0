import numpy as np
import pytest

from echoplan.extraction import connected_runs
from echoplan.geometry import rotation_step
from helpers import scenes


def test_the_step_of_rotation_is_the_usual_gap() -> None:
    bearings = np.delete(scenes.around(0.0, np.radians(40)), [3, 50])
    assert rotation_step(bearings) == pytest.approx(scenes.STEP)
    assert rotation_step(np.zeros(1)) == pytest.approx(2 * np.pi)


def test_pings_without_echo_belong_to_no_run_and_split_none() -> None:
    bearings = scenes.around(0.0, np.radians(5))
    distances = np.ones(len(bearings))
    distances[[2, 3]] = np.inf
    (run,) = connected_runs(bearings, distances, max_gap=np.radians(4.5), jump=0.02, reach=4)
    assert sorted(run) == [0, 1, *range(4, 11)]


def test_runs_do_not_depend_on_the_order_of_the_pings() -> None:
    rng = np.random.default_rng(3)
    bearings = rng.uniform(-np.pi, np.pi, 200)
    distances = 1.0 + 0.2 * np.round(2 * np.sin(bearings)) + rng.normal(0, 0.002, 200)
    shuffle = rng.permutation(200)
    plain = connected_runs(bearings, distances, max_gap=0.2, jump=0.02, reach=4)
    mixed = connected_runs(bearings[shuffle], distances[shuffle], max_gap=0.2, jump=0.02, reach=4)
    assert {frozenset(run.tolist()) for run in plain} == {frozenset(shuffle[run].tolist()) for run in mixed}


def test_no_detections_make_no_runs() -> None:
    assert connected_runs(np.zeros(0), np.zeros(0), max_gap=0.1, jump=0.1, reach=2) == []
    assert connected_runs(np.zeros(3), np.full(3, np.inf), max_gap=0.1, jump=0.1, reach=2) == []
