import pytest

from echoplan.preprocessing.measurements import Measurements
from helpers.expectations import ROOM, hearing, listening


@pytest.fixture(scope="module")
def room() -> Measurements:
    """A room without noise."""
    return hearing(listening(), ROOM)
