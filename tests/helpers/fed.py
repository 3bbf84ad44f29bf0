"""A feed that a test drives, and sweeps for it."""

from collections.abc import Iterator
from queue import SimpleQueue
from typing import Any

import numpy as np

from echoplan.io import builtin_rig
from echoplan.live import Control, Event
from echoplan.model import Rig, Sweep

RIG = builtin_rig("rotary-array")


def swept(*, pose: tuple[float, float, float] = (0.0, 0.0, 0.0), start_ns: int = 0, **columns: Any) -> Sweep:
    """A sweep of the rotary array at one pose, with all readings at a metre unless they are given."""
    angles = np.repeat(np.linspace(-np.pi / 4, np.pi / 4, 91), 4)
    count = len(angles)
    values: dict[str, Any] = {
        "index": 0,
        "stamps_ns": start_ns + 25_000_000 * np.repeat(np.arange(91), 4),
        "sensor_ids": np.tile(np.arange(4), 91),
        "servo_angles": angles,
        "ranges": np.linspace(1.0, 1.2, count),
        "map_from_base": np.tile(pose, (count, 1)),
    }
    return Sweep(**(values | columns))


class FakeFeed:
    """Yields what a test puts into it, and notes what it is asked for."""

    def __init__(self, controls: frozenset[Control] = frozenset(Control)) -> None:
        self.controls = controls
        self.asked: list[Any] = []
        self.waiting: SimpleQueue[Event | None] = SimpleQueue()

    @property
    def name(self) -> str:
        return "bench"

    @property
    def rig(self) -> Rig:
        return RIG

    def events(self) -> Iterator[Event]:
        while (event := self.waiting.get()) is not None:
            yield event

    def place(self, map_from_base: Any) -> None:
        self.asked.append(map_from_base.tolist())

    def sweep(self) -> None:
        self.asked.append("sweep")

    def play(self, *, playing: bool) -> None:
        self.asked.append(playing)

    def close(self) -> None:
        self.waiting.put(None)
