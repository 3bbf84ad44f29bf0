"""Trials in parallel, each in a process of its own."""

from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor, as_completed
from multiprocessing import active_children, get_context

from echoplan.comparison.trials import Outcome, Trial, measure
from echoplan.signals import end_with_parent

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
    others = active_children()
    pool = ThreadPoolExecutor(max_workers=workers)
    try:
        for done in as_completed([pool.submit(_in_own_process, trial) for trial in trials]):
            yield done.result()
    finally:
        # After an error or a signal, the processes are not waited for.
        pool.shutdown(wait=False, cancel_futures=True)
        for process in active_children():
            if process not in others:
                process.terminate()


def _in_own_process(trial: Trial) -> Outcome:
    with ProcessPoolExecutor(max_workers=1, mp_context=get_context("spawn"), initializer=end_with_parent) as process:
        future = process.submit(measure, trial)
        error = future.exception()
    if error is None:
        return future.result()
    first, *_ = str(error).splitlines() or [""]
    failure = f"{type(error).__name__}: {first}" if first else type(error).__name__
    return Outcome(trial=trial, failure=failure)
