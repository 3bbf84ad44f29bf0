from contextlib import suppress
from pathlib import Path

import pytest

from echoplan.errors import InputError
from echoplan.io import read_recording
from echoplan.live import Control
from echoplan.live.unsaved import keep_sweeps
from helpers.fed import FakeFeed, swept


def test_each_sweep_is_on_the_disk_before_the_run_ends_and_goes_after_it(tmp_path: Path) -> None:
    with keep_sweeps(FakeFeed(), out=tmp_path) as keep:
        for number in range(2):
            keep(swept(pose=(float(number), 0.0, 0.0)))
            sweeps = tuple(read_recording(tmp_path / "unsaved"))
            assert [each.station[0] for each in sweeps] == [0.0, 1.0][: number + 1]
    assert not list(tmp_path.iterdir())


def test_after_an_error_sweeps_are_kept_and_not_mixed_with_those_of_the_next_run(tmp_path: Path) -> None:
    with suppress(OSError), keep_sweeps(FakeFeed(), out=tmp_path) as keep:
        keep(swept())
        raise OSError("full")
    assert len(tuple(read_recording(tmp_path / "unsaved"))) == 1
    with (
        pytest.raises(InputError, match=r"unsaved: it holds the sweeps of a run that was killed, or has not"),
        keep_sweeps(FakeFeed(), out=tmp_path),
    ):
        pass


def test_the_recording_of_an_earlier_run_is_not_replaced(tmp_path: Path) -> None:
    (tmp_path / "recording").mkdir()
    problem = r"recording: it holds the sweeps of an earlier run, .* choose another folder"
    with pytest.raises(InputError, match=problem), keep_sweeps(FakeFeed(), out=tmp_path):
        pass


def test_sweeps_of_a_recording_are_not_written_again(tmp_path: Path) -> None:
    with keep_sweeps(FakeFeed(frozenset({Control.PAUSE})), out=tmp_path) as keep:
        keep(swept())
        assert not list(tmp_path.iterdir())


def test_sweeps_of_a_robot_that_other_programs_drive_are_kept(tmp_path: Path) -> None:
    with keep_sweeps(FakeFeed(frozenset()), out=tmp_path) as keep:
        keep(swept())
        assert len(tuple(read_recording(tmp_path / "unsaved"))) == 1
