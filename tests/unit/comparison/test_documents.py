"""Comparisons as other programs read them."""

import csv
import json
from dataclasses import replace
from io import StringIO

import pytest

from echoplan.comparison import comparison_csv, comparison_document, score_methods
from echoplan.io.text import format_json
from helpers.outcomes import some

SCORES = score_methods(some(), ["good", "poor"])


def test_the_document_survives_json() -> None:
    document = json.loads(format_json(comparison_document(SCORES)))
    good, poor = document["methods"]
    assert document["format"] == "echoplan-comparison/1"
    assert good["summary"]["walls"]["recall"]["value"] == 1.0
    assert [trial["source"] for trial in poor["trials"]] == ["sim:room", "rec/<two>"]


def test_grids_have_their_errors_and_other_methods_none() -> None:
    good, poor = comparison_document(SCORES)["methods"]
    assert (good["grid_occupied_error"], good["grid_free_error"]) == (pytest.approx(0.2), pytest.approx(0.05))
    assert good["trials"][0]["grid_error"] == pytest.approx((0.2 * 10 + 0.05 * 30) / 40)
    assert (poor["grid_error"], poor["trials"][0]["grid_error"]) == (None, None)
    rows = list(csv.DictReader(comparison_csv(SCORES).splitlines()))
    assert [row["grid_free_error"] for row in rows] == ["0.05", "0.05", "", ""]


def test_a_failed_trial_has_a_reason_and_no_numbers() -> None:
    trial = comparison_document(SCORES)["methods"][1]["trials"][1]
    assert trial["failure"] == "ValueError: no <walls>"
    assert (trial["evaluation"], trial["seconds_per_1000_pings"]) == (None, None)


def test_the_table_has_a_row_for_each_trial_and_the_same_cells_in_all() -> None:
    rows = list(csv.DictReader(comparison_csv(SCORES).splitlines()))
    assert [(row["method"], row["source"]) for row in rows] == [
        ("good", "sim:room"),
        ("good", "rec/<two>"),
        ("poor", "sim:room"),
        ("poor", "rec/<two>"),
    ]
    assert float(rows[2]["wall_recall"]) == pytest.approx(0.6)
    assert float(rows[0]["map_error_mm"]) > 0.0  # the cylinder that the map lacks
    assert float(rows[0]["seconds_per_1000_pings"]) == pytest.approx(1.0)
    assert rows[3]["wall_recall"] == ""
    assert rows[3]["failure"] == "ValueError: no <walls>"


@pytest.mark.parametrize("name", ["=HYPERLINK(1)", "+1", "-2", "@SUM(1)", "\t=1"])
def test_a_spreadsheet_computes_no_formula_in_a_name(name: str) -> None:
    trials = [
        replace(each, trial=replace(each.trial, subject=replace(each.trial.subject, name=name))) for each in some()
    ]
    text = comparison_csv(score_methods(trials, ["good"]))
    assert {row["source"] for row in csv.DictReader(StringIO(text, newline=""))} == {f"'{name}"}


def test_without_trials_there_is_no_row() -> None:
    assert comparison_csv(()).strip() == ""
