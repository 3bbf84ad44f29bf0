"""Recordings are read sweep by sweep and written whole."""

import errno
import os
import tracemalloc
from collections.abc import Callable, Iterator
from itertools import chain
from pathlib import Path

import numpy as np
import pytest

from echoplan.errors import InputError, InvalidValueError, OutputError
from echoplan.io import builtin_rig, read_recording, write_recording
from echoplan.io import table as table_module
from echoplan.model import Recording, Sweep

Folder = Callable[..., Path]

HEADER = "t,sweep,sensor,servo,range,x,y,yaw"
ROWS = (
    "0.025,3,0,-0.785398,1.2900,-2.63823,3.12315,-2.438584",
    "0.025,3,1,-0.785398,inf,-2.63823,3.12315,-2.438584",
    "0.050,3,0,-0.767945,-inf,-2.63823,3.12315,-2.438584",
    "2.025,4,2,0.785398,0.8750,-2.24823,3.27315,11.740973",
    "2.050,7,3,0.785398,nan,-2.24823,3.27315,11.740973",
)


def test_rows_of_one_number_are_one_sweep(folder: Folder) -> None:
    first, second, third = read_recording(folder(*ROWS))
    assert [sweep.index for sweep in (first, second, third)] == [3, 4, 7]
    assert first.stamps_ns.tolist() == [25_000_000, 25_000_000, 50_000_000]
    assert first.sensor_ids.tolist() == [0, 1, 0]
    assert first.servo_angles.tolist() == [-0.785398, -0.785398, -0.767945]
    assert first.ranges.tolist() == [1.29, np.inf, -np.inf]
    assert second.map_from_base.tolist() == [[-2.24823, 3.27315, 11.740973]]
    assert np.isnan(third.ranges).all()


@pytest.mark.parametrize("chunk", [1, 2, 3, 5, 100])
def test_sweeps_do_not_depend_on_the_chunks(folder: Folder, monkeypatch: pytest.MonkeyPatch, chunk: int) -> None:
    monkeypatch.setattr(table_module, "_CHUNK", chunk)
    recording = read_recording(folder(*ROWS))
    assert [len(sweep) for sweep in recording] == [3, 1, 1]
    assert len(recording) == 3


def test_a_recording_can_be_read_twice_and_is_called_after_its_folder(folder: Folder) -> None:
    recording = read_recording(folder(*ROWS))
    assert [sweep.index for sweep in recording] == [sweep.index for sweep in recording]
    assert recording.name == "recording"
    assert recording.rig.name == builtin_rig("rotary-array").name


def test_columns_in_another_order_and_others_beside_them_change_nothing(folder: Folder) -> None:
    order = [7, 0, 2, 1, 4, 3, 6, 5]
    rows = [",".join(["loud", *(row.split(",")[index] for index in order)]) for row in ROWS]
    header = ",".join(["amplitude", *(HEADER.split(",")[index] for index in order)])
    plain = list(read_recording(folder(*ROWS)))
    turned = list(read_recording(folder(*rows, header=header)))
    for one, other in zip(plain, turned, strict=True):
        assert one.map_from_base.tolist() == other.map_from_base.tolist()
        np.testing.assert_array_equal(one.ranges, other.ranges)


def test_a_thermometer_is_read_where_there_is_one(folder: Folder, tmp_path: Path) -> None:
    rows = [f"{row},{air}" for row, air in zip(ROWS, ("19.5", "", "20.5", "nan", "21.25"), strict=True)]
    recording = read_recording(folder(*rows, header=f"{HEADER},temperature"))
    write_recording(tmp_path / "copy", recording)
    for each in (recording, read_recording(tmp_path / "copy")):
        np.testing.assert_array_equal([sweep.temperature for sweep in each], [20.0, np.nan, 21.25])
    assert all(np.isnan(sweep.temperature) for sweep in read_recording(folder(*ROWS)))


def test_air_in_kelvin_is_refused(folder: Folder) -> None:
    rows = [f"{row},293.15" for row in ROWS]
    with pytest.raises(InputError, match=r"line 2, column temperature: '293\.15' is no temperature of air; write degr"):
        list(read_recording(folder(*rows, header=f"{HEADER},temperature")))


def test_faults_are_reported_when_they_are_reached(folder: Folder) -> None:
    sweeps = iter(read_recording(folder(*ROWS, "3.0,8,0,far,1.0,0,0,0")))
    with pytest.raises(InputError, match="line 7, column servo"):
        list(sweeps)


def test_a_recording_that_is_missing_or_is_a_file_is_refused(folder: Folder) -> None:
    path = folder(*ROWS)
    with pytest.raises(InputError, match=r"none: there is no such folder; name a folder with pings\.csv and rig\.toml"):
        read_recording(path / "none")
    with pytest.raises(InputError, match=r"pings\.csv: it is a file; name a folder with pings\.csv and rig\.toml"):
        read_recording(path / "pings.csv")


