import numpy as np
import pytest

from echoplan.model import Pings
from echoplan.preprocessing import echo_points, valid_pings
from echoplan.sources import open_source
from echoplan.viewer import EchoListener


def test_sweeps_pass_by_unchanged() -> None:
    source = open_source("sim:square")
    listener = EchoListener(source.rig)
    passed = list(listener.listen(source))
    assert [sweep.index for sweep in passed] == [sweep.index for sweep in source]


def test_a_short_recording_is_kept_whole() -> None:
    source = open_source("sim:square")
    sweeps = list(source)
    listener = EchoListener(source.rig, most=10**6)
    list(listener.listen(sweeps))
    every = [echo_points(valid_pings(Pings.from_sweep(sweep, source.rig), source.rig)) for sweep in sweeps]
    np.testing.assert_array_equal(listener.points_xy, np.concatenate(every))


@pytest.mark.parametrize("most", [10, 100, 333])
def test_a_long_one_is_thinned_evenly(most: int) -> None:
    source = open_source("sim:square")
    sweeps = list(source)
    whole, thin = EchoListener(source.rig, most=10**6), EchoListener(source.rig, most=most)
    list(whole.listen(sweeps))
    list(thin.listen(sweeps))
    every = whole.points_xy
    stride = next(2**power for power in range(30) if len(every[:: 2**power]) <= most)
    np.testing.assert_array_equal(thin.points_xy, every[::stride])


def test_no_detections_leave_no_points() -> None:
    assert EchoListener(open_source("sim:square").rig).points_xy.shape == (0, 2)
