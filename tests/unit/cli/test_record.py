import io
from functools import partial
from pathlib import Path

import pytest

from echoplan.hardware import Device
from helpers.devices import Line
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
