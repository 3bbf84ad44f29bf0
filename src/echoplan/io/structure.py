"""TOML and JSON files: validated against a form; each error names its place and the remedy."""

import difflib
import json
import re
import reprlib
import tomllib
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated, Self, TypeVar, get_args

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator
from pydantic_core import ErrorDetails

from echoplan.errors import InputError
from echoplan.io.files import check_file, read_text, readable
from echoplan.io.units import Coordinate

__all__ = ["Count", "Form", "Pair", "Quadruple", "Triple", "Whole", "read_json", "read_toml", "validated"]

FormT = TypeVar("FormT", bound=BaseModel)
Location = tuple[int | str, ...]

# Ten thousand poses with their covariances take 4 MB, and so do the corners of a hundred thousand faces.
_LARGEST_FILE = 32_000_000
# Time and memory of tomllib grow with the square of the parts of a key; the longest of ours has three.
_DEEPEST_KEY = 16
_KEY_PART = r"""(?:[A-Za-z0-9_-]++|"(?:[^"\\\n]|\\.)*+"|'[^'\n]*+')"""
_DEEP_KEY = re.compile(rf"""(?<![\w"'.\\-])(?:{_KEY_PART}[ \t]*+\.[ \t]*+){{{_DEEPEST_KEY}}}""")

Whole = Annotated[int, Field(ge=-(2**62), le=2**62)]
Count = Annotated[int, Field(ge=0, le=2**62)]
Pair = Annotated[list[Coordinate], Field(min_length=2, max_length=2)]
Triple = Annotated[list[Coordinate], Field(min_length=3, max_length=3)]
Quadruple = Annotated[list[Coordinate], Field(min_length=4, max_length=4)]


class Form(BaseModel):
    """A table of a file, as it is written.

    Keys that it does not know are passed over: another program may say more than this version understands.  The
    form of what people write says ``extra="forbid"``, because there such a key is a slip of the pen.
    """

    model_config = ConfigDict(frozen=True, strict=True, extra="ignore", allow_inf_nan=False)

    def value(self) -> object:
        """Make the value of the model that the table describes.

        Raises
        ------
        InvalidValueError
            If there can be no such value.
        """
        return self

    @model_validator(mode="after")
    def _describes_a_value(self) -> Self:
        self.value()
        return self


def read_toml(path: Path, form: type[FormT]) -> FormT:
    """Read a TOML file of a given form.

    Parameters
    ----------
    path : Path
        The file.
    form : type of BaseModel
        What it must hold.

    Returns
    -------
    BaseModel
        The form, filled in.

    Raises
    ------
    InputError
        If the file cannot be read, is no TOML or does not fit the form.
    """
    return _fill(path, form, parse=_parse_toml)


def read_json(path: Path, form: type[FormT]) -> FormT:
    """Read a JSON file of a given form.

    Parameters
    ----------
    path : Path
        The file.
    form : type of BaseModel
        What it must hold.

    Returns
    -------
    BaseModel
        The form, filled in.

    Raises
    ------
    InputError
        If the file cannot be read, is no JSON or does not fit the form.
    """
    return _fill(path, form, parse=_parse_json)


def validated(form: type[FormT], values: object, *, source: str) -> FormT:
    """Fill a form with values that a program passed; ``source`` is what to call them.

    Raises
    ------
    InputError
        If they do not fit the form.
    """
    try:
        return form.model_validate(values)
    except ValidationError as error:
        raise _misfit(Path(source), "", form, error.errors()) from error


def _fill(path: Path, form: type[FormT], *, parse: Callable[[str], object]) -> FormT:
    check_file(path)
    with readable(path):
        size = path.stat().st_size
    if size > _LARGEST_FILE:
        problem = f"it has {size / 1e6:.0f} MB, and {_LARGEST_FILE / 1e6:.0f} MB are read at most"
        raise InputError(path, problem, remedy="split it, or name another file")
    text = read_text(path)
    try:
        return form.model_validate(parse(text))
    except ValidationError as error:
        raise _misfit(path, text, form, error.errors()) from error
    except (ValueError, RecursionError) as error:
        raise _broken(path, str(error)) from error


def _parse_toml(text: str) -> object:
    if deep := _DEEP_KEY.search(text):
        line = text.count("\n", 0, deep.start()) + 1
        raise ValueError(f"a key has more than {_DEEPEST_KEY} parts (at line {line}, column 1)")
    return tomllib.loads(text)


