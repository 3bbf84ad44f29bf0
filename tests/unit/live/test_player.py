from threading import Thread
from time import monotonic

import numpy as np
import pytest

from echoplan.errors import InvalidValueError
from echoplan.live import Complete, Control, Notice, Partial, Player, SimulationPlayer
from echoplan.model import Recording
from echoplan.sources import open_source
from helpers.fed import RIG, swept


def recording(count: int) -> Recording:
    sweeps = tuple(swept(index=number, start_ns=number * 60_000_000_000) for number in range(count))
    return Recording(name="two", rig=RIG, sweeps=sweeps)


def test_a_recording_is_played_ping_by_ping_in_its_own_time() -> None:
    start = monotonic()
    events = list(Player(recording(1), speed=5.0).events())
    assert monotonic() - start == pytest.approx(2.25 / 5.0, abs=0.3)
    *partial, complete, notice = events
    lengths = [len(each.sweep) for each in partial if isinstance(each, Partial)]
    assert lengths[0] == 4
    assert lengths == sorted(lengths)
    assert len(lengths) == len(partial) >= 4
    assert isinstance(complete, Complete)
    assert len(complete.sweep) == 364
    assert isinstance(notice, Notice)


def test_a_minute_between_two_stations_is_shortened() -> None:
    start = monotonic()
    events = list(Player(recording(2), speed=100.0).events())
    assert monotonic() - start < 2.0
    assert sum(isinstance(each, Complete) for each in events) == 2


def test_a_pause_holds_the_recording_and_the_sweep_goes_on_where_it_was() -> None:
    player = Player(recording(1), speed=20.0)
    player.play(playing=False)
    seen = list[object]()
    reader = Thread(target=lambda: seen.extend(player.events()))
    reader.start()
    reader.join(0.3)
    assert not seen
    assert reader.is_alive()
    player.play(playing=True)
    reader.join(5.0)
    assert isinstance(seen[-2], Complete)


def test_a_closed_player_ends_at_once_even_while_it_pauses() -> None:
    player = Player(recording(2), speed=0.001)
    reader = Thread(target=lambda: list(player.events()))
    reader.start()
    player.play(playing=False)
    player.close()
    reader.join(2.0)
    assert not reader.is_alive()


def test_a_simulated_robot_sweeps_where_it_is_put() -> None:
    simulation = open_source("sim:square,seed=3")
    player = SimulationPlayer(simulation, speed=1000.0)  # type: ignore[arg-type]
    assert player.controls == {Control.PAUSE, Control.SWEEP}
    events = player.events()
    played = [next(each for each in events if isinstance(each, Complete)) for _ in simulation]
    assert isinstance(next(events), Notice)
    player.place(np.array([0.2, 0.3, 0.5]))
    player.sweep()
    asked = next(each for each in events if isinstance(each, Complete))
    player.close()
    assert len(played) == len(simulation)
    assert asked.sweep.station.tolist() == [0.2, 0.3, 0.5]
    assert not list(events)


@pytest.mark.parametrize("speed", [0.0, -1.0, float("nan")])
def test_a_speed_that_cannot_be_is_refused(speed: float) -> None:
    with pytest.raises(InvalidValueError, match="speed must be"):
        Player(recording(1), speed=speed)
