"""A simulated device with faults: wrong bits, resets, and a port that vanishes for a while."""

from dataclasses import dataclass

import numpy as np

from echoplan.errors import InputError
from echoplan.hardware.head import Head
from echoplan.hardware.virtual import VirtualBoard

__all__ = ["Faults", "VirtualDevice", "parse_faults", "with_wrong_bits"]

_KNOWN = ("resets", "noise", "unplug", "silent", "stuck")
# Share of wrong bits, where nothing else is asked for.
_NOISE = 0.01
# Resets and unplugging come after a time between these, and a port stays away for a time between those [us].
_EVERY, _AWAY = (5_000_000, 20_000_000), (500_000, 2_000_000)


@dataclass(frozen=True, slots=True, kw_only=True)
class Faults:
    """What goes wrong with a device.

    Parameters
    ----------
    noise : float, optional
        Probability of each bit to arrive wrong, in either direction.
    resets : bool, optional
        Whether the device resets at random moments.
    unplug : bool, optional
        Whether the port vanishes at random moments and comes back.
    silent, stuck : int, optional
        Number of a sensor that never detects anything, and of one whose echo pin is always high.
    """

    noise: float = 0.0
    resets: bool = False
    unplug: bool = False
    silent: int | None = None
    stuck: int | None = None


def parse_faults(text: str, *, sensors: int) -> Faults:
    """Read faults as they are written on the command line: ``resets,noise=0.001,silent=2``.

    Raises ``InputError`` if a fault is unknown or its value cannot be.
    """
    values: dict[str, str] = {}
    for part in filter(None, text.split(",")):
        name, _, values_of = part.strip().partition("=")
        if name not in _KNOWN:
            raise InputError("--faults", f"{name!r} is unknown", remedy=f"choose from {', '.join(_KNOWN)}")
        values[name] = values_of
    numbers = {"noise": _NOISE, "silent": 0.0, "stuck": float(sensors - 1)}
    for name in numbers.keys() & values.keys():
        numbers[name] = _number(name, values[name], default=numbers[name], most=0.5 if name == "noise" else sensors - 1)
    return Faults(
        noise=numbers["noise"] if "noise" in values else 0.0,
        resets="resets" in values,
        unplug="unplug" in values,
        silent=int(numbers["silent"]) if "silent" in values else None,
        stuck=int(numbers["stuck"]) if "stuck" in values else None,
    )


def _number(name: str, text: str, *, default: float, most: float) -> float:
    """Return the value of a fault."""
    try:
        value = float(text) if text else default
    except ValueError:
        value = -1.0
    if not 0.0 <= value <= most or (name != "noise" and value % 1):
        raise InputError("--faults", f"{name} is {text!r}", remedy=f"write a number from 0 to {most:g}")
    return value


class VirtualDevice:
    """A device on a simulated board, and the line to it with its faults; all moments are those of its clock.

    A device neither resets nor vanishes between leaving a station and the next ping: the host could not know how far
    the wheels had turned since their last report.

    Parameters
    ----------
    board : VirtualBoard
        The board.
    faults : Faults, optional
        What goes wrong.
    seed : int, optional
        Seed of the faults.
    """

    def __init__(self, board: VirtualBoard, *, faults: Faults | None = None, seed: int = 0) -> None:
        self.board = board
        self.faults = faults or Faults()
        self._rng = np.random.default_rng((seed, 1))
        self._heads = [Head(board)]
        # When the next reset comes, the next unplugging, and the port back.
        self._times = {"reset": self._later(0, _EVERY), "unplug": self._later(0, _EVERY), "plug": 0}

    @property
    def head(self) -> Head:
        """The device since its last reset."""
        return self._heads[0]

    @property
    def is_plugged(self) -> bool:
        """Whether the port is there."""
        return self._times["plug"] == 0

    def receive(self, data: bytes) -> None:
        """Take bytes from the line."""
        self.head.receive(with_wrong_bits(data, self.faults.noise, rng=self._rng))

    def advance(self, clock_us: int) -> bytes:
        """Do what is due at this time, and return what comes out of the line."""
        times, is_driving = self._times, self.board.is_driving
        if self.faults.resets and clock_us >= times["reset"] and not is_driving:
            times["reset"] = self._later(clock_us, _EVERY)
            self.board.reset()
            self._heads[0] = Head(self.board)
        if times["plug"] and clock_us >= times["plug"]:
            times["plug"], times["unplug"] = 0, self._later(clock_us, _EVERY)
        elif self.faults.unplug and self.is_plugged and clock_us >= times["unplug"] and not is_driving:
            times["plug"] = self._later(clock_us, _AWAY)
        data = self.head.advance(clock_us)
        return with_wrong_bits(data, self.faults.noise, rng=self._rng) if self.is_plugged else b""

    def _later(self, clock_us: int, span: tuple[int, int]) -> int:
        return clock_us + int(self._rng.integers(*span))


def with_wrong_bits(data: bytes, share: float, *, rng: np.random.Generator) -> bytes:
    """Return bytes of which about a share of the bits is wrong."""
    if not data or not share:
        return data
    wrong = np.packbits(rng.random(8 * len(data)) < share)
    return (np.frombuffer(data, dtype=np.uint8) ^ wrong).tobytes()
