import pytest

from echoplan.preprocessing.measurements import Measurements
from helpers.expectations import ROOM, listening, pings_of


@pytest.fixture(scope="module")
def room() -> Measurements:
    """Return noiseless measurements in a room."""
    return pings_of(listening(), ROOM)
