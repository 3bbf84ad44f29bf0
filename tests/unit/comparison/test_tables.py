"""Comparisons as people read them."""

from echoplan.comparison import comparison_tables, failure_table, score_methods, score_table
from helpers.outcomes import some


def test_a_row_shows_accuracy_and_cost_of_a_method() -> None:
    table = score_table(score_methods(some(), ["good", "poor"]))
    rows = {row[0]: dict(zip(table.columns, row, strict=True)) for row in table.rows}
    assert rows["good"]["walls (%)"] == "100 / 100"
    assert rows["poor"]["walls (%)"] == "60 / 100"
    assert rows["poor"]["maps"] == "1 of 2"
    assert (rows["good"]["offset (mm)"], rows["good"]["angle (°)"]) == ("0.0", "0.00")
    assert (rows["good"]["ms / 1000 pings"], rows["poor"]["ms / 1000 pings"]) == ("1000", "2000")
    assert rows["good"]["memory (MB)"] == "50"
    assert rows["good"]["poses (mm)"] == "-"
    assert (rows["good"]["grid (%)"], rows["poor"]["grid (%)"]) == ("20 / 5", "-")


def test_dashes_mark_what_is_not_known() -> None:
    outcomes = [each for each in some() if each.failure]
    (row,) = score_table(score_methods([*outcomes], ["poor"])).rows
    assert row == ("poor", "0 of 1", "-", "-")


def test_without_truth_only_maps_and_costs_are_shown() -> None:
    table = score_table(score_methods(some(truth=None), ["good", "poor"]))
    assert table.columns == ("method", "maps", "ms / 1000 pings", "memory (MB)")


def test_failures_are_shown_with_their_reason() -> None:
    assert failure_table(some()).rows == (("poor", "rec/<two>", "ValueError: no <walls>"),)


def test_lengths_of_walls_have_a_table_of_their_own_where_there_is_a_truth() -> None:
    _, lengths, failures = comparison_tables(score_methods(some(), ["good", "poor"]))
    assert [row[:3] for row in lengths.rows] == [("good", "100.0", "100.0"), ("poor", "73.5", "100.0")]
    assert failures.rows == failure_table(some()).rows
    assert len(comparison_tables(score_methods(some(truth=None)[:3], ["good", "poor"]))) == 1
