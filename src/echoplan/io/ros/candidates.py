"""Fields of messages of any type that may hold ranges, by their names."""

import re
from collections.abc import Iterator
from itertools import islice
from typing import Any

import numpy as np

from echoplan.errors import InputError
from echoplan.io.ros.bag import Bag
from echoplan.io.ros.messages import LASER_SCAN, POSES, RANGE, TRANSFORMS

__all__ = ["range_candidates"]

_NAMES = re.compile("range|dist|echo|sonar|ultraso", re.IGNORECASE)
# Types that echoplan reads have no other ranges.
_UNDERSTOOD = (RANGE, LASER_SCAN, *POSES, *TRANSFORMS)


def range_candidates(bag: Bag) -> tuple[str, ...]:
    """Name the numeric fields whose topic or name suggests a range, as ``--field range=`` takes them."""
    found: list[str] = []
    for topic in bag.topics:
        if topic.type in _UNDERSTOOD:
            continue
        try:
            for message in islice(bag.messages([topic]), 1):
                found += [path for path in _numbers(message.body, topic.name) if _NAMES.search(path)]
        except InputError:
            # A topic that cannot be decoded has no candidates; the others may have.
            continue
    return tuple(found)


def _numbers(value: Any, path: str) -> Iterator[str]:
    """Yield the paths of all numbers inside a message; of an array that of its first."""
    for name in getattr(value, "__dataclass_fields__", ()):
        inner = getattr(value, name)
        if isinstance(inner, (int, float, np.number)):
            yield f"{path}.{name}"
        elif isinstance(inner, np.ndarray) and len(inner):
            yield f"{path}.{name}[0]"
        elif name != "header":
            yield from _numbers(inner, f"{path}.{name}")
