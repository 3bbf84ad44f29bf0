import numpy as np
import pytest

from echoplan.classical.covering import Covering, covering_state
from helpers import scenes


@pytest.mark.parametrize(
    ("right", "left", "state"),
    [
        (np.inf, np.inf, Covering.NONE),
        (2.0, 1.5, Covering.NONE),
        (np.inf, 0.5, Covering.LEFT),
        (0.5, np.inf, Covering.RIGHT),
        (0.5, 0.7, Covering.FRONT),
    ],
)
def test_only_a_nearer_echo_covers_an_end(right: float, left: float, state: Covering) -> None:
    bearings = scenes.around(0.0, 0.2)
    assert covering_state(scenes.cluster(bearings, np.ones(len(bearings)), right=right, left=left)) is state


def test_the_echo_at_the_very_end_decides() -> None:
    bearings = scenes.around(0.0, 0.2)
    ranges = np.linspace(1.0, 1.2, len(bearings))
    between = 1.1 + scenes.ARM
    assert covering_state(scenes.cluster(bearings, ranges, right=between, left=between)) is Covering.LEFT
