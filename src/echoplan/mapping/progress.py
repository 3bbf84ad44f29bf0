"""How far a long computation is, for whoever watches it."""

from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, nullcontext
from typing import Final, Protocol, TypeVar

__all__ = ["SILENT", "Progress"]

Item = TypeVar("Item")


class Progress(Protocol):
    """What shows progress: bars on a terminal, a widget in a notebook, or nothing."""

    def track(self, items: Iterable[Item], *, total: int, task: str) -> Iterator[Item]:
        """Pass items on and show how many of the total went by."""
        ...

    def busy(self, task: str) -> AbstractContextManager[None]:
        """Show during the block that something is being done whose duration is unknown."""
        ...


class _Silent:
    """Shows nothing."""

    def track(self, items: Iterable[Item], *, total: int, task: str) -> Iterator[Item]:  # noqa: ARG002 - as in Progress
        """Pass items on."""
        return iter(items)

    def busy(self, task: str) -> AbstractContextManager[None]:  # noqa: ARG002 - as in Progress
        """Run the block without showing anything."""
        return nullcontext()


SILENT: Final[Progress] = _Silent()
