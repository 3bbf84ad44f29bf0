import pytest

from echoplan.preprocessing.ping_arrays import Soundings
from helpers.expectations import ROOM, hearing, listening


@pytest.fixture(scope="module")
def room() -> Soundings:
    """A room without noise."""
    return hearing(listening(), ROOM)
