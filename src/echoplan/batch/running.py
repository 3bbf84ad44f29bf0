"""A batch: jobs handed to workers, failures retried and recorded."""

import logging
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor, as_completed
from concurrent.futures.process import BrokenProcessPool

from echoplan.batch.jobs import Job, run_job
from echoplan.batch.rows import Row
from echoplan.errors import EchoplanError

__all__ = ["run_jobs"]

_logger = logging.getLogger(__name__)


def run_jobs(jobs: Sequence[Job], executor: Executor, *, retries: int) -> Iterator[Row]:
    """Run jobs, those that failed once more when all others are done.

    Parameters
    ----------
    jobs : sequence of Job
        What to run.
    executor : Executor
        The workers.
    retries : int
        How many times a job that failed is run again.

    Yields
    ------
    Row
        In the order in which they are ready; the row of a job that failed says why.
    """
    for left in range(retries, -1, -1):
        futures = {executor.submit(run_job, job): job for job in jobs}
        jobs = []
        for future in as_completed(futures):
            job, error = futures.pop(future), future.exception()
            if error is None:
                yield future.result()
                continue
            reason = _in_one_line(error)
            _logger.info("%s: %s%s", job.name, reason, " (will be tried again)" if left else "")
            if left:
                jobs.append(job)
            else:
                yield Row(name=job.name, status="failed", error=reason)


def _in_one_line(error: BaseException) -> str:
    if isinstance(error, BrokenProcessPool):
        return "the process that mapped it was killed, or ran out of memory"
    text = " ".join(str(error).split())
    return text if isinstance(error, EchoplanError) else f"{type(error).__name__}: {text}".rstrip(": ")
