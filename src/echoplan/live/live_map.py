"""One live map: the survey, what viewers ask of it, and the process beside the server that maps it."""

import asyncio
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.errors import EchoplanError, InputError
from echoplan.live.commands import Command, PlaceCommand, PlayCommand, SweepCommand, UndoCommand
from echoplan.live.feed import Complete, Control, Event, Feed, Notice, Partial
from echoplan.live.mapping import MapUpdate, check_map, draw_map, map_update, sensor_faults, write_results
from echoplan.live.messages import (
    encoded,
    faults_message,
    hello_message,
    shares_message,
    stations_message,
    sweep_message,
)
from echoplan.live.survey import Survey
from echoplan.model import Sweep

__all__ = ["ARCHIVE", "LiveMap"]

ARCHIVE = "echoplan.zip"
# The share of valid readings is that of so many sweeps, and faults of sensors are looked for in so many.
_SHOWN, _CHECKED = 2, 5
# Why a source refuses, and what to do.
_REFUSALS = {
    Control.SWEEP: ("a recording cannot make new sweeps", "use a device or sim:WORLD"),
    Control.PAUSE: ("this device does not drive a route", "press Sweep here for each sweep"),
}


class LiveMap:
    """What all viewers of one source share.

    Everything but the thread of the feed and the process of the mapper happens in the event loop.

    Parameters
    ----------
    feed : Feed
        Where sweeps come from.
    executor : Executor
        Maps and saves, beside the event loop.
    scratch : Path
        Folder for downloads.
    out : Path, optional
        Folder for results; by default they are only offered for download.
    keep : callable, optional
        Is given each complete sweep, in the thread of the feed, before viewers see it.
    publish : callable, optional
        Is given each new map, for programs beside the page.
    """

    def __init__(
        self,
        feed: Feed,
        *,
        executor: Executor,
        scratch: Path,
        out: Path | None = None,
        keep: Callable[[Sweep], None] = lambda _: None,
        publish: Callable[[MapUpdate], None] | None = None,
    ) -> None:
        self.feed = feed
        self._publish = publish
        self._keep = keep
        self._executor = executor
        self._archive = scratch / ARCHIVE
        self._folder = out or scratch / "map"
        self._survey = deque([Survey(name=feed.name, rig=feed.rig)], maxlen=1)
        self._recent: deque[Sweep] = deque(maxlen=_SHOWN)
        self._current: deque[Sweep] = deque(maxlen=1)
        # Maps begin at the origin where nobody says otherwise.
        self._robot = deque([np.zeros(3)] if Control.SWEEP in feed.controls else list[FloatArray](), maxlen=1)
        self._flags = {"playing": True, "mapping": False, "placed": False, "unsaved": False}
        self._files: dict[str, Path] = {}
        self._changed = asyncio.Event()
        self._saving = asyncio.Lock()
        # The newest message of each topic, and how often it was renewed.
        self.board: dict[str, tuple[int, str]] = {}
        self.post("hello", hello_message(feed, folder="" if out is None else str(out)))
        self._show_survey()
        # The process starts now, and not with the first sweep.
        self._changed.set()

    @property
    def survey(self) -> Survey:
        """The sweeps so far."""
        return self._survey[0]

    @property
    def has_unsaved(self) -> bool:
        """Whether something came or was changed since the results were written."""
        return self._flags["unsaved"]

    def post(self, topic: str, content: dict[str, object]) -> None:
        """Put the newest message of a topic on the board."""
        self._put(topic, encoded(topic, content))

    def file(self, name: str) -> Path | None:
        """Return where a result that was saved lies; None if there is no such one."""
        return self._files.get(name)

    def post_frame(self) -> None:
        """Put the state of this moment on the board."""
        is_complete = not self._current
        sweeps = [*self._recent, *self._current]
        content: dict[str, object] = {
            "playing": self._flags["playing"],
            "mapping": self._flags["mapping"],
            "robot": np.round(self._robot[0], 4).tolist() if self._robot else None,
            "sensors": shares_message(sweeps, self.feed.rig),
        }
        if sweeps:
            content["sweep"] = sweep_message(sweeps[-1], self.feed.rig) | {"is_complete": is_complete}
        self.post("frame", content)

    def take(self, event: Event) -> None:
        """Take what the feed says."""
        if isinstance(event, Notice):
            self.post("notice", {"text": event.text, "is_problem": event.is_problem})
            return
        if isinstance(event, Partial):
            self._current.append(event.sweep)
            return
        self._current.clear()
        self._recent.append(event.sweep)
        self._follow(event.sweep.station)
        # A rig may become better known while it is used.
        self._change(replace(self.survey.with_sweep(event.sweep), rig=self.feed.rig))

    def obey(self, command: Command) -> None:
        """Do what a viewer asks for; saving is ``save``.

        Raises
        ------
        InputError
            If it cannot be done.
        """
        if isinstance(command, PlaceCommand):
            self._place(command)
        elif isinstance(command, UndoCommand):
            if not len(self.survey):
                raise InputError("undo", "there is no station yet", remedy="make a sweep first")
            self._change(self.survey.without_last_station())
        elif isinstance(command, PlayCommand):
            self._require(Control.PAUSE)
            self.feed.play(playing=command.playing)
            self._flags["playing"] = command.playing
        elif isinstance(command, SweepCommand):
            self._require(Control.SWEEP)
            # Where viewers see the robot, even if a feed was elsewhere meanwhile.
            self.feed.place(self._robot[0])
            self.feed.sweep()

    async def save(self) -> None:
        """Write the results and offer them for download.

        Raises
        ------
        EchoplanError
            If they cannot be written.
        """
        async with self._saving:
            survey = self.survey
            if not len(survey):
                raise InputError("save", "there is no station yet", remedy="make a sweep first")
            write = partial(write_results, survey, folder=self._folder, archive=self._archive)
            try:
                names = await asyncio.get_running_loop().run_in_executor(self._executor, write)
            except BrokenProcessPool as error:
                raise InputError("save", "the mapper ended", remedy="free some memory and save again") from error
            self._files.update({name: self._folder / name for name in names} | {ARCHIVE: self._archive})
            self._flags["unsaved"] = survey != self.survey
            self.post("saved", {"files": [ARCHIVE, *names], "stations": len(survey.station_poses)})

    async def keep_mapping(self) -> None:
        """Map the survey whenever it has changed: always the newest, whatever changed meanwhile.

        Checking a map may take longer than adding a sweep to it.  While sweeps come, it takes half of the time at most.
        """
        loop, next_check = asyncio.get_running_loop(), 0.0
        while True:
            await self._changed.wait()
            self._changed.clear()
            self._flags["mapping"] = True
            try:
                survey = self.survey
                await self._map(survey)
                begun = loop.time()
                if not self._changed.is_set() or begun >= next_check:
                    self._put("verdict", await loop.run_in_executor(self._executor, check_map, survey))
                    next_check = 2.0 * loop.time() - begun
            except (EchoplanError, BrokenProcessPool) as error:
                words = (
                    str(error) if isinstance(error, EchoplanError) else "the mapper ended; the next sweep restarts it"
                )
                self.post("mapper", {"problem": words, "sweeps": 0})
            finally:
                self._flags["mapping"] = False

    async def _map(self, survey: Survey) -> None:
        """Map a survey for viewers and for programs beside the page."""
        loop = asyncio.get_running_loop()
        # Before the map, which may take long or fail.
        newest = replace(survey, sweeps=survey.sweeps[-_CHECKED:])
        self.post("faults", faults_message(await loop.run_in_executor(self._executor, sensor_faults, newest)))
        self._put("map", await loop.run_in_executor(self._executor, draw_map, survey))
        self.post("mapper", {"problem": "", "sweeps": len(survey)})
        if self._publish is not None:
            update = await loop.run_in_executor(self._executor, map_update, survey)
            if update is not None:
                self._publish(update)

    def listen(self, loop: asyncio.AbstractEventLoop) -> threading.Thread:
        """Start the thread that waits for the feed."""

        def run() -> None:
            """Hand over the events of the feed until it ends; an error of the feed becomes a notice."""
            try:
                self._hand_over(self._kept(self.feed.events()), loop)
            except EchoplanError as error:
                self._hand_over([Notice(text=str(error), is_problem=True)], loop)

        thread = threading.Thread(target=run, name="echoplan feed", daemon=True)
        thread.start()
        return thread

    def _kept(self, events: Iterable[Event]) -> Iterator[Event]:
        """Keep complete sweeps; one that cannot be kept is shown nevertheless."""
        for event in events:
            if isinstance(event, Complete):
                try:
                    self._keep(event.sweep)
                except EchoplanError as error:
                    yield Notice(text=str(error), is_problem=True)
            yield event

    def _hand_over(self, events: Iterable[Event], loop: asyncio.AbstractEventLoop) -> None:
        for event in events:
            # The loop is closed if the server ended while the feed was reading.
            with suppress(RuntimeError):
                loop.call_soon_threadsafe(self.take, event)

    def _change(self, survey: Survey) -> None:
        self._survey.append(survey)
        self._flags["unsaved"] = True
        self._show_survey()
        self._changed.set()

    def _put(self, topic: str, message: str) -> None:
        self.board[topic] = (self.board.get(topic, (0, ""))[0] + 1, message)

    def _show_survey(self) -> None:
        self.post("stations", stations_message(self.survey))

    def _follow(self, map_from_base: FloatArray) -> None:
        """Show the robot where its last sweep was made, unless a viewer has put it elsewhere since."""
        if self._flags["placed"] and not np.allclose(self._robot[0], map_from_base):
            return
        self._flags["placed"] = False
        self._robot.append(map_from_base)

    def _place(self, command: PlaceCommand) -> None:
        pose = np.array([command.x, command.y, command.yaw])
        if command.station is None:
            self._require(Control.SWEEP)
            self._robot.append(pose)
            self._flags["placed"] = True
            self.feed.place(pose)
            return
        count = len(self.survey.station_poses)
        if command.station >= count:
            raise InputError("place", f"there is no station {command.station + 1}", remedy=f"there are {count}")
        self._change(self.survey.with_station_at(command.station, map_from_base=pose))

    def _require(self, control: Control) -> None:
        if control not in self.feed.controls:
            problem, remedy = _REFUSALS[control]
            raise InputError(str(control), problem, remedy=remedy)
