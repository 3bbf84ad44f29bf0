import pytest

from echoplan.preprocessing.measurements import Measurements
from helpers.expectations import ROOM, hearing, listening


@pytest.fixture(scope="module")
def room() -> Measurements:
    """Return noiseless measurements in a room."""
    return hearing(listening(), ROOM)
