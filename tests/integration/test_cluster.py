"""``echoplan batch --scheduler``: a dask scheduler and workers in processes of their own, on loopback."""

import csv
import json
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from library.fleet import METHOD, write_fleet

pytest.importorskip("distributed", reason="the extra cluster is not installed")
# Every test starts processes that import echoplan and distributed.

COUNT = 8
PATIENCE = 180.0  # for processes to start on a busy machine [s]


@contextmanager
def dask(*words: str) -> Iterator[subprocess.Popen[bytes]]:
    process = subprocess.Popen(
        [sys.executable, "-m", "dask", *words, "--no-dashboard", "--host", "127.0.0.1"],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        yield process
    finally:
        process.kill()
        process.wait()


@pytest.fixture
def scheduler(tmp_path: Path) -> Iterator[tuple[subprocess.Popen[bytes], str]]:
    """A scheduler on a free port: its process and its address."""
    file = tmp_path / "scheduler.json"
    with dask("scheduler", "--port", "0", "--scheduler-file", str(file)) as process:
        deadline = time.monotonic() + PATIENCE
        # The file may be there before it is written.
        while not (file.exists() and file.read_text(encoding="utf-8").rstrip().endswith("}")):
            assert time.monotonic() < deadline
            time.sleep(0.05)
        yield process, json.loads(file.read_text(encoding="utf-8"))["address"]


def worker(address: str) -> list[str]:
    return ["worker", address, "--nthreads", "1", "--no-nanny"]


@pytest.fixture(scope="module")
def fleet(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fleet")
    write_fleet(folder, COUNT)
    return folder


def command(fleet: Path, out: Path, address: str) -> list[str]:
    words = ["batch", str(fleet), "-o", str(out), "--method", METHOD, "--scheduler", address]
    return [sys.executable, "-m", "echoplan", *words]


def wait_for_results(out: Path, least: int) -> None:
    deadline = time.monotonic() + PATIENCE
    while len(list(out.glob("maps/*/rec-*/result.json"))) < least:
        assert time.monotonic() < deadline
        time.sleep(0.05)


def test_recordings_of_a_worker_that_is_killed_are_mapped_by_the_others(
    scheduler: tuple[subprocess.Popen[bytes], str], fleet: Path, tmp_path: Path
) -> None:
    _, address = scheduler
    out = tmp_path / "out"
    with dask(*worker(address)) as first, dask(*worker(address)):
        running = subprocess.Popen(
            command(fleet, out, address), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        wait_for_results(out, 2)
        first.kill()
        said, errors = running.communicate(timeout=PATIENCE)
    assert (running.returncode, errors) == (0, "")
    assert f"Recordings: {COUNT}, of which 0 were mapped before and 0 could not be mapped" in said
    rows = list(csv.DictReader((out / "batch.csv").read_text(encoding="utf-8").splitlines()))
    assert [(row["status"], row["wall_recall"]) for row in rows] == COUNT * [("ok", "1.0")]


def test_a_batch_whose_scheduler_ends_says_so_in_one_line_and_goes_on_later(
    scheduler: tuple[subprocess.Popen[bytes], str], fleet: Path, tmp_path: Path
) -> None:
    process, address = scheduler
    out = tmp_path / "out"
    with dask(*worker(address)):
        running = subprocess.Popen(
            command(fleet, out, address), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        wait_for_results(out, 1)
        process.kill()
        _, errors = running.communicate(timeout=PATIENCE)
    assert running.returncode == 2
    assert errors.startswith(f"echoplan: {address}: the dask scheduler ended; ")
    assert errors.count("\n") == 1
    assert list(out.glob("maps/*/rec-*/result.json"))


def test_a_scheduler_that_is_not_there_is_refused_in_one_line(
    fleet: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from echoplan.batch import cluster  # noqa: PLC0415
    from helpers.typed import echoplan  # noqa: PLC0415

    monkeypatch.setattr(cluster, "_PATIENCE", 1)
    done = echoplan("batch", fleet, "-o", tmp_path / "out", "--method", METHOD, "--scheduler", "tcp://127.0.0.1:1")
    assert (done.status, done.err.count("\n")) == (2, 1)
    assert done.err.startswith("echoplan: tcp://127.0.0.1:1: no dask scheduler answers there; ")
