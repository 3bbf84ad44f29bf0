from dataclasses import replace

import numpy as np
import pytest

from echoplan.evaluation import evaluate, evaluation_tables
from helpers import maps


def test_tables_that_would_be_empty_are_left_out() -> None:
    found = maps.drawn(*(maps.wall(*ends) for ends in maps.ROOM.walls_xy))
    bare = replace(maps.ROOM, cylinders=np.zeros((0, 3)), cylinders_detected_by=np.zeros(0, dtype=np.int64))
    with_pillars, without = (
        [table.title for table in evaluation_tables(evaluate(found, truth))] for truth in (maps.ROOM, bare)
    )
    assert "Accuracy of the cylinders" in with_pillars
    assert without == [title for title in with_pillars if title != "Accuracy of the cylinders"]


def test_a_perfect_map_is_perfect_in_every_table() -> None:
    walls = [maps.wall(*ends) for ends in maps.ROOM.walls_xy]
    tables = {table.title: table for table in evaluation_tables(evaluate(maps.drawn(*walls), maps.ROOM))}
    accuracy = next(table for title, table in tables.items() if "walls" in title)
    assert [float(row[1]) for row in accuracy.rows] == pytest.approx([0.0] * len(accuracy.rows), abs=1e-9)
    assert len(accuracy.rows) == len(maps.ROOM.walls_xy)
