"""The image-source method of pyroomacoustics as a referee: another program, the same burst, the same threshold."""

from typing import Any

import numpy as np
import pytest
from scipy.signal import fftconvolve

from echoplan.acoustics import Air, burst_envelope, crossing_delay, directivity, piston_ka, plane_echo, signal_excess
from echoplan.arrays import FloatArray
from echoplan.model import Transducer
from helpers import simulated_worlds

# pyroomacoustics warns of its own affairs.
pytestmark = pytest.mark.filterwarnings("ignore")

AIR = Air()
RATE = 400_000
HEIGHT = 6.0
CORNERS = np.array([[0.0, 0.0], [4.0, 0.0], [4.6, 1.9], [2.9, 3.3], [0.0, 2.7]])
PLACE = (1.7, 1.3)
HEADINGS = np.radians(np.arange(0.0, 360.0, 5.0))


@pytest.fixture(scope="module")
def referee() -> Any:
    return pytest.importorskip("pyroomacoustics", reason="pyroomacoustics is not installed")


def impulse_response(referee: Any, heading: float, transducer: Transducer) -> FloatArray:
    """Pressure of an impulse at the receiver, which stands a tenth of a millimetre beside the source."""

    class Piston(referee.directivities.base.Directivity):  # type: ignore[misc]
        is_impulse_response = False
        filter_len_ir = 1

        def get_response(self, azimuth: Any, colatitude: Any = None, *_: Any, degrees: bool = True, **__: Any) -> Any:
            unit = np.pi / 180 if degrees else 1.0
            level = np.sin(unit * np.asarray(colatitude)) if colatitude is not None else 1.0
            along = level * np.cos(unit * np.asarray(azimuth) - heading)
            return directivity(np.arccos(np.clip(along, -1, 1)), piston_ka(transducer, AIR))

        def sample_rays(self, *_: Any) -> None:
            raise NotImplementedError

        def set_orientation(self, *_: Any) -> None:
            pass

    hard, open_air = referee.Material(0.0), referee.Material(1.0)
    room = referee.Room.from_corners(CORNERS.T, fs=RATE, max_order=2, materials=hard, air_absorption=False)
    room.extrude(HEIGHT, materials=open_air)
    room.set_sound_speed(AIR.speed_of_sound)
    # Room.add_source drops a source of unknown directivity in silence; add_soundsource does not.
    room.add_soundsource(referee.SoundSource([*PLACE, HEIGHT / 2], directivity=Piston()))
    room.add_microphone(np.array([PLACE[0], PLACE[1] + 1e-4, HEIGHT / 2]), directivity=Piston())
    room.image_source_model()
    room.compute_rir()
    response: FloatArray = room.rir[0][0]
    return response


def reading(referee: Any, heading: float, transducer: Transducer) -> float:
    """What a module would read of the referee's impulse response."""
    response = impulse_response(referee, heading, transducer)
    times = (np.arange(len(response)) - referee.constants.get("frac_delay_length") // 2) / RATE
    direct = times < 2e-4
    absorbed = 10 ** (-AIR.absorption(transducer.frequency) * np.maximum(times, 0.0) * AIR.speed_of_sound / 20)
    clock = np.arange(0.0, 2e-3, 1 / RATE)
    burst = burst_envelope(clock, transducer) * np.exp(2j * np.pi * transducer.frequency * clock)
    gain = 10 ** (transducer.figure_of_merit / 20)
    level = gain * np.abs(fftconvolve(response * absorbed * ~direct, burst))[: len(response)]
    above = int(np.argmax(level >= 1))
    if level[above] < 1:
        return np.inf
    share = (1 - level[above - 1]) / (level[above] - level[above - 1])
    zero = crossing_delay(signal_excess(plane_echo(1.0), 2.0, transducer=transducer, air=AIR), transducer)
    return 0.5 * AIR.speed_of_sound * float(times[above - 1] + share / RATE - zero)


@pytest.mark.parametrize("transducer", [simulated_worlds.PAPER, simulated_worlds.HC_SR04], ids=["paper", "HC-SR04"])
def test_over_a_full_turn_a_referee_reads_the_same_of_walls_and_corners(referee: Any, transducer: Transducer) -> None:
    rig = simulated_worlds.rig(transducer=transducer, servo=simulated_worlds.turning(0, 355, 5))
    room = simulated_worlds.world(CORNERS, closed=True)
    # The referee knows no diffraction.
    simulation = simulated_worlds.simulation(room, using=rig, poses=[[*PLACE, 0.0]], diffraction=False)
    ours = simulated_worlds.readings(simulation)
    theirs = np.array([reading(referee, heading, transducer) for heading in HEADINGS])
    with np.errstate(invalid="ignore"):
        apart = np.where(ours == theirs, 0.0, np.abs(ours - theirs))
    # Where an echo just grazes the threshold the two may choose another one; here that happens in one heading.
    agreed = apart < 0.005
    assert agreed.sum() >= len(HEADINGS) - 1
    assert np.quantile(apart[agreed], 0.9) < 0.001
    corner = np.hypot(*PLACE)
    assert (np.abs(ours - corner) < 0.02).sum() >= 3
    assert np.isfinite(ours[agreed]).sum() > 50
