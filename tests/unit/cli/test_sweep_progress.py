"""What the terminal shows while a device sweeps."""

from dataclasses import replace

import numpy as np
import pytest

from echoplan.cli.sweep_progress import SweepProgress
from echoplan.model import Sweep
from echoplan.sources import open_source

ROOM = open_source("sim:square,seed=1")


def with_readings_of(sensor: int, value: float) -> list[Sweep]:
    return [replace(sweep, ranges=np.where(sweep.sensor_ids == sensor, value, sweep.ranges)) for sweep in ROOM]


@pytest.mark.parametrize(
    ("value", "words", "count"),
    [
        pytest.param(np.inf, "Sensor 2 has no echo where others have", 2, id="silent"),
        pytest.param(np.nan, "Sensor 2 has no echo where others have", 2, id="echo pin stuck"),
        # At two places, walls may be equally far away.
        pytest.param(0.75, "Sensor 2 reads 0.75 m wherever", 3, id="one value"),
    ],
)
def test_a_silent_or_stuck_sensor_is_named_once_as_soon_as_it_is_certain(
    value: float, words: str, count: int, capsys: pytest.CaptureFixture[str]
) -> None:
    with SweepProgress() as progress:
        for number, sweep in enumerate(with_readings_of(2, value), start=1):
            progress.check(sweep, ROOM.rig)
            shown = capsys.readouterr().out
            assert (
                shown.startswith(f"Warning from the last {count} sweeps: {words}") if number == count else shown == ""
            )


def test_sound_sensors_are_not_named(capsys: pytest.CaptureFixture[str]) -> None:
    with SweepProgress() as progress:
        for sweep in ROOM:
            progress.check(sweep, ROOM.rig)
    assert capsys.readouterr().out == ""
