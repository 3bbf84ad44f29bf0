"""A device on a live page: sweeps where a viewer puts it, whatever the line does."""

import itertools
import threading

import numpy as np
import pytest

from echoplan.io import builtin_rig
from echoplan.live import Complete, Control, DeviceFeed, Notice, Partial
from helpers.devices import Line

RIG = builtin_rig("rotary-array")


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("time.sleep", lambda _: None)


@pytest.mark.parametrize("line", [Line(), Line(resets=(700,))], ids=["sound", "reset"])
def test_a_device_sweeps_where_it_is_put_when_it_is_asked(line: Line) -> None:
    feed = DeviceFeed("test", rig=RIG, connect=line.connect)
    assert feed.controls == {Control.SWEEP}
    events = feed.events()
    made = []
    for pose in ([1.0, 2.0, 0.5], [3.0, 2.0, -0.5]):
        feed.place(np.array(pose))
        feed.sweep()
        made.append(next(each for each in events if isinstance(each, Complete)))
        assert made[-1].sweep.station == pytest.approx(pose)
        assert len(made[-1].sweep) == 364
    feed.close()
    assert not [each for each in events if isinstance(each, Complete)]


def test_a_device_sweeps_repeatedly_at_each_station_until_it_is_closed() -> None:
    feed = DeviceFeed("test", rig=RIG, sweeps=60_000, connect=Line().connect)
    events = feed.events()
    feed.sweep()
    made = list(itertools.islice((each for each in events if isinstance(each, Complete)), 3))
    assert [each.sweep.index for each in made] == [0, 1, 2]
    feed.close()
    working = [each for each in threading.enumerate() if each.name == "echoplan device"]
    for thread in working:
        thread.join(20)
    assert not any(thread.is_alive() for thread in working)


def test_a_rig_that_does_not_fit_is_a_notice_on_the_page() -> None:
    feed = DeviceFeed("test", rig=builtin_rig("ring-16"), connect=Line().connect)
    events = feed.events()
    feed.sweep()
    notice = next(each for each in events if not isinstance(each, Partial))
    feed.close()
    assert isinstance(notice, Notice)
    assert notice.is_problem
    assert "the device has 4 sensors" in notice.text
