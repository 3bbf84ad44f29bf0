import io
from functools import partial
from pathlib import Path

import pytest

from echoplan.hardware import Device
from echoplan.io import read_recording
from helpers.devices import Cart, Line
from helpers.typed import succeed


@pytest.mark.parametrize(("typed", "sweeps"), [("", 0), ("0 0 0\n", 1)])
def test_files_are_reported_only_if_they_were_written(
    typed: str, sweeps: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("echoplan.hardware.Device", partial(Device, connect=Line().connect))
    monkeypatch.setattr("sys.stdin", io.StringIO(typed))
    out = succeed("record", "line", "--out", tmp_path / "rec")
    assert f"\n{sweeps} sweeps\n" in out
    assert ("Written" in out) == (tmp_path / "rec" / "pings.csv").exists() == bool(sweeps)


def test_a_robot_with_wheels_is_pushed_from_station_to_station(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    line = Line(Cart())
    monkeypatch.setattr("echoplan.hardware.Device", partial(Device, connect=line.connect))
    monkeypatch.setattr("sys.stdin", io.StringIO("\n\nq\n"))
    out = succeed("record", "line", "--out", tmp_path / "rec")
    assert "\n3 sweeps\n" in out
    places = [sweep.map_from_base[0, 0] for sweep in read_recording(tmp_path / "rec")]
    # The cart rolls 0.1 m in a second, and its servo settles before the first ping.
    assert places[0] == pytest.approx(0.0, abs=0.1)
    assert places == sorted(set(places))
