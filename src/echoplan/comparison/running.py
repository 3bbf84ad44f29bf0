"""Trials in parallel, each in a process of its own."""

from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor, as_completed
from multiprocessing import get_context

from echoplan.comparison.trials import Outcome, Trial, measure

__all__ = ["run_trials"]


def run_trials(trials: Iterable[Trial], *, workers: int) -> Iterator[Outcome]:
    """Run trials in parallel.

    Every trial has a fresh process: its peak memory is its own, and one that breaks down, even by a signal, takes
    no other along.

    Parameters
    ----------
    trials : iterable of Trial
        What to try.
    workers : int
        How many processes at a time.

    Yields
    ------
    Outcome
        In the order in which they are ready; a trial that failed says why.
    """
    with ThreadPoolExecutor(max_workers=workers) as pool:
        for done in as_completed([pool.submit(_in_own_process, trial) for trial in trials]):
            yield done.result()


def _in_own_process(trial: Trial) -> Outcome:
    with ProcessPoolExecutor(max_workers=1, mp_context=get_context("spawn")) as process:
        future = process.submit(measure, trial)
        error = future.exception()
    return future.result() if error is None else Outcome(trial=trial, failure=_in_one_line(error))


def _in_one_line(error: BaseException) -> str:
    first, *_ = str(error).splitlines() or [""]
    return f"{type(error).__name__}: {first}" if first else type(error).__name__
