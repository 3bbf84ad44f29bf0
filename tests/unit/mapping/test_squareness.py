from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from echoplan.acoustics.expectation import Kind
from echoplan.classification.evidence import Evidence
from echoplan.classification.hypotheses import Hypothesis
from echoplan.mapping.squareness import SquarenessSettings, main_direction, off_square

SETTINGS = SquarenessSettings()


def faces(*degrees: float, total: float = 100.0) -> list[Hypothesis]:
    nothing = Evidence(*(np.zeros(0, dtype=kind) for kind in (np.int64, float, float, bool, bool, float)))
    return [
        Hypothesis(
            reflector=np.array([Kind.WALL, np.radians(each), 1.0, 0.0]),
            evidence=nothing,
            gains=np.zeros(1),
            total=total,
        )
        for each in degrees
    ]


def test_walls_at_right_angles_have_a_direction() -> None:
    direction = main_direction(faces(10, 100, -80, 190), SETTINGS)
    assert direction is not None
    assert off_square(np.radians(10), direction) == pytest.approx(0.0, abs=1e-12)


def test_it_is_their_mean_and_strong_walls_count_more() -> None:
    even = main_direction(faces(0, 90, 184, -86), SETTINGS)
    strong = main_direction([*faces(0, 90), *faces(184, -86, total=900.0)], SETTINGS)
    assert even is not None
    assert strong is not None
    assert np.degrees(even) == pytest.approx(2.0, abs=0.1)
    assert np.degrees(strong) > 3.0


def test_oblique_walls_have_none() -> None:
    assert main_direction(faces(0, 30, 75, 110), SETTINGS) is None


def test_too_few_walls_have_none() -> None:
    assert main_direction(faces(0, 90, 180), SETTINGS) is None
    assert main_direction([], SETTINGS) is None


def test_only_walls_are_asked() -> None:
    post = [replace(each, reflector=np.array([Kind.CYLINDER, 1.0, 1.0, 0.1])) for each in faces(0, 0, 0, 0)]
    assert main_direction([*faces(0, 90), *post], SETTINGS) is None


@given(angle=st.floats(-10, 10), direction=st.floats(-10, 10), turns=st.integers(-3, 3))
def test_right_angles_do_not_matter(angle: float, direction: float, turns: int) -> None:
    off = off_square(angle, direction)
    assert abs(off) <= np.pi / 4 + 1e-9
    again = off_square(angle + turns * np.pi / 2, direction)
    assert abs(np.sin(2 * (off - again))) < 1e-6
