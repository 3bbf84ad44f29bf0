from dataclasses import replace

import numpy as np

from echoplan.evaluation import (
    BootstrapSettings,
    Consistency,
    confusion_table,
    consistency_table,
    cylinder_table,
    deviation_table,
    evaluate,
    pool,
    tally_table,
    wall_table,
)
from echoplan.model import EVERYWHERE, FeatureClass
from helpers import maps

FOUND = evaluate(
    maps.drawn(
        maps.wall((1, 0.01), (3, 0.04)),
        maps.wall((1, 1), (2, 2)),
        maps.cylinder((3.53, 0.56), 0.08),
    ),
    maps.ROOM,
)


def test_walls_are_listed_as_in_table_5_of_the_paper() -> None:
    table = wall_table(FOUND.matches.walls)
    assert table.columns == ("true wall", "distance deviation (mm)", "angle deviation (°)", "stations")
    # 3 cm in 2 m are 0.86 degrees.
    assert table.rows[:2] == (("1", "25.0", "0.86", "9"), ("2", "-", "-", "4"))
    assert len(table.rows) == 6


def test_the_stations_that_detect_walls_need_not_be_specified() -> None:
    truth = replace(maps.ROOM, walls_detected_by=np.full(len(maps.ROOM.walls_xy), EVERYWHERE))
    table = wall_table(evaluate(maps.drawn(maps.wall((1, 0.01), (3, 0.04))), truth).matches.walls)
    assert {row[-1] for row in table.rows} == {"everywhere"}


def test_cylinders_are_listed_with_the_sign_of_their_radius_error() -> None:
    assert cylinder_table(FOUND.matches.cylinders).rows == (("1", "50.0", "-20.0", "6"), ("2", "-", "-", "0"))


def test_counts_are_listed_class_by_class() -> None:
    table = tally_table({name: matching.tally for name, matching in FOUND.matches.by_class.items()})
    assert table.rows == (
        ("wall", "5", "1", "20.0", "1", "0", "1", "50.0"),
        ("corner", "4", "0", "0.0", "0", "0", "0", "-"),
        ("cylinder", "1", "1", "100.0", "1", "0", "0", "100.0"),
    )


def test_the_confusion_has_its_classes_at_both_edges() -> None:
    table = confusion_table(FOUND.confusion)
    assert table.columns == ("in truth", "wall in map", "corner in map", "cylinder in map", "missed")
    assert table.rows[0] == ("wall", "1", "0", "0", "4")
    assert table.rows[3] == ("none", "1", "0", "0", "0")


def test_consistency_is_listed_with_its_expected_value() -> None:
    walls, corners, _, every = consistency_table(FOUND.consistency).rows
    assert walls[0] == "wall"
    assert walls[1] == "1"
    # One feature of two parameters: the quantiles of chi-square are 0.05 and 7.38.
    assert walls[3:5] == ("2", "[0.1, 7.4]")
    assert corners == ("corner", "0", "-", "2", "-", "-")
    assert every[:5] == ("all", "2", "-", "-", "-")


def test_classes_are_summed_up_by_how_many_are_inside_their_ellipses() -> None:
    several = {
        FeatureClass.WALL: Consistency(parameters=2, nees=np.array([1.0, 5.9, 6.1])),
        FeatureClass.CYLINDER: Consistency(parameters=3, nees=np.array([7.7])),
    }
    assert [row[-1] for row in consistency_table(several).rows] == ["66.7", "100.0", "75.0"]
    assert consistency_table({}).rows == (("all", "0", "-", "-", "-", "-"),)


def test_deviations_are_listed_with_their_intervals() -> None:
    other = evaluate(maps.drawn(maps.wall((1, 0.05), (3, 0.05))), maps.ROOM)
    pooled = pool([FOUND, other], rng=np.random.default_rng(0), settings=BootstrapSettings(resamples=50))
    rows = {name: cells for name, *cells in deviation_table(pooled).rows}
    assert rows["wall distance (mm)"][:2] == ["2", "37.5 [25.0, 50.0]"]
    assert rows["wall distance (mm)"][-1] == "50.0"
    assert rows["wall angle (°)"][1] == "0.43 [0.00, 0.86]"
    assert rows["cylinder radius (mm)"][:2] == ["1", "20.0"]
    assert rows["heading RMS (°)"] == ["0", "-", "-", "-", "-", "-"]


def test_every_row_has_a_cell_for_every_column() -> None:
    pooled = pool([FOUND], rng=np.random.default_rng(0), settings=BootstrapSettings(resamples=50))
    for table in (
        wall_table(FOUND.matches.walls),
        cylinder_table(FOUND.matches.cylinders),
        tally_table({name: pooled.classes[name].tally for name in FeatureClass}),
        confusion_table(pooled.confusion),
        consistency_table(FOUND.consistency),
        deviation_table(pooled),
    ):
        assert {len(row) for row in table.rows} == {len(table.columns)}
