"""``echoplan live`` in a real browser: what a viewer sees and does."""

import csv
import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from time import monotonic
from typing import Any

import numpy as np
import pytest

from helpers.typed import echoplan

CHROMIUM = shutil.which("chromium")
sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed (group browser)")
pytest.importorskip("websockets", reason="websockets is not installed (extra view)")
pytestmark = [
    pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed (Debian package chromium)"),
]
STATIONS = 5
# The first map of a process waits for compiled code.
PATIENCE_MS = 120_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Live:
    """A server that has played the square, and where it saves."""

    address: str
    out: Path
    process: subprocess.Popen[str]


def started(*words: str | Path) -> tuple[subprocess.Popen[str], str]:
    """Start a server as a shell does, and wait until its page can be opened."""
    process = subprocess.Popen(
        [sys.executable, "-m", "echoplan", "live", *map(str, words), "--port", "0"],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "DISPLAY": "", "BROWSER": "false"},
    )
    assert process.stdout
    found = re.search(r"http://\S+", process.stdout.readline())
    assert found
    return process, found[0]


@pytest.fixture(scope="module")
def live(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Live]:
    out = tmp_path_factory.mktemp("live") / "out"
    process, address = started("sim:square", "--speed", "8", "--out", out)
    with process:
        yield Live(address=address, out=out, process=process)
        process.terminate()


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with sync_api.sync_playwright() as playwright:
        launched = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield launched
        launched.close()


@pytest.fixture
def page(live: Live, browser: Any) -> Iterator[Any]:
    """A page that shows all stations of the route; errors in its script fail the test."""
    opened = browser.new_page(viewport={"width": 1200, "height": 800})
    errors = list[str]()
    opened.set_default_timeout(PATIENCE_MS)
    opened.on("pageerror", lambda error: errors.append(str(error)))
    opened.goto(live.address)
    until(opened, f"document.querySelectorAll('.station').length >= {STATIONS}")
    yield opened
    opened.close()
    assert not errors


def until(page: Any, condition: str) -> None:
    """Wait until a condition holds: the page forbids the evaluation of text, by which playwright would wait."""
    deadline = monotonic() + PATIENCE_MS / 1000
    while not page.evaluate(condition):
        assert monotonic() < deadline, condition
        page.wait_for_timeout(100)


def rest(page: Any) -> None:
    """Wait until the map shows all sweeps: before, a new one may move the view while the mouse is on its way."""
    sweeps = "news.stations.stations.reduce((sum, each) => sum + each.sweeps, 0)"
    until(page, f"!gliding && !news.frame.mapping && news.mapper.sweeps === {sweeps}")


def count(page: Any) -> int:
    found: int = page.locator(".station").count()
    return found


def test_the_page_shows_ten_frames_a_second(page: Any) -> None:
    before = page.evaluate("window.frames_seen")
    page.wait_for_timeout(3000)
    assert page.evaluate("window.frames_seen") - before >= 20


def test_the_map_has_four_walls_and_a_verdict(page: Any) -> None:
    until(page, "document.querySelectorAll('#walls .face').length >= 4")
    page.wait_for_selector(".verdict.good", timeout=PATIENCE_MS)
    assert page.locator(".sensor").count() == 4
    # Another test may have moved a station just before.
    until(page, "document.querySelector('#facts').innerText.includes('4 walls')")


def drag(page: Any, what: str, *, right: float, up: float) -> list[float]:
    """Drag something on the map by so many pixels; return by how many metres that is."""
    rest(page)
    box = page.locator(what).bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + right / 2, y - up / 2, steps=3)
    page.mouse.move(x + right, y - up, steps=3)
    metres: float = page.evaluate("1 / view.scale")
    page.mouse.up()
    return [right * metres, up * metres]


def test_a_station_placed_by_dragging_appears_in_what_is_saved_and_downloaded(
    page: Any, live: Live, tmp_path: Path
) -> None:
    before, start = count(page), page.evaluate("state.robot")
    moved = drag(page, "#robot .hull", right=30, up=-40)
    page.locator("#sweep").click()
    until(page, f"news.stations.stations.length === {before + 1}")
    page.locator("#save").click()
    page.wait_for_selector("#plan-pdf", timeout=PATIENCE_MS)
    with (live.out / "recording" / "pings.csv").open(encoding="utf-8") as file:
        row = next(row for row in csv.DictReader(file) if row["sweep"] == str(before))
    assert [float(row["x"]), float(row["y"])] == pytest.approx(np.add(start[:2], moved), abs=0.02)
    beginnings = {"#plan-pdf": b"%PDF-", "#plan-png": b"\x89PNG", "#plan-svg": b"<svg", "#archive": b"PK"}
    for link, beginning in beginnings.items():
        with page.expect_download() as waiting:
            page.locator(link).click()
        path = tmp_path / waiting.value.suggested_filename
        waiting.value.save_as(path)
        assert path.read_bytes().startswith(beginning)
    shutil.unpack_archive(tmp_path / "echoplan.zip", tmp_path / "all")
    for folder in (live.out, tmp_path / "all"):
        assert {"map.json", "report.html", "floor-plan.pdf"} <= {each.name for each in folder.iterdir()}
    assert echoplan("info", tmp_path / "all" / "recording").status == 0
    page.locator("#undo").click()
    until(page, f"news.stations.stations.length === {before}")


