"""``echoplan batch`` as a stranger runs it, kills it and runs it again."""

import csv
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path
from shutil import copytree

import pytest

from helpers.typed import echoplan
from library.fleet import METHOD, write_fleet

# Every test starts processes that import echoplan.

COUNT = 10


@pytest.fixture(scope="module")
def fleet(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fleet")
    write_fleet(folder, COUNT)
    return folder


def rows(out: Path) -> list[dict[str, str]]:
    return list(csv.DictReader((out / "batch.csv").read_text(encoding="utf-8").splitlines()))


def states(out: Path) -> dict[Path, tuple[int, int]]:
    """Inode and time of each result that is there: both change if it is written again."""
    files = {path: path.stat() for path in out.glob("maps/*/rec-*/result.json")}
    return {path: (status.st_ino, status.st_mtime_ns) for path, status in files.items()}


@pytest.fixture(scope="module")
def batch(fleet: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str, int]:
    """A fleet of which one recording is broken, mapped: folder of results, output, status."""
    folder = tmp_path_factory.mktemp("batch")
    copytree(fleet / "site-000", folder / "fleet" / "monday")
    (folder / "fleet" / "monday" / "rec-3" / "rig.toml").write_text("name = ", encoding="utf-8")
    done = echoplan("batch", folder / "fleet", "-o", folder / "out", "--method", METHOD, "--jobs", "2")
    assert done.err == ""
    return folder / "out", done.out, done.status


def test_a_broken_recording_is_one_row_and_stops_no_other(batch: tuple[Path, str, int]) -> None:
    out, said, status = batch
    table = rows(out)
    assert [row["name"] for row in table] == [f"monday/rec-{number}" for number in range(10)]
    assert [row["status"] for row in table].count("ok") == 9
    assert "rig.toml" in table[3]["error"]
    assert f"monday/rec-3: {table[3]['error']}" in said
    assert status == 1


def test_maps_and_numbers_are_those_of_each_recording(batch: tuple[Path, str, int]) -> None:
    out, said, _ = batch
    good = [row for row in rows(out) if row["status"] == "ok"]
    assert {(row["sweeps"], row["pings"], row["wall_recall"]) for row in good} == {("5", "80", "1.0")}
    for row in good:
        folder = out / "maps" / row["name"]
        assert {path.name for path in folder.iterdir()} >= {"map.json", "report.html", "run.toml", "result.json"}
    assert "Recordings: 10, of which 0 were mapped before and 1 could not be mapped" in said


def test_parquet_has_the_same_rows(batch: tuple[Path, str, int]) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    table = parquet.read_table(batch[0] / "batch.parquet").to_pylist()
    assert [row["name"] for row in table] == [row["name"] for row in rows(batch[0])]


def test_a_second_run_maps_what_changed_and_what_failed(
    batch: tuple[Path, str, int], fleet: Path, tmp_path: Path
) -> None:
    # In a copy: other tests read the first run.
    out = copytree(batch[0].parent, tmp_path / "copy") / batch[0].name
    folder = out.parent / "fleet" / "monday"
    before = states(out)
    (folder / "rec-3" / "rig.toml").write_bytes((fleet / "site-000" / "rec-3" / "rig.toml").read_bytes())
    os.utime(folder / "rec-5" / "pings.csv")
    done = echoplan("batch", out.parent / "fleet", "-o", out, "--method", METHOD, "--jobs", "1")
    assert (done.status, done.err) == (0, "")
    assert "Recordings: 10, of which 8 were mapped before and 0 could not be mapped" in done.out
    assert {row["status"] for row in rows(out)} == {"ok"}
    changed = {path.parent.name for path, state in states(out).items() if before.get(path) != state}
    assert changed == {"rec-3", "rec-5"}


def test_a_batch_that_is_killed_at_any_moment_goes_on_and_maps_nothing_twice(fleet: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    command = [sys.executable, "-m", "echoplan", "batch", str(fleet), "-o", str(out), "--method", METHOD, "--jobs", "2"]
    chance = random.Random(7)
    finished: dict[Path, tuple[int, int]] = {}
    for least in (1, 5):
        running = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        while len(states(out)) < least:
            assert running.poll() is None, "it ended before it was killed"
            time.sleep(0.02)
        time.sleep(chance.uniform(0.0, 0.5))
        workers = children(running.pid)
        running.kill()
        running.wait()
        wait_until_gone(workers)
        assert finished.items() <= states(out).items()
        finished = states(out)
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert f"Recordings: {COUNT}, of which {len(finished)} were mapped before" in done.stdout
    assert finished.items() <= states(out).items()
    assert len(states(out)) == COUNT
    assert [(row["status"], row["wall_recall"]) for row in rows(out)] == COUNT * [("ok", "1.0")]
    assert not list(out.rglob(".echoplan-*"))


def children(pid: int) -> list[int]:
    listed = Path(f"/proc/{pid}/task/{pid}/children")
    return [int(word) for word in listed.read_text(encoding="ascii").split()] if listed.exists() else []


def wait_until_gone(pids: list[int]) -> None:
    """Workers end by themselves when the batch was killed."""
    deadline = time.monotonic() + 30
    while any(is_running(pid) for pid in pids):
        assert time.monotonic() < deadline, "workers of a batch that was killed go on"
        time.sleep(0.05)


def is_running(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def test_an_interrupt_ends_the_batch_and_its_workers(fleet: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    command = [sys.executable, "-m", "echoplan", "batch", str(fleet), "-o", str(out), "--method", METHOD, "--jobs", "1"]
    running = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    while len(states(out)) < 1:
        assert running.poll() is None
        time.sleep(0.02)
    workers = children(running.pid)
    running.send_signal(signal.SIGINT)
    _, said = running.communicate(timeout=60)
    assert (running.returncode, said) == (130, "")
    wait_until_gone(workers)


def test_bad_words_are_refused_in_one_line(fleet: Path, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    for words, said in (
        ((tmp_path / "empty",), "there is no recording in it"),
        ((tmp_path / "nowhere",), "there is no such folder"),
        ((fleet, "--method", "houg"), "unknown method 'houg'; did you mean 'hough'?"),
        ((fleet, "--method", METHOD, "--scheduler", "localhost"), "it is no address of a dask scheduler"),
    ):
        done = echoplan("batch", *words, "-o", tmp_path / "out")
        assert (done.status, done.err.count("\n")) == (2, 1)
        assert said in done.err
