"""Devices in the process of the test: a head whose time passes while the host reads, and faults of its line."""

from collections.abc import Sequence

import numpy as np

from echoplan.hardware.faulty import with_wrong_bits
from echoplan.hardware.head import Board, Head
from echoplan.hardware.port import Port

# Time that passes from read to read of the host [us].
TICK_US = 2000


class Room(Board):
    """A board whose times of flight depend on pulse and sensor: 100 us a degree, 10 000 us a sensor."""

    name = "test"
    sensors = 4
    capabilities = ("servo", "air")

    def __init__(self) -> None:
        self.state = {"pulse": 0, "due": 0, "now": 0}
        self.fired: list[int] = []

    def advance(self, clock_us: int) -> None:
        self.state["now"] = clock_us

    def servo(self, pulse_us: int) -> None:
        self.state["pulse"] = pulse_us

    def fire(self, sensors: list[int], listen_us: int) -> None:
        self.fired = sensors
        self.state["due"] = self.state["now"] + 4000

    def flights(self) -> list[int] | None:
        if self.state["now"] < self.state["due"]:
            return None
        return [flight(self.state["pulse"], sensor) for sensor in self.fired]

    def temperature(self) -> int:
        return 2150


def flight(pulse_us: int, sensor: int) -> int:
    """Return the time of flight of a sensor at a pulse [us]."""
    return 1000 + pulse_us + 3000 * sensor


class Line:
    """The line to a device: a transport that flips bits, and may be cut or reset the device after so many reads."""

    def __init__(
        self,
        board: Board | None = None,
        *,
        bit_errors: float = 0.0,
        resets: Sequence[int] = (),
        cuts: Sequence[int] = (),
        seed: int = 0,
    ) -> None:
        self.rng = np.random.default_rng(seed)
        self.bit_errors = bit_errors
        self.resets = set(resets)
        self.cuts = set(cuts)
        self.reads = [0]
        self.heads = [Head(board or Room())]

    def carry(self, board: Board) -> None:
        """Put the device where a board is."""
        self.heads[0].board = board

    def connect(self, name: str) -> Port:
        """Open a port to the device."""
        return Port(name=name, transport=self, clock=self.now)

    def now(self) -> float:
        """Return the time [s]."""
        return 1e-6 * TICK_US * self.reads[0]

    def read(self) -> bytes:
        self.reads[0] += 1
        if self.reads[0] in self.resets:
            self.heads[:] = [Head(self.heads[0].board)]
        if self.reads[0] in self.cuts:
            raise OSError("device disconnected")
        # The clock in the lines begins again from 0 after 5 s.
        data = self.heads[0].advance(2**32 - 5_000_000 + TICK_US * self.reads[0])
        return with_wrong_bits(data, self.bit_errors, rng=self.rng)

    def write(self, data: bytes) -> None:
        self.heads[0].receive(with_wrong_bits(data, self.bit_errors, rng=self.rng))

    def close(self) -> None:
        """Nothing has to be closed."""


class Cart(Room):
    """A board with wheels and no motors, which somebody pushes straight ahead: a count each millisecond."""

    capabilities = ("servo", "wheels")
    tick, base = 100, 2000

    def __init__(self, count: int = 0) -> None:
        super().__init__()
        self.state["count"] = count

    def wheels(self) -> tuple[int, int]:
        count = self.state["count"] + self.state["now"] // 1000
        return (count, count)