def test_a_station_is_moved_by_dragging_and_back_by_typing(page: Any) -> None:
    start = page.evaluate("news.stations.stations[1].pose")
    moved = drag(page, "#station-1 .ring", right=10, up=6)
    until(page, f"news.stations.stations[1].pose[0] !== {start[0]}")
    assert page.evaluate("news.stations.stations[1].pose") == pytest.approx(
        [*np.add(start[:2], moved), start[2]], abs=0.01
    )
    page.locator("#which").select_option("1")
    page.locator("#x").fill(f"{100 * start[0]:.2f} cm".replace(".", ","))
    page.locator("#y").fill(f"{100 * start[1]:.2f}")
    page.locator("#place").click()
    apart = " + ".join(f"Math.abs(news.stations.stations[1].pose[{axis}] - {start[axis]})" for axis in (0, 1))
    until(page, f"{apart} < 1e-3")


def test_a_sweep_is_made_where_the_robot_was_put_and_undone(page: Any) -> None:
    before = count(page)
    page.locator("#which").select_option("robot")
    for name, value in (("x", "30"), ("y", "-20"), ("heading", "90°")):
        page.locator(f"#{name}").fill(value)
    page.locator("#heading").press("Enter")
    page.locator("#sweep").click()
    until(page, f"document.querySelectorAll('.station').length === {before + 1}")
    assert page.evaluate("news.stations.stations.at(-1).pose") == pytest.approx([0.3, -0.2, 1.5708], abs=1e-4)
    page.locator("#undo").click()
    until(page, f"document.querySelectorAll('.station').length === {before}")


def test_a_phone_shows_all_of_it_in_one_column(page: Any, tmp_path: Path) -> None:
    page.set_viewport_size({"width": 400, "height": 800})
    page.wait_for_timeout(300)
    assert page.evaluate("document.documentElement.scrollWidth") <= 400
    for name in ("#map", "#sweep", "#pause", "#undo", "#save", "#verdict", "#polar", "#sensors", "#form"):
        box = page.locator(name).bounding_box()
        assert box["x"] >= 0
        assert 0 < box["width"] <= 400
        assert box["x"] + box["width"] <= 400
    for name in ("#sweep", "#pause", "#undo", "#save"):
        assert page.locator(name).bounding_box()["height"] >= 36
    page.screenshot(path=tmp_path / "phone.png", full_page=True)
    assert (tmp_path / "phone.png").stat().st_size > 10_000


def test_on_a_phone_a_station_is_dragged_once_it_is_chosen(page: Any, live: Live, browser: Any) -> None:
    context = browser.new_context(viewport={"width": 400, "height": 800}, has_touch=True, is_mobile=True)
    phone = context.new_page()
    phone.goto(live.address)
    until(phone, f"document.querySelectorAll('.station').length === {count(page)}")
    fingers = context.new_cdp_session(phone)
    start = phone.evaluate("news.stations.stations[2].pose")
    seen = []
    for _ in range(2):
        rest(phone)
        box = phone.locator("#station-2 .ring").bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        for kind, shift in (("touchStart", 0), *(("touchMove", 4 * step) for step in range(1, 6)), ("touchEnd", None)):
            points = [] if shift is None else [{"x": x + shift, "y": y}]
            fingers.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
        phone.wait_for_timeout(300)
        seen.append(phone.evaluate("news.stations.stations[2].pose"))
    assert seen[0] == start
    assert seen[1][0] - start[0] == pytest.approx(20 * phone.evaluate("1 / view.scale"), rel=0.2)
    x, y, yaw = start
    phone.evaluate(f"send(2, [{x}, {y}, {yaw}])")
    until(page, f"news.stations.stations[2].pose[0] === {x}")
    context.close()


def test_a_second_viewer_sees_the_same_and_what_the_first_does(page: Any, live: Live, browser: Any) -> None:
    second = browser.new_page()
    second.goto(live.address)
    until(second, f"document.querySelectorAll('.station').length === {count(page)}")
    page.locator("#pause").click()
    second.wait_for_selector(".link.paused")
    second.locator("#pause").click()
    page.wait_for_selector(".link:not(.paused)")
    second.close()
    before = page.evaluate("window.frames_seen")
    until(page, f"window.frames_seen > {before + 2}")


def test_a_dropped_connection_comes_back(page: Any) -> None:
    page.evaluate(
        "window.words = []; window.before = socket;"
        "new MutationObserver(() => words.push(document.getElementById('link').textContent))"
        ".observe(document.getElementById('link'), {childList: true, characterData: true, subtree: true});"
        "socket.close()"
    )
    until(page, "socket !== window.before && socket.readyState === 1 && !state.lost")
    assert any("connection lost" in words for words in page.evaluate("window.words"))
    before = page.evaluate("window.frames_seen")
    until(page, f"window.frames_seen > {before + 2}")


def test_an_interrupt_ends_it_cleanly(tmp_path: Path) -> None:
    process, _ = started("sim:square", "--speed", "1000", "--out", tmp_path / "out")
    with process:
        assert process.stdout
        process.stdout.readline()
        process.send_signal(signal.SIGINT)
        assert process.stdout.read() == ""
        assert process.wait(20) == 0


def test_a_source_that_is_none_is_refused_in_one_line() -> None:
    done = echoplan("live", "sim:nowhere")
    assert (done.status, done.out) == (2, "")
    assert done.err.count("\n") == 1
    assert "unknown world" in done.err