@pytest.mark.parametrize("name", ["pings.csv", "rig.toml"])
def test_a_recording_that_lacks_a_file_is_refused(folder: Folder, name: str) -> None:
    path = folder(*ROWS)
    (path / name).unlink()
    with pytest.raises(InputError, match=rf"{name}: there is no such file; check the name"):
        read_recording(path)


def test_a_folder_without_permission_is_refused(folder: Folder, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(_: Path) -> bool:
        raise PermissionError(errno.EACCES, "Permission denied")

    path = folder(*ROWS)
    monkeypatch.setattr(Path, "is_dir", refuse)
    with pytest.raises(InputError, match="recording: it may not be read; ask its owner for permission"):
        read_recording(path)


def test_a_recording_survives_writing_to_the_last_digit(folder: Folder, tmp_path: Path) -> None:
    recording = read_recording(folder(*ROWS))
    write_recording(tmp_path / "copy", recording)
    write_recording(tmp_path / "copy of copy", read_recording(tmp_path / "copy"))
    assert (tmp_path / "copy" / "pings.csv").read_text().splitlines()[1] == (
        "0.025,3,0,-0.785398,1.29,-2.63823,3.12315,-2.438584"
    )
    for name in ("pings.csv", "rig.toml"):
        assert (tmp_path / "copy" / name).read_bytes() == (tmp_path / "copy of copy" / name).read_bytes()


def test_times_of_the_present_day_keep_their_nanoseconds(folder: Folder, tmp_path: Path) -> None:
    row = ROWS[0].replace("0.025", "1763700000.123456789")
    write_recording(tmp_path / "copy", read_recording(folder(row)))
    (sweep,) = read_recording(tmp_path / "copy")
    assert sweep.stamps_ns.tolist() == [1_763_700_000_123_456_789]


def test_a_recording_can_be_written_over_itself(folder: Folder) -> None:
    path = folder(*ROWS)
    before = [sweep.ranges.tolist() for sweep in read_recording(path)]
    (path / "notes.txt").touch()
    write_recording(path, read_recording(path))
    np.testing.assert_equal([sweep.ranges.tolist() for sweep in read_recording(path)], before)
    assert sorted(child.name for child in path.iterdir()) == ["notes.txt", "pings.csv", "rig.toml"]


class Failing(Recording):
    """A source that breaks off after its sweeps."""

    def __iter__(self) -> Iterator[Sweep]:
        return chain(self.sweeps, self._break())

    def _break(self) -> Iterator[Sweep]:
        raise OSError(errno.ENOSPC, "No space left on device")
        yield


def test_a_disk_that_fills_leaves_nothing_half_written(folder: Folder, tmp_path: Path) -> None:
    recording = read_recording(folder(*ROWS))
    failing = Failing(name="failing", rig=recording.rig, sweeps=tuple(recording))
    before = sorted(tmp_path.iterdir())
    with pytest.raises(OutputError, match="out: No space left on device; free some space or choose another disk"):
        write_recording(tmp_path / "out", failing)
    assert sorted(tmp_path.iterdir()) == before


def test_a_source_without_pings_is_not_written(tmp_path: Path) -> None:
    silent = Recording(name="silence", rig=builtin_rig("ring-16"), sweeps=())
    with pytest.raises(InvalidValueError, match="silence has no pings to write"):
        write_recording(tmp_path / "out", silent)
    assert not list(tmp_path.iterdir())


def big_recording(folder: Folder, rows: int) -> Path:
    lines = (f"{k // 4 * 0.025:.3f},{k // 360},{k % 4},0.5,1.25,{k // 360}.5,0.25,1.5" for k in range(rows))
    return folder(*lines)


def peak_while(read: Callable[[], object]) -> int:
    tracemalloc.start()
    try:
        read()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_no_more_than_a_chunk_and_a_sweep_are_held(folder: Folder, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(table_module, "_CHUNK", 1_000)
    rows = 40_000
    recording = read_recording(big_recording(folder, rows))
    half_of_it = rows * 7 * 8 / 2
    assert peak_while(lambda: sum(map(len, recording))) < half_of_it
    assert peak_while(lambda: len(recording)) < half_of_it
    assert peak_while(lambda: list(recording)) > half_of_it


def test_a_folder_whose_name_is_no_utf8_is_read(folder: Folder) -> None:
    path = folder(*ROWS)
    odd = path.rename(os.fsdecode(os.fsencode(path.parent) + b"/r\xe4um"))
    assert read_recording(odd).name == "r?um"
