"""One battery for all values of the evaluation: none can be changed once it is there."""

from dataclasses import FrozenInstanceError, fields
from typing import Any

import numpy as np
import pytest

from echoplan.errors import InvalidValueError
from echoplan.evaluation import Consistency, Outline, Trajectory, evaluate, pool
from echoplan.evaluation.vertices import true_vertices
from echoplan.model import FeatureClass
from helpers import maps

EVALUATION = evaluate(maps.spoilt(maps.ROOM, np.random.default_rng(1)), maps.ROOM)
VALUES: list[Any] = [
    EVALUATION,
    EVALUATION.matches,
    EVALUATION.map_error,
    EVALUATION.trajectory,
    EVALUATION.matches.walls,
    EVALUATION.floor_plan,
    EVALUATION.floor_plan.lengths,
    EVALUATION.floor_plan.wall_ends,
    EVALUATION.consistency[FeatureClass.WALL],
    EVALUATION.matches.walls.right[0],
    EVALUATION.matches.walls.tally,
    pool([EVALUATION], rng=np.random.default_rng(0)),
    true_vertices(maps.ROOM),
    Outline(segments_xy=maps.ROOM.walls_xy, circles=maps.ROOM.cylinders),
]


@pytest.mark.parametrize("value", VALUES, ids=lambda value: type(value).__name__)
def test_neither_a_field_nor_an_array_of_a_value_can_be_changed(value: Any) -> None:
    for field in fields(value):
        with pytest.raises(FrozenInstanceError):
            setattr(value, field.name, None)
        content = getattr(value, field.name)
        if isinstance(content, np.ndarray):
            with pytest.raises(ValueError, match="read-only"):
                content[...] = 0


NONE = Consistency(parameters=2, nees=np.zeros(0))


def test_arrays_that_do_not_go_together_are_refused() -> None:
    with pytest.raises(InvalidValueError, match="angles must have shape"):
        Trajectory(distances=np.zeros(3), angles=np.zeros(2), steps=np.zeros((2, 3)), positions=NONE, headings=NONE)
    with pytest.raises(InvalidValueError, match="nees must be finite, not nan"):
        Consistency(parameters=2, nees=np.array([1.0, np.nan]))
    with pytest.raises(InvalidValueError, match="circles must have shape"):
        Outline(segments_xy=np.zeros((1, 2, 2)), circles=np.zeros((1, 2)))
