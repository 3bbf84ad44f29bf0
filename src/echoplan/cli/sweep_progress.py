"""Progress of a device's sweeps on the terminal, and faults of its sensors as soon as they show."""

from collections import deque
from typing import TYPE_CHECKING, Self

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

from echoplan.cli.terminal import logging_to, put

if TYPE_CHECKING:
    from echoplan.hardware.messages import Record
    from echoplan.model import Rig, Sweep

__all__ = ["SweepProgress"]


class SweepProgress:
    """A bar on standard error, if that is a terminal, while a device sweeps: a context manager."""

    def __init__(self) -> None:
        self._console = Console(stderr=True)
        columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TextColumn("pings"))
        self._bar = Progress(*columns, console=self._console, transient=True, disable=not self._console.is_terminal)
        self._logging = logging_to(self._console)
        # The last sweeps: a silent sensor shows in two, and one that always reads the same value in three.
        self._sweeps = deque["Sweep"](maxlen=5)
        self._reported = set[str]()

    def __enter__(self) -> Self:
        self._logging.__enter__()
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.stop()
        self._logging.__exit__(None, None, None)

    def begin(self, task: str, rig: "Rig", *, sweeps: int) -> None:
        """Draw an empty bar for the sweeps at a station."""
        rounds = 1 if rig.servo is None else len(rig.servo.angles)
        self._bar.add_task(task, total=sweeps * rounds * len(rig.sensors))
        self._bar.start()

    def watch(self, record: "Record") -> None:
        """Count a ping."""
        from echoplan.hardware import Echo  # noqa: PLC0415 - --help must not wait for NumPy

        if isinstance(record, Echo) and self._bar.task_ids:
            self._bar.advance(self._bar.task_ids[-1])

    def check(self, sweep: "Sweep", rig: "Rig") -> None:
        """Warn once of each fault of a sensor that the last sweeps show."""
        from echoplan.diagnosis import faults_in_words  # noqa: PLC0415
        from echoplan.preprocessing import Faults, find_faults  # noqa: PLC0415

        self._sweeps.append(sweep)
        if len(self._sweeps) < 2:
            return
        faults = Faults(sensors=find_faults([*self._sweeps], rig).sensors)
        for words in set(faults_in_words(faults)) - self._reported:
            self._reported.add(words)
            put(f"Warning from the last {len(self._sweeps)} sweeps: {words}")

    def end(self) -> None:
        """Remove the bar."""
        self._bar.stop()
        for task in self._bar.task_ids:
            self._bar.remove_task(task)
