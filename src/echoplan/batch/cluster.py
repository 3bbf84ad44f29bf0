"""Workers of a dask cluster."""

import logging
import os
from collections.abc import Iterator, Sequence
from concurrent.futures import CancelledError, Executor
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from echoplan.errors import InputError, MissingExtraError
from echoplan.version import __version__

if TYPE_CHECKING:
    from distributed import Client

__all__ = ["cluster_executor"]

# Time for the scheduler to answer and for the first worker to be there [s]: both are started by hand before.
_PATIENCE = 30


@contextmanager
def cluster_executor(address: str, *, shared: Sequence[Path]) -> Iterator[Executor]:
    """Use the workers of a dask cluster.

    Work of a worker that is killed is done by the others, and workers may join at any time.

    Parameters
    ----------
    address : str
        Address of the scheduler: ``tcp://host:8786``.
    shared : sequence of Path
        Folders that all workers must see under the same absolute paths.

    Yields
    ------
    Executor
        It hands calls to the scheduler.

    Raises
    ------
    MissingExtraError
        If distributed is not installed.
    InputError
        If no scheduler answers, it has no workers, or a worker has another echoplan or does not see a folder; later, if
        the scheduler ends.
    """
    try:
        from distributed import Client  # noqa: PLC0415 - an optional package
        from distributed.comm.core import CommClosedError  # noqa: PLC0415
    except ImportError as error:
        raise MissingExtraError("distributed", extra="cluster") from error
    # It warns of each worker that was lost: what becomes of the work is said by whoever asked for it.
    for name in ("distributed", "distributed.client", "tornado.application"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    if "://" not in address:
        raise InputError(address, "it is no address of a dask scheduler", remedy="write tcp://HOST:8786")
    try:
        client = Client(address, timeout=_PATIENCE, set_as_default=False)  # type: ignore[no-untyped-call]
    except (OSError, ValueError) as error:
        remedy = "start one with: dask scheduler, and use the address that it prints"
        raise InputError(address, "no dask scheduler answers there", remedy=remedy) from error
    with client:
        try:
            _check_workers(client, [path.absolute() for path in shared])
            yield client.get_executor()  # type: ignore[no-untyped-call]
        except (CancelledError, CommClosedError) as error:
            remedy = "start it and the workers, then run the same command again: what is finished is kept"
            raise InputError(address, "the dask scheduler ended", remedy=remedy) from error


def _check_workers(client: "Client", shared: Sequence[Path]) -> None:
    try:
        client.wait_for_workers(1, timeout=_PATIENCE)
    except TimeoutError as error:
        address = client.scheduler_info()["address"]
        remedy = f"start some with: dask worker {address} --nthreads 1"
        raise InputError(address, "the scheduler has no workers", remedy=remedy) from error
    for worker, found in client.run(_look, [*map(str, shared)], on_error="return").items():
        if isinstance(found, BaseException):
            remedy = f"install echoplan {__version__} in its environment"
            raise InputError(worker, f"this worker cannot import echoplan: {found}", remedy=remedy)
        version, missing = found
        if version != __version__:
            raise InputError(worker, f"this worker has echoplan {version}", remedy=f"install {__version__} there")
        if missing:
            remedy = "mount it there under the same path: workers read recordings and write maps themselves"
            raise InputError(worker, f"this worker does not see the folder {missing[0]}", remedy=remedy)


def _look(folders: list[str]) -> tuple[str, list[str]]:
    """Return the version of echoplan in this process, and the folders that it does not see."""
    return __version__, [folder for folder in folders if not os.path.isdir(folder)]  # noqa: PTH112
