"""TOML and JSON are checked against forms, and a fault is reported with its place and a remedy."""

from pathlib import Path

import pytest
from pydantic import Field

from echoplan.errors import InputError, InvalidValueError
from echoplan.io.structure import Form, Pair, read_json, read_toml


class BeamForm(Form, extra="forbid"):
    width: float = Field(description="the opening angle [rad]")
    axis: Pair = Field(default=[1.0, 0.0], description="the direction [x, y]")

    def value(self) -> float:
        if self.width <= 0:
            raise InvalidValueError(f"width must be greater than 0, not {self.width:g}")
        return self.width


class SonarForm(Form, extra="forbid"):
    name: str = Field(default="", description="what people call it")
    main: BeamForm | None = Field(default=None, description="the main lobe")
    lobe: list[BeamForm] = Field(default=[], description="a list of tables [[lobe]]")


class NoteForm(Form):
    text: str = Field(description="what was noted")


TOML = """\
# a comment
name = "sonar"

[main]
width = 0.6

[[lobe]]
width = 0.1
axis = [0.0, 1.0]

[[lobe]]
width = 0.2
"""


def write(tmp_path: Path, text: str, name: str = "sonar.toml") -> Path:
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return path


def test_a_file_that_fits_fills_the_form(tmp_path: Path) -> None:
    form = read_toml(write(tmp_path, TOML), SonarForm)
    assert form.main is not None
    assert (form.name, form.main.width, [lobe.axis for lobe in form.lobe]) == ("sonar", 0.6, [[0.0, 1.0], [1.0, 0.0]])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("name =", "nome =", r"line 2, nome: the key 'nome' is unknown; did you mean 'name'\?"),
        ("name =", "colour =", r"line 2, colour: the key 'colour' is unknown; known are name, main, lobe"),
        ("[main]", "[mian]", r"line 4, mian: the key 'mian' is unknown; did you mean 'main'\?"),
        ("width = 0.2", "widht = 0.2", r"line 12, lobe\[1\]\.widht: the key 'widht' is unknown; did you mean 'width'"),
        (
            "width = 0.2",
            "",
            r"line 11, lobe\[1\]\.width: the key 'width' is missing; add it: width: the opening angle",
        ),
        ('"sonar"', "7", r"line 2, name: must be a valid string, not 7; name: what people call it"),
        (
            "0.6",
            '"0.6"',
            r"line 5, main\.width: must be a valid number, not '0\.6'; width: the opening angle \[rad\]",
        ),
        ("0.6", "nan", r"line 5, main\.width: must be a finite number, not nan"),
        ("0.6", "-1", r"line 4, main: width must be greater than 0, not -1; correct it"),
        ("[0.0, 1.0]", "[0.0]", r"line 9, lobe\[0\]\.axis: must have at least 2 items, not 1; axis: the direction"),
        ("[0.0, 1.0]", "[0.0, true]", r"line 9, lobe\[0\]\.axis\[1\]: must be a valid number, not True; axis: the"),
        ("[main]\nwidth =", "main =", r"line 4, main: must be a table, not 0\.6; main: the main lobe"),
        ("= 0.6", "0.6", r"sonar\.toml, line 5, column 7: the file is broken: Expected '='"),
        ("0.2\n", "[0.2", r"sonar\.toml, at its end: the file is broken: "),
    ],
)
def test_a_fault_in_toml_is_reported_with_line_key_and_remedy(tmp_path: Path, old: str, new: str, message: str) -> None:
    assert old in TOML
    with pytest.raises(InputError, match=message) as caught:
        read_toml(write(tmp_path, TOML.replace(old, new)), SonarForm)
    assert "\n" not in str(caught.value)


def test_what_programs_write_may_hold_more_than_is_known(tmp_path: Path) -> None:
    path = write(tmp_path, '{"text": "clear", "weather": {"rain": false}}', "note.json")
    assert read_json(path, NoteForm).text == "clear"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('{"text": 3}', r"note\.json, text: must be a valid string, not 3; text: what was noted"),
        ('{"text": "a",}', r"note\.json, line 1, column \d+: the file is broken"),
        ("", r"note\.json, line 1, column 1: the file is broken: Expecting value"),
        ("[]", r"note\.json: must be a table, not \[\]"),
        ("[" * 100_000, r"note\.json: the file is broken: maximum recursion depth"),
    ],
)
def test_a_fault_in_json_is_reported(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        read_json(write(tmp_path, text, "note.json"), NoteForm)


def test_a_key_that_would_break_the_line_is_quoted(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        read_toml(write(tmp_path, '"two\\nlines" = 1\n'), SonarForm)
    assert r"['two\nlines']: the key 'two\nlines' is unknown" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "key", [".".join(["a"] * 20_000), " . ".join(["a"] * 20_000), ".".join([r'"\""'] * 2_000), ".".join(["''"] * 20)]
)
@pytest.mark.parametrize("line", ["{key} = 1", "[{key}]", "[[{key}]]", "main = {{{key} = 1}}"])
def test_a_key_of_many_parts_is_refused_before_it_costs_time_and_memory(tmp_path: Path, key: str, line: str) -> None:
    path = write(tmp_path, f'name = "sonar"\n{line.format(key=key)}\n')
    with pytest.raises(InputError, match=r"sonar\.toml, line 2, column 1: the file is broken: a key has more than 16"):
        read_toml(path, SonarForm)


def test_a_text_with_dots_is_no_key_of_many_parts(tmp_path: Path) -> None:
    name = "an ellipsis ...................., numbers 1.2.3.4, and a.b.c"
    assert read_toml(write(tmp_path, f'name = "{name}"\n'), SonarForm).name == name


def test_half_a_character_is_refused_and_both_halves_are_read(tmp_path: Path) -> None:
    assert read_json(write(tmp_path, r'{"text": "\ud83d\ude00"}', "note.json"), NoteForm).text == "\U0001f600"
    with pytest.raises(InputError, match=r"note\.json: the file is broken: a text has half a character"):
        read_json(write(tmp_path, r'{"text": "\ud800"}', "note.json"), NoteForm)


def test_numbers_of_thousands_of_digits_are_refused(tmp_path: Path) -> None:
    for text in ("9" * 5000, f"0x{'f' * 5000}"):
        with pytest.raises(InputError, match=r"sonar\.toml"):
            read_toml(write(tmp_path, f"main = {{width = {text}}}"), SonarForm)
    with pytest.raises(InputError, match=r"note\.json: the file is broken: Exceeds the limit .* conversion; fix it"):
        read_json(write(tmp_path, f'{{"text": {"9" * 5000}}}', "note.json"), NoteForm)


def test_a_file_that_would_fill_the_memory_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "sonar.toml"
    with path.open("wb") as file:
        file.truncate(10**9)
    with pytest.raises(InputError, match=r"sonar\.toml: it has 1000 MB, and 32 MB are read at most"):
        read_toml(path, SonarForm)
