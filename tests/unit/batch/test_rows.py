"""The table of a batch."""

import csv
from io import BytesIO

import pytest

from echoplan.batch import Row, rows_csv, rows_parquet

ROWS = [
    Row(name="a", status="ok", verdict="good", walls=4, sweeps=3, pings=48, seconds=0.5, wall_recall=1.0),
    Row(name="=b", status="failed", error="rig.toml: it is empty; fill it"),
]


def test_a_failed_row_has_an_error_and_no_numbers() -> None:
    good, bad = csv.DictReader(rows_csv(ROWS).splitlines())
    assert (good["name"], good["walls"], good["wall_recall"], good["error"]) == ("a", "4", "1.0", "")
    assert (bad["status"], bad["error"], bad["walls"]) == ("failed", "rig.toml: it is empty; fill it", "")


def test_a_spreadsheet_computes_no_formula_in_a_name() -> None:
    assert rows_csv(ROWS).splitlines()[2].startswith("'=b,failed")


def test_a_table_without_rows_has_its_header() -> None:
    assert rows_csv([]).startswith("name,status,error,verdict,walls,")


def test_parquet_has_the_same_rows_with_types_and_nulls() -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    table = parquet.read_table(BytesIO(rows_parquet(ROWS)))
    assert table.to_pylist() == [row.model_dump() for row in ROWS]
    assert [str(table.schema.field(name).type) for name in ("name", "walls", "seconds")] == [
        "string",
        "int64",
        "double",
    ]
    assert str(parquet.read_table(BytesIO(rows_parquet([]))).schema.field("walls").type) == "int64"
