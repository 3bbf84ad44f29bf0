"""Tables are read in chunks, and a fault is reported with its line."""

from pathlib import Path

import numpy as np
import pytest

from echoplan.errors import InputError
from echoplan.io import table as table_module
from echoplan.io.kinds import NUMBER, READING, SECONDS, WHOLE
from echoplan.io.table import Table

COLUMNS = {"t": SECONDS, "id": WHOLE, "x": NUMBER, "range": READING}


def opened(tmp_path: Path, text: str) -> Table:
    path = tmp_path / "table.csv"
    path.write_text(text, encoding="utf-8")
    return Table.open(path, COLUMNS, optional=["t"])


def read(tmp_path: Path, text: str) -> list[tuple[float, ...]]:
    return [tuple(row) for rows in opened(tmp_path, text) for row in rows.data.tolist()]


def test_columns_may_have_any_order(tmp_path: Path) -> None:
    rows = next(iter(opened(tmp_path, "range,x,t,id\n1.5,-2,0.25,7\n")))
    assert {name: rows.data[name].tolist() for name in COLUMNS} == {
        "t": [250_000_000],
        "id": [7],
        "x": [-2.0],
        "range": [1.5],
    }


def test_unknown_columns_are_passed_over_whatever_they_hold(tmp_path: Path) -> None:
    text = 'id,note,x,,range,note\n1,"a, b — ""c""",2,,3,\n2,,3,?,4,\n'
    assert read(tmp_path, text) == [(1, 2.0, 3.0), (2, 3.0, 4.0)]


@pytest.mark.parametrize(
    "text",
    [
        "\ufeffid,x,range\r\n1,2,3\r\n2,3,4\r\n",
        "id,x,range\n1,2,3\n\n2,3,4\n\n \n",
        "id, x , range\n 1, 2 ,3\n2,\t3,4",
        '"id","x","range"\n"1","2","3"\n"2","3","4"\n',
        "id,x,range\n1.0,2e0,3.\n2.0,+3,4\n",
    ],
    ids=["windows", "blank lines", "blanks", "quoted", "notations"],
)
def test_the_same_numbers_may_be_written_in_many_ways(tmp_path: Path, text: str) -> None:
    assert read(tmp_path, text) == [(1, 2.0, 3.0), (2, 3.0, 4.0)]


@pytest.mark.parametrize("text", ["id,x,range\n1,2,\n", "range,id,x\n,1,2\n", "id,range,x\n1, ,2\n"])
def test_an_empty_reading_is_a_fault_of_the_sensor(tmp_path: Path, text: str) -> None:
    rows = next(iter(opened(tmp_path, text)))
    assert np.isnan(rows.data["range"]).all()
    assert (rows.data["id"].tolist(), rows.data["x"].tolist()) == ([1], [2.0])


def test_chunks_follow_on_each_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(table_module, "_CHUNK", 3)
    text = "id,x,range\n" + "".join(f"{number},0,0\n" for number in range(8))
    chunks = list(opened(tmp_path, text))
    assert [rows.first for rows in chunks] == [0, 3, 6]
    assert [number for rows in chunks for number in rows.data["id"].tolist()] == list(range(8))


def test_a_fault_is_reported_with_its_line_counted_over_blank_lines_and_chunks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(table_module, "_CHUNK", 2)
    with pytest.raises(InputError, match=r"table\.csv, line 7, column x: 'far' is no number; write a finite number"):
        read(tmp_path, "id,x,range\n1,0,0\n2,0,0\n\n3,0,0\n\n4,far,0\n5,0,0\n")


def test_one_column_can_be_read_by_itself(tmp_path: Path) -> None:
    table = opened(tmp_path, "id,x,range\n1,2,3\n2,far,4\n").only("id")
    assert [number for rows in table for number in rows.data["id"].tolist()] == [1, 2]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"table\.csv: it is empty; begin it with the header id,x,range"),
        ("\n\n", r"table\.csv: it is empty"),
        ("id,range\n1,2\n", r"line 1: the column 'x' is missing; the header must have id,x,range"),
        ("ID,x,range\n", r"line 1: the column 'id' is missing; rename 'ID' if that is it"),
        ("id,x,range,x\n", r"line 1: the column 'x' occurs twice"),
        ("id;x;range\n1;0,5;2\n", r"line 1: columns are separated by ';'; separate them by commas"),
        ("id\tx\trange\n", r"line 1: columns are separated by '\\t'"),
        ("1,2.5,-3e0\n", r"line 1: there is no header; begin the file with id,x,range"),
        ("id,x,range\n", r"table\.csv: it holds a header but no rows"),
        ("id,x,range\n1,2,3\n2,3", r"line 3: the row has 2 fields, but the header 3; complete it, or delete it"),
        ("id,x,range\n1,0,5,1,5\n", r"line 2: the row has 5 fields, but the header 3; .* decimal points, not commas"),
        ("id,x,range\n1,,3\n", r"line 2, column x: the field is empty"),
        ("id,x,range\n1.5,2,3\n", r"line 2, column id: '1\.5' is no whole number; write a whole number"),
    ],
)
def test_an_unusable_table_is_refused_with_a_remedy(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        read(tmp_path, text)


def test_bytes_that_are_no_utf8_are_refused_with_their_line(tmp_path: Path) -> None:
    path = tmp_path / "table.csv"
    path.write_bytes(b"id,x,range\n1,2,3\n\xff,2,3\n")
    with pytest.raises(InputError, match=r"line 3: it is no UTF-8 text"):
        list(Table.open(path, COLUMNS, optional=["t"]))


def test_a_legitimate_replacement_character_is_not_mistaken_for_the_bad_byte(tmp_path: Path) -> None:
    path = tmp_path / "table.csv"
    path.write_bytes("id,note,x,range\n1,\ufffd,2,3\r2,,2,3\n".encode() + b"\xff,,2,3\n")
    with pytest.raises(InputError, match=r"line 4: it is no UTF-8 text"):
        list(Table.open(path, COLUMNS, optional=["t"]))


def test_characters_of_all_scripts_are_allowed_in_unused_columns(tmp_path: Path) -> None:
    assert read(tmp_path, "id,note,x,range\n1,hé,2,3\n") == [(1, 2.0, 3.0)]
    with pytest.raises(InputError, match="range"):
        read(tmp_path, "id,x,range\n1,2,3é\n")


@pytest.mark.parametrize("note", ['"', '"a', '" b', '""" c', 'd"e" "f'])
def test_a_quotation_mark_swallows_no_rows(tmp_path: Path, note: str) -> None:
    lines = ["id,note,x,range", *(f"{number},,0,0" for number in range(9))]
    lines[3] = f"2,{note},0,0"
    lines[6] = '5,",0,0'
    # What begins with a quotation mark is a quoted cell; elsewhere the mark is a character like others.
    line = 4 if note.startswith('"') else 7
    with pytest.raises(InputError, match=f"line {line}: the row"):
        read(tmp_path, "\n".join(lines))


def test_a_line_without_end_is_refused_before_it_fills_the_memory(tmp_path: Path) -> None:
    for text, line in (("id,x,range\n1,2,3\n" + "7" * 200_000, 3), ("id" * 100_000, 1)):
        with pytest.raises(
            InputError, match=rf"line {line}: it is longer than 131072 characters; write one row a line"
        ):
            read(tmp_path, text)
