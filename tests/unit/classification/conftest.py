import pytest

from echoplan.preprocessing.soundings import Soundings
from expectations import ROOM, hearing, listening


@pytest.fixture(scope="module")
def room() -> Soundings:
    """A room without noise."""
    return hearing(listening(), ROOM)