def _parse_json(text: str) -> object:
    value = json.loads(text)
    if re.search(r"\\u[dD][89a-fA-F]", text):
        try:
            json.dumps(value, ensure_ascii=False).encode()
        except UnicodeEncodeError as error:
            raise ValueError("a text has half a character, \\ud800 to \\udfff, without its other half") from error
    return value


def _broken(path: Path, said: str) -> InputError:
    position = re.search(r"line (\d+),? column (\d+)", said)
    place = f"line {position[1]}, column {position[2]}" if position else "at its end" * ("end of document" in said)
    problem = re.split(r" \(at |: line |: value has ", said)[0]
    return InputError(path, f"the file is broken: {problem}", place=place, remedy="fix it there")


def _misfit(path: Path, text: str, form: type[BaseModel], errors: list[ErrorDetails]) -> InputError:
    # A misspelt key is also a missing one; report the spelling.
    error = min(errors, key=lambda error: error["type"] != "extra_forbidden")
    location = error["loc"]
    line = _line_of(location, text) if path.suffix == ".toml" else 0
    place = ", ".join(filter(None, [f"line {line}" if line else "", _dotted(location)]))
    problem, remedy = _explain(error, form)
    return InputError(path, problem, place=place, remedy=remedy)


def _explain(error: ErrorDetails, form: type[BaseModel]) -> tuple[str, str]:
    """Put an error of pydantic into a problem and its remedy."""
    key, meaning = _key_at(error["loc"], form)
    match error["type"]:
        case "extra_forbidden":
            known = _form_at(error["loc"][:-1], form).model_fields
            near = difflib.get_close_matches(key, known, n=1)
            remedy = f"did you mean {near[0]!r}?" if near else f"known are {', '.join(known)}"
            return f"the key {key!r} is unknown", remedy
        case "missing":
            return f"the key {key!r} is missing", f"add it: {meaning}"
        case "value_error":
            problem, _, remedy = str(error["ctx"]["error"]).partition("; ")
            return problem, remedy or "correct it"
    return _mismatch(error), meaning or "correct it"


def _mismatch(error: ErrorDetails) -> str:
    if error["type"] in ("too_long", "too_short"):
        return error["msg"].replace("List should", "must").replace(" after validation", "")
    wanted = "must be a table" if error["type"] == "model_type" else error["msg"].replace("Input should", "must")
    # Python refuses to write out whole numbers of thousands of digits.
    is_long = isinstance(error["input"], int) and error["input"].bit_length() > 1000
    given = "a number of hundreds of digits" if is_long else reprlib.repr(error["input"])
    return f"{wanted.partition(', unable')[0]}, not {given}"


def _key_at(location: Location, form: type[BaseModel]) -> tuple[str, str]:
    """Find the last key on the way to a place, and what it stands for."""
    names = [index for index, part in enumerate(location) if isinstance(part, str)]
    if not names:
        return "", ""
    key = str(location[names[-1]])
    field = _form_at(location[: names[-1]], form).model_fields.get(key)
    return key, f"{key}: {field.description}" if field else ""


def _form_at(location: Location, form: type[BaseModel]) -> type[BaseModel]:
    for part in location:
        field = form.model_fields.get(str(part))
        form = (field and _nested(field.annotation)) or form
    return form


def _nested(annotation: object) -> type[BaseModel] | None:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next(filter(None, map(_nested, get_args(annotation))), None)


def _dotted(location: Location) -> str:
    plain = (isinstance(part, str) and re.fullmatch(r"[\w-]+", part) for part in location)
    parts = (f".{part}" if named else f"[{part!r}]" for part, named in zip(location, plain, strict=True))
    return "".join(parts).removeprefix(".")


def _line_of(location: Location, text: str) -> int:
    """Find the line that comes nearest to a place in TOML text; 0 if none does."""
    nearest, shared = 0, 0
    for line, here in _locations(text):
        common = min(len(here), len(location))
        if common > shared and here[:common] == location[:common]:
            nearest, shared = line, common
    return nearest


def _locations(text: str) -> Iterator[tuple[int, Location]]:
    table: Location = ()
    entries: Counter[Location] = Counter()
    for number, line in enumerate(text.split("\n"), start=1):
        if header := re.match(r"\s*(\[\[?)\s*([\w.-]+)\s*\]", line):
            table = tuple(header[2].split("."))
            if header[1] == "[[":
                entries[table] += 1
                table = (*table, entries[table] - 1)
            yield number, table
        elif key := re.match(r"\s*([\w.-]+)\s*=", line):
            yield number, (*table, *key[1].split("."))
