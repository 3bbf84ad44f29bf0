"""How failures of a batch are retried and recorded."""

import logging
from collections import Counter
from collections.abc import Callable
from concurrent.futures import Executor, Future
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any

import pytest

from echoplan.batch import Job, Row, run_jobs
from echoplan.errors import InputError
from echoplan.settings import Settings

NAMES = ("a", "b", "c")
JOBS = [
    Job(name=name, source=name, folder=Path(name), method="rcd", settings=Settings(), fingerprint="") for name in NAMES
]


class Failing(Executor):
    """Runs nothing: each job fails as often as is said, then it is done."""

    def __init__(self, error: BaseException, **failures: int) -> None:
        self.error, self.failures = error, failures
        self.calls: Counter[str] = Counter()

    def submit(self, _: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        (job,) = args
        self.calls[job.name] += 1
        future: Future[Any] = Future()
        if self.calls[job.name] <= self.failures.get(job.name, 0):
            future.set_exception(self.error)
        else:
            future.set_result(Row(name=job.name, status="ok"))
        return future


def test_a_job_that_failed_once_is_run_again_after_all_others() -> None:
    executor = Failing(OSError("the network is slow"), b=1)
    rows = list(run_jobs(JOBS, executor, retries=1))
    assert [row.status for row in rows] == ["ok", "ok", "ok"]
    assert rows[-1].name == "b"
    assert executor.calls == {"a": 1, "b": 2, "c": 1}


def test_a_job_that_fails_each_time_gets_one_row_with_the_reason(caplog: pytest.LogCaptureFixture) -> None:
    error = InputError("rig.toml", "it is empty", remedy="fill it")
    with caplog.at_level(logging.INFO, "echoplan"):
        rows = {row.name: row for row in run_jobs(JOBS, Failing(error, b=9), retries=1)}
    assert (rows["b"].status, rows["b"].error) == ("failed", "rig.toml: it is empty; fill it")
    assert (rows["a"].status, rows["c"].status) == ("ok", "ok")
    said = "b: rig.toml: it is empty; fill it"
    assert [record.getMessage() for record in caplog.records] == [f"{said} (will be tried again)", said]


def test_nothing_is_tried_again_without_retries() -> None:
    executor = Failing(ValueError("no"), a=1)
    assert [row.status for row in run_jobs(JOBS, executor, retries=0)].count("failed") == 1
    assert executor.calls == {"a": 1, "b": 1, "c": 1}


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (ZeroDivisionError("division\nby zero"), "ZeroDivisionError: division by zero"),
        (MemoryError(), "MemoryError"),
        (BrokenProcessPool("anything"), "the process that mapped it was killed, or ran out of memory"),
    ],
)
def test_any_error_is_one_line(error: BaseException, said: str) -> None:
    failed = [row for row in run_jobs(JOBS, Failing(error, a=1), retries=0) if row.status == "failed"]
    assert [row.error for row in failed] == [said]
