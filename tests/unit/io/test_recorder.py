"""A recording that grows sweep by sweep."""

import ctypes
import multiprocessing
import os
import random
import resource
import signal
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from echoplan.errors import InputError, OutputError
from echoplan.io import Recorder, builtin_rig, format_rig, read_recording, write_recording
from echoplan.model import Recording, Sweep

pytestmark = pytest.mark.slow

RIG = format_rig(builtin_rig("rotary-array"))


def sweep(number: int, *, pings: int = 60, temperature: float = float("nan")) -> Sweep:
    return Sweep(
        index=0,
        stamps_ns=1_000_000_000 * number + np.arange(pings),
        sensor_ids=np.zeros(pings, dtype=np.int64),
        servo_angles=np.linspace(-0.5, 0.5, pings),
        ranges=np.full(pings, 1.0 + number / 1024),
        map_from_base=np.zeros((pings, 3)),
        temperature=temperature,
    )


def record(path: Path, *, first: int = 0, count: int = 3) -> None:
    with Recorder(path, rig=RIG, append=first > 0) as recorder:
        for number in range(first, first + count):
            recorder.add(sweep(number))


def test_sweeps_are_numbered_in_their_order_and_continued(tmp_path: Path) -> None:
    record(tmp_path / "rec")
    record(tmp_path / "rec", first=3)
    recording = read_recording(tmp_path / "rec")
    assert [each.index for each in recording] == list(range(6))
    assert [each.ranges[0] for each in recording] == [1.0 + number / 1024 for number in range(6)]
    assert {path.name for path in (tmp_path / "rec").iterdir()} == {"pings.csv", "rig.toml"}


def test_a_recording_is_not_overwritten(tmp_path: Path) -> None:
    record(tmp_path / "rec")
    with pytest.raises(InputError, match="it holds a recording already; name another folder, or continue it with --ap"):
        record(tmp_path / "rec")


def test_nothing_is_left_of_a_recording_without_sweeps(tmp_path: Path) -> None:
    record(tmp_path / "rec", count=0)
    assert not (tmp_path / "rec").exists()


def test_a_temperature_is_recorded_where_it_was_measured(tmp_path: Path) -> None:
    with Recorder(tmp_path / "rec", rig=RIG) as recorder:
        recorder.add(sweep(0, temperature=21.5))
        recorder.add(sweep(1))
    temperatures = [each.temperature for each in read_recording(tmp_path / "rec")]
    np.testing.assert_array_equal(temperatures, [21.5, np.nan])


def test_a_sweep_that_could_not_be_written_is_not_read(tmp_path: Path) -> None:
    record(tmp_path / "rec", count=1)
    size = (tmp_path / "rec" / "pings.csv").stat().st_size
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    with Recorder(tmp_path / "rec", rig=RIG, append=True) as recorder:
        # As on a full disk, half of the sweep is written.
        resource.setrlimit(resource.RLIMIT_FSIZE, (size * 3 // 2, before[1]))
        try:
            with pytest.raises(OutputError, match=r"pings\.csv"):
                recorder.add(sweep(1))
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)
            signal.signal(signal.SIGXFSZ, handler)
        assert (tmp_path / "rec" / "pings.csv").stat().st_size > size
        # A program that ends here, without closing the recording, leaves this.
        assert len(read_recording(tmp_path / "rec")) == 1
        recorder.add(sweep(2))
    assert [each.ranges[0] for each in read_recording(tmp_path / "rec")] == [1.0, 1.0 + 2 / 1024]


def test_a_first_sweep_that_is_interrupted_leaves_no_pings(tmp_path: Path) -> None:
    with Recorder(tmp_path / "rec", rig=RIG):
        (tmp_path / "rec").mkdir()
        (tmp_path / "rec" / "pings.csv").write_text("t,sweep,sen")
    record(tmp_path / "rec", count=1)
    assert len(read_recording(tmp_path / "rec")) == 1


def test_a_recording_is_continued_although_the_clock_went_back(tmp_path: Path) -> None:
    record(tmp_path / "rec", first=0, count=3)
    with Recorder(tmp_path / "rec", rig=RIG, append=True) as recorder:
        recorder.add(sweep(0))
    stamps = [each.stamps_ns for each in read_recording(tmp_path / "rec")]
    np.testing.assert_array_equal(stamps[3] - stamps[3][0], np.arange(60))
    assert stamps[3][0] >= stamps[2][-1]


def test_a_recording_without_a_last_line_feed_is_continued(tmp_path: Path) -> None:
    record(tmp_path / "rec")
    pings = tmp_path / "rec" / "pings.csv"
    pings.write_text(pings.read_text().rstrip("\n"))
    record(tmp_path / "rec", first=3)
    assert [len(each) for each in read_recording(tmp_path / "rec")] == [60] * 6


def test_a_recording_is_not_continued_with_another_rig(tmp_path: Path) -> None:
    record(tmp_path / "rec")
    with pytest.raises(InputError, match="the recording was made with another rig; leave out --rig"):
        Recorder(tmp_path / "rec", rig=format_rig(builtin_rig("hc-sr04-servo")), append=True)


def test_a_recording_with_columns_of_others_is_not_continued(tmp_path: Path) -> None:
    record(tmp_path / "rec")
    pings = tmp_path / "rec" / "pings.csv"
    pings.write_text("\n".join(f"{line},7" for line in pings.read_text().splitlines()).replace("yaw,7", "yaw,gain"))
    with pytest.raises(InputError, match="it has columns that a device does not measure; record into another folder"):
        record(tmp_path / "rec", first=3)


def test_a_recording_that_replaces_that_of_a_killed_program_is_read_whole(tmp_path: Path) -> None:
    Recorder(tmp_path / "rec", rig=RIG).add(sweep(0))
    sweeps = tuple(replace(sweep(number), index=number) for number in range(3))
    write_recording(tmp_path / "rec", Recording(name="new", rig=builtin_rig("rotary-array"), sweeps=sweeps))
    assert len(tuple(read_recording(tmp_path / "rec"))) == 3


def test_a_count_of_rows_that_was_changed_is_refused(tmp_path: Path) -> None:
    record(tmp_path / "rec")
    (tmp_path / "rec" / "pings.rows").write_text("many")
    with pytest.raises(InputError, match=r"pings\.rows: 'many' is not a number of rows; delete it"):
        read_recording(tmp_path / "rec")


def record_until_killed(path: Path, first: int, done: ctypes.c_int) -> None:
    with Recorder(path, rig=RIG, append=True) as recorder:
        for number in range(first, first + 10_000):
            recorder.add(sweep(number))
            done.value = number + 1


def test_a_program_that_is_killed_loses_at_most_the_sweep_in_progress(tmp_path: Path) -> None:
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["echoplan.io", __name__])
    rng, recorded = random.Random(1), 0
    for kill in range(100):
        # A long recording takes long to read.
        path = tmp_path / f"rec-{kill // 10}"
        recorded = 0 if kill % 10 == 0 else recorded
        # Without a lock: a process that is killed while it holds one never returns it.
        done = context.Value("i", recorded, lock=False)
        child = context.Process(target=record_until_killed, args=(path, recorded, done))
        child.start()
        while done.value == recorded and child.is_alive():
            time.sleep(0.001)
        time.sleep(rng.uniform(0.0, 0.02))
        os.kill(child.pid or 0, signal.SIGKILL)
        child.join()
        found = [each.ranges.tolist() for each in read_recording(path)]
        assert found == [[1.0 + number / 1024] * 60 for number in range(len(found))]
        assert done.value <= len(found) <= done.value + 1
        recorded = len(found)
