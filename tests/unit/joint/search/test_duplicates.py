from dataclasses import replace

import numpy as np
import pytest

from echoplan.acoustics.predicted_echo import Kind
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.ping_scores import PingScores
from echoplan.joint.likelihood.track_history import TrackHistory
from echoplan.joint.search.duplicates import (
    DuplicateSettings,
    are_duplicates,
    without_duplicates,
)

SETTINGS = DuplicateSettings()


def face(degrees: float, offset: float, *, ends: tuple[float, float] = (0.0, 2.0), llr: float = 100.0) -> Hypothesis:
    return feature([Kind.WALL, np.radians(degrees), offset, 0.0], ends=ends, llr=llr)


def feature(row: list[float], *, ends: tuple[float, float] = (0.0, 0.0), llr: float = 100.0) -> Hypothesis:
    nothing = PingScores(*(np.zeros(0, dtype=kind) for kind in (np.int64, float, float, bool, bool, float)))
    return Hypothesis(
        reflector=np.array(row, dtype=np.float64),
        ping_scores=nothing,
        llr_by_station=np.zeros(1),
        llr=llr,
        extent=ends,
    )


def test_a_slightly_shifted_or_rotated_wall_is_a_duplicate() -> None:
    assert are_duplicates(face(0, 1.0), face(3, 1.0), SETTINGS)
    assert are_duplicates(face(0, 1.0), face(0, 1.05), SETTINGS)


@pytest.mark.parametrize(
    "other",
    [face(0, 1.2), face(20, 1.0), face(180, -1.0), face(0, 1.0, ends=(2.5, 4.0))],
    ids=["beside", "turned", "seen from behind", "farther along"],
)
def test_a_different_wall_is_no_duplicate(other: Hypothesis) -> None:
    assert not are_duplicates(face(0, 1.0), other, SETTINGS)


def test_being_a_duplicate_is_symmetric() -> None:
    rng = np.random.default_rng(0)
    faces = [face(rng.uniform(-20, 20), rng.uniform(0.9, 1.1), ends=(0.0, rng.uniform(0.1, 2))) for _ in range(30)]
    for one in faces:
        for other in faces:
            assert are_duplicates(one, other, SETTINGS) == are_duplicates(other, one, SETTINGS)


def test_angles_of_duplicates_are_wrapped() -> None:
    assert are_duplicates(face(179, 1.0, ends=(0.0, 0.2)), face(-179, 1.0, ends=(0.0, 0.2)), SETTINGS)


def test_only_walls_have_duplicates() -> None:
    post = feature([Kind.CYLINDER, 1.0, 0.0, 0.1])
    assert not are_duplicates(post, post, SETTINGS)
    assert without_duplicates([post, post], SETTINGS) == [post, post]


def test_the_duplicate_with_the_greatest_ratio_is_kept() -> None:
    weak, strong, other = face(0, 1.0, llr=50), face(2, 1.02, llr=300), face(90, 1.0, llr=80)
    assert without_duplicates([weak, strong, other], SETTINGS) == [strong, other]


def test_no_landmarks_have_no_duplicates() -> None:
    assert without_duplicates([], SETTINGS) == []


def test_walls_known_as_different_are_no_duplicates() -> None:
    one, other = (replace(each, history=TrackHistory(number=0, supporting=2)) for each in (face(0, 1.0), face(0, 1.04)))
    assert without_duplicates([one, other], SETTINGS) == [one, other]
    assert without_duplicates([one, face(0, 1.04, llr=50)], SETTINGS) == [one]
