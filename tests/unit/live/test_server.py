"""The server and its live_map, with viewers that are no browsers and a mapper that maps nothing."""

import asyncio
import json
import urllib.error
import urllib.request
from collections.abc import AsyncIterator, Callable
from concurrent.futures import Executor, Future
from contextlib import asynccontextmanager
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from echoplan.errors import InputError, OutputError
from echoplan.live import Complete, Notice, Partial
from echoplan.live.access import Access
from echoplan.live.live_map import LiveMap
from echoplan.live.mapping import check_map, sensor_faults
from echoplan.live.server import LiveServer
from echoplan.live.survey import Survey
from echoplan.model import Sweep
from echoplan.preprocessing import Faults
from helpers.fed import FakeFeed, swept

websockets = pytest.importorskip("websockets.asyncio.client", reason="the extra view is not installed")
from websockets.exceptions import InvalidStatus  # noqa: E402


class Drawn(Executor):
    """Draws and checks each survey as the number of its sweeps, finds no fault, and saves one file."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **_: Any) -> Future[Any]:
        done: Future[Any] = Future()
        if isinstance(fn, partial):
            fn.keywords["archive"].write_bytes(b"all of it")
            done.set_result(())
        elif fn is sensor_faults:
            done.set_result(Faults())
        else:
            (survey,) = args
            assert isinstance(survey, Survey)
            done.set_result(json.dumps({"topic": "verdict" if fn is check_map else "map", "sweeps": len(survey)}))
        return done


class Bench:
    """A running server and its live_map."""

    def __init__(self, live_map: LiveMap, address: str) -> None:
        self.live_map = live_map
        self.address = address

    def connect(self, query: str = "", **options: Any) -> Any:
        return websockets.connect(
            f"ws://{self.address}/ws{query}", **({"origin": f"http://{self.address}", "close_timeout": 0.1} | options)
        )

    async def status_of(self, path: str, method: str = "GET") -> tuple[int, bytes, Any]:
        def ask() -> tuple[int, bytes, Any]:
            request = urllib.request.Request(f"http://{self.address}{path}", method=method)
            try:
                with urllib.request.urlopen(request, timeout=5) as answer:
                    return answer.status, answer.read(), answer.headers
            except urllib.error.HTTPError as error:
                with error:
                    return error.code, error.read(), error.headers

        return await asyncio.to_thread(ask)


@asynccontextmanager
async def bench(tmp_path: Path, *, token: str = "", feed: FakeFeed | None = None) -> AsyncIterator[Bench]:
    live_map = LiveMap(feed or FakeFeed(), executor=Drawn(), scratch=tmp_path)
    server = LiveServer(live_map, access=Access(token=token))
    async with server.serve(host="127.0.0.1", port=0) as listening:
        mapping = asyncio.create_task(live_map.keep_mapping())
        host, port = listening.sockets[0].getsockname()[:2]
        yield Bench(live_map, f"{host}:{port}")
        mapping.cancel()


async def topic(
    viewer: Any, name: str, *, where: Callable[[dict[str, Any]], bool] = lambda message: True
) -> dict[str, Any]:
    """Wait for a message of a topic."""
    async with asyncio.timeout(5):
        while True:
            message: dict[str, Any] = json.loads(await viewer.recv())
            if message["topic"] == name and where(message):
                return message


def place(x: float, y: float, yaw: float = 0.0, **more: object) -> str:
    return json.dumps({"type": "place", "x": x, "y": y, "yaw": yaw, **more})


def test_the_page_is_one_file_that_loads_nothing_else(tmp_path: Path) -> None:
    async def run() -> None:
        async with bench(tmp_path) as here:
            status, body, headers = await here.status_of("/")
            assert status == 200
            assert headers["Content-Type"].startswith("text/html")
            assert "default-src 'none'" in headers["Content-Security-Policy"]
            text = body.decode()
            assert "frames_seen" in text
            assert not any(word in text for word in ('src="', "@import", "https://", '<link rel="stylesheet"'))

    asyncio.run(run())


@pytest.mark.parametrize(
    ("path", "method", "status"),
    [
        ("/other", "GET", 404),
        ("/saved/echoplan.zip", "GET", 404),
        ("/saved/../page.html", "GET", 404),
        ("/undo", "GET", 404),
        ("/", "POST", 405),
    ],
)
def test_no_other_request_is_answered(tmp_path: Path, path: str, method: str, status: int) -> None:
    async def run() -> None:
        async with bench(tmp_path) as here:
            here.live_map.take(Complete(sweep=swept()))
            answer = await here.status_of(path, method)
            assert answer[0] == status
            assert len(here.live_map.survey) == 1

    asyncio.run(run())


def test_a_page_of_another_origin_gets_no_connection(tmp_path: Path) -> None:
    async def run() -> None:
        async with bench(tmp_path) as here:
            for origin in (None, "http://evil.example"):
                with pytest.raises(InvalidStatus, match="403"):
                    await here.connect(origin=origin)

    asyncio.run(run())


def test_with_a_token_neither_page_nor_connection_is_had_without_it(tmp_path: Path) -> None:
    async def run() -> None:
        async with bench(tmp_path, token="right") as here:
            assert (await here.status_of("/"))[0] == 401
            assert (await here.status_of("/?token=right"))[0] == 200
            with pytest.raises(InvalidStatus, match="401"):
                await here.connect("?token=wrong")
            async with here.connect("?token=right") as viewer:
                assert (await topic(viewer, "hello"))["name"] == "bench"

    asyncio.run(run())


def test_a_new_viewer_sees_everything_and_then_what_changes(tmp_path: Path) -> None:
    async def run() -> None:
        async with bench(tmp_path) as here, here.connect() as viewer:
            assert [each["id"] for each in (await topic(viewer, "hello"))["sensors"]] == [0, 1, 2, 3]
            here.live_map.take(Partial(sweep=swept()[:40]))
            frame = await topic(viewer, "frame", where=lambda message: "sweep" in message)
            assert (frame["sweep"]["pings"], frame["sweep"]["is_complete"]) == (40, False)
            here.live_map.take(Complete(sweep=swept(pose=(1.0, 2.0, 0.0))))
            stations = await topic(viewer, "stations", where=lambda message: bool(message["stations"]))
            assert stations["stations"][0]["pose"] == [1.0, 2.0, 0.0]
            await topic(viewer, "map", where=lambda message: message["sweeps"] == 1)
            here.live_map.take(Notice(text="The cable was unplugged.", is_problem=True))
            assert (await topic(viewer, "notice"))["is_problem"]
            async with here.connect() as second:
                assert (await topic(second, "map"))["sweeps"] == 1

    asyncio.run(run())


def test_viewers_place_sweep_pause_and_undo(tmp_path: Path) -> None:
    async def run() -> None:
        feed = FakeFeed()
        async with bench(tmp_path, feed=feed) as here, here.connect() as viewer, here.connect() as other:
            for number in range(2):
                here.live_map.take(Complete(sweep=swept(pose=(float(number), 0.0, 0.0))))
            await viewer.send(place(5.0, 6.0, 0.5, station=1))

            def is_moved(message: dict[str, Any]) -> bool:
                return [each["pose"] for each in message["stations"]] == [[0.0, 0.0, 0.0], [5.0, 6.0, 0.5]]

            await topic(other, "stations", where=is_moved)
            await viewer.send('{"type": "undo"}')
            await topic(other, "stations", where=lambda message: len(message["stations"]) == 1)
            await viewer.send(place(0.1, 0.2))
            await viewer.send('{"type": "sweep"}')
            await viewer.send('{"type": "play", "playing": false}')
            frame = await topic(other, "frame", where=lambda message: not message["playing"])
            assert frame["robot"] == [0.1, 0.2, 0.0]
            assert feed.asked == [[0.1, 0.2, 0.0], [0.1, 0.2, 0.0], "sweep", False]
            # A sweep from another place does not move the robot that a viewer has put somewhere.
            here.live_map.take(Complete(sweep=swept(pose=(9.0, 0.0, 0.0))))
            frame = await topic(other, "frame", where=lambda message: message["sweep"]["pose"][0] == 9.0)
            assert frame["robot"] == [0.1, 0.2, 0.0]

    asyncio.run(run())


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ('{"type": "undo"}', "there is no station yet"),
        ('{"type": "save"}', "there is no station yet"),
        ('{"type": "sweep"}', "a recording cannot make new sweeps"),
        ('{"type": "play", "playing": false}', "this device does not drive a route"),
        (place(0.0, 0.0), "a recording cannot make new sweeps"),
        (place(0.0, 0.0, station=0), "there is no station 1"),
        ("nonsense", "command"),
    ],
)
def test_what_cannot_be_done_is_answered_in_one_line(tmp_path: Path, command: str, words: str) -> None:
    async def run() -> None:
        feed = FakeFeed(frozenset())
        async with bench(tmp_path, feed=feed) as here, here.connect() as viewer, here.connect() as other:
            await viewer.send(command)
            text = (await topic(viewer, "refused"))["text"]
            assert words in text
            assert "\n" not in text
            await topic(other, "frame")

    asyncio.run(run())


def test_what_was_saved_can_be_downloaded(tmp_path: Path) -> None:
    async def run() -> None:
        async with bench(tmp_path) as here, here.connect() as viewer:
            here.live_map.take(Complete(sweep=swept()))
            assert here.live_map.has_unsaved
            await viewer.send('{"type": "save"}')
            assert (await topic(viewer, "saved"))["files"] == ["echoplan.zip"]
            status, body, headers = await here.status_of("/saved/echoplan.zip")
            assert (status, body) == (200, b"all of it")
            assert headers["Content-Disposition"] == 'attachment; filename="echoplan.zip"'
            assert not here.live_map.has_unsaved

    asyncio.run(run())


def test_a_sweep_is_kept_before_it_is_shown_and_shown_although_it_cannot_be_kept(tmp_path: Path) -> None:
    async def run() -> None:
        feed, kept = FakeFeed(), list[Sweep]()

        def keep(sweep: Sweep) -> None:
            assert len(live_map.survey) == len(kept)
            kept.append(sweep)
            raise OutputError("disk", "it is full", remedy="free some space")

        live_map = LiveMap(feed, executor=Drawn(), scratch=tmp_path, keep=keep)
        thread = live_map.listen(asyncio.get_running_loop())
        feed.waiting.put(Complete(sweep=swept()))
        async with asyncio.timeout(5):
            while not len(live_map.survey):
                await asyncio.sleep(0.01)
        assert [each.station.tolist() for each in kept] == [[0.0, 0.0, 0.0]]
        assert "it is full" in live_map.board["notice"][1]
        feed.close()
        await asyncio.to_thread(thread.join, 5)

    asyncio.run(run())


def test_a_viewer_that_reads_nothing_slows_no_other_and_gets_the_newest_state_later(tmp_path: Path) -> None:
    async def run() -> None:
        async with bench(tmp_path) as here, here.connect(max_queue=1) as slow, here.connect() as quick:
            here.live_map.take(Complete(sweep=swept()))
            # Much more than the buffers of the connection hold.
            for number in range(10):
                here.live_map.post("padding", {"number": number, "text": "x" * 500_000})
                await topic(quick, "padding", where=lambda message, wanted=number: message["number"] == wanted)  # type: ignore[misc]
            seen = list[int]()
            async with asyncio.timeout(5):
                while 9 not in seen:
                    message = json.loads(await slow.recv())
                    seen += [message["number"]] if message["topic"] == "padding" else []
            assert len(seen) < 10

    asyncio.run(run())


def test_a_viewer_that_reads_nothing_does_not_keep_the_server_from_ending(tmp_path: Path) -> None:
    async def run() -> None:
        async with asyncio.timeout(5):
            async with bench(tmp_path) as here:
                slow = await here.connect(max_queue=1)
                for number in range(20):
                    here.live_map.post(f"padding {number}", {"text": "x" * 500_000})
                await asyncio.sleep(0.3)
        await slow.close()

    asyncio.run(run())


def test_a_port_that_is_taken_is_refused_with_a_remedy(tmp_path: Path) -> None:
    async def run() -> None:
        async with bench(tmp_path) as here:
            port = int(here.address.rpartition(":")[2])
            other = LiveServer(here.live_map, access=Access())
            with pytest.raises(InputError, match=rf"--port {port}: another program uses this port; name another"):
                async with other.serve(host="127.0.0.1", port=port):
                    pass
            with pytest.raises(InputError, match=r"--host 192\.0\.2\.1"):
                async with other.serve(host="192.0.2.1", port=0):
                    pass

    asyncio.run(run())
