"""All sweeps are cleaned before they are mapped, and nothing is drawn where features would be invented."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import pytest

from echoplan.methods import find_method, map_sweeps
from echoplan.model import FeatureMap, Rig, Sweep
from echoplan.sources import open_source


@pytest.fixture(scope="module")
def square() -> tuple[Rig, tuple[Sweep, ...]]:
    room = open_source("sim:square,seed=3")
    return room.rig, tuple(room)


@pytest.mark.parametrize("method", ["rcd", "hough", "joint"])
def test_without_positions_there_are_only_poses(square: tuple[Rig, tuple[Sweep, ...]], method: str) -> None:
    rig, sweeps = square
    lost = [replace(sweep, map_from_base=np.zeros((len(sweep), 3))) for sweep in sweeps]
    found = map_sweeps(find_method(method).build(rig), lost)
    assert found.is_empty
    assert (found.method, len(found.poses), found.sweeps.tolist()) == (method, 5, [0, 1, 2, 3, 4])
    assert found.parameters


def test_from_one_place_joint_draws_nothing(square: tuple[Rig, tuple[Sweep, ...]]) -> None:
    rig, sweeps = square
    mapper = find_method("joint").build(rig)
    found = map_sweeps(mapper, sweeps[:1])
    assert found.is_empty
    assert len(found.poses) == 1


def test_one_more_place_counts_with_those_before(square: tuple[Rig, tuple[Sweep, ...]]) -> None:
    rig, sweeps = square
    mapper = find_method("joint").build(rig)
    map_sweeps(mapper, sweeps[:4])
    assert len(map_sweeps(mapper, sweeps[4:]).walls) == 4


class Listed:
    """A mapper that keeps what it is given."""

    def __init__(self, rig: Rig, log: list[str]) -> None:
        self.rig, self.log, self.sweeps = rig, log, list[Sweep]()

    def add(self, sweep: Sweep) -> None:
        self.log.append("mapped")
        self.sweeps.append(sweep)

    def result(self) -> FeatureMap:
        return FeatureMap(method="none")


def test_cleaned_sweeps_are_followed_one_by_one_as_they_are_mapped(square: tuple[Rig, tuple[Sweep, ...]]) -> None:
    rig, sweeps = square
    stuck = [replace(sweep, ranges=np.where(sweep.sensor_ids == 2, 1.27, sweep.ranges)) for sweep in sweeps]
    log: list[str] = []

    def follow(cleaned: Sequence[Sweep]) -> Iterator[Sweep]:
        for sweep in cleaned:
            log.append("passed on")
            yield sweep

    mapper = Listed(rig, log)
    map_sweeps(mapper, stuck, follow=follow)
    assert log == ["passed on", "mapped"] * 5
    assert all(np.isnan(sweep.ranges[sweep.sensor_ids == 2]).all() for sweep in mapper.sweeps)
