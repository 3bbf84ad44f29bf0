"""Passes of a servo: it turns back, flies back, or turns all round."""

import numpy as np
import pytest

from echoplan.io.passes import pass_starts


@pytest.mark.parametrize(
    ("angles", "lengths"),
    [
        pytest.param([*range(-90, 91, 10), *range(80, -91, -10)], [19, 18], id="to and fro"),
        pytest.param([*range(-90, 91, 10), 90, *range(90, -91, -10)], [20, 19], id="to and fro with a pause"),
        pytest.param([*range(-90, 91, 10), 90, 90, *range(-90, 91, 10)], [21, 19], id="a pause before a flyback"),
        pytest.param([*range(-90, 91, 10), 85, *range(-90, 91, 10)], [20, 19], id="a waver before a flyback"),
        pytest.param([*range(-100, 101, 10)] * 3, [21] * 3, id="flybacks over more than half a turn"),
        pytest.param([*range(0, 1080, 5)], [72] * 3, id="round and round"),
        pytest.param([*range(0, 360, 5)] * 3, [72] * 3, id="round and round, counted anew"),
        pytest.param([*range(-180, 181, 5)] * 2, [73] * 2, id="both ends of a turn are read"),
        pytest.param([*range(0, 361, 5), *range(355, -1, -5)], [73, 72], id="a whole turn to and fro"),
        pytest.param([-45, 45] * 3, [2] * 3, id="two directions"),
        pytest.param([30], [1], id="one reading"),
    ],
)
def test_a_pass_ends_where_the_servo_turns_back_and_after_a_full_turn(angles: list[int], lengths: list[int]) -> None:
    starts = pass_starts(np.radians(angles))
    assert np.diff([*starts, len(angles)]).tolist() == lengths
