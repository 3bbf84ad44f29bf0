"""Localisation: poses in a known map, and whether the first ones are certain."""

from dataclasses import FrozenInstanceError
from typing import Any

import numpy as np
import pytest

from echoplan.errors import InvalidValueError
from echoplan.model import Localisation, StartPose, TrajectorySegment

GIVEN: dict[str, Any] = {
    "sweeps": np.array([3, 4]),
    "poses": np.ones((2, 3)),
    "covariances": np.tile(np.eye(3), (2, 1, 1)),
}


def segment(*weights: float, first: int = 3) -> TrajectorySegment:
    """A part of a recording that may begin at poses with these probabilities."""
    return TrajectorySegment(
        first=first, starts=tuple(StartPose(pose=np.zeros(3), weight=weight) for weight in weights)
    )


def localisation(*segments: TrajectorySegment, **changed: Any) -> Localisation:
    return Localisation(
        **(GIVEN | {"segments": segments or (segment(1.0),), "inlier_ratio": 0.9, "jaccard_index": 0.8} | changed)
    )


@pytest.mark.parametrize(
    ("weights", "is_ambiguous"), [((1.0,), False), ((0.95, 0.05), False), ((0.94, 0.06), True), ((0.5, 0.5), True)]
)
def test_a_stretch_is_ambiguous_if_its_likeliest_start_is_not_sure(
    weights: tuple[float, ...], *, is_ambiguous: bool
) -> None:
    assert segment(*weights).is_ambiguous == is_ambiguous


def test_a_localisation_is_ambiguous_if_one_of_its_stretches_is() -> None:
    sure, unsure = segment(1.0), segment(0.6, 0.4, first=4)
    assert not localisation(sure, sure).is_ambiguous
    assert localisation(sure, unsure).is_ambiguous
    assert localisation(unsure, sure).is_ambiguous


def test_the_robot_was_carried_before_each_stretch_but_the_first() -> None:
    assert localisation(segment(1.0)).kidnapped == ()
    assert localisation(segment(1.0), segment(1.0, first=7), segment(1.0, first=12)).kidnapped == (7, 12)


def test_a_start_is_three_finite_numbers() -> None:
    for pose in (np.zeros(2), np.zeros((1, 3)), np.array([0.0, np.nan, 0.0])):
        with pytest.raises(InvalidValueError, match="pose"):
            StartPose(pose=pose, weight=1.0)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("sweeps", np.array([0.5, 1.0])),
        ("poses", np.ones((3, 3))),
        ("poses", np.full((2, 3), np.inf)),
        ("covariances", np.zeros((0, 3, 3))),
        ("covariances", np.ones((2, 3))),
    ],
)
def test_a_localisation_has_one_pose_and_one_covariance_for_each_sweep(name: str, value: object) -> None:
    with pytest.raises(InvalidValueError, match=name):
        localisation(**{name: value})


def test_a_localisation_keeps_copies_of_its_arrays_that_cannot_be_written() -> None:
    found = localisation()
    for name, given in GIVEN.items():
        array = getattr(found, name)
        assert not np.shares_memory(array, given)
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0


def test_a_localisation_does_not_change() -> None:
    with pytest.raises(FrozenInstanceError):
        localisation().inlier_ratio = 1.0  # type: ignore[misc]
    with pytest.raises(FrozenInstanceError):
        segment(1.0).first = 0  # type: ignore[misc]
