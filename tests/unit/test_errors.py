import pickle
from pathlib import Path

import pytest

from echoplan.errors import (
    EchoplanError,
    InputError,
    InvalidValueError,
    MissingExtraError,
    OutputError,
    UnknownNameError,
)

ERRORS: dict[type[Exception], EchoplanError] = {
    ValueError: InputError("pings.csv", "range is 'x'", remedy="write metres"),
    OSError: OutputError("out/", "disk full", remedy="make room"),
    LookupError: UnknownNameError("method", "x", known=["rcd"]),
    ImportError: MissingExtraError("rosbags", extra="ros"),
}


@pytest.mark.parametrize(("builtin", "error"), ERRORS.items())
def test_every_error_is_ours_and_also_a_builtin_kind(builtin: type[Exception], error: EchoplanError) -> None:
    assert isinstance(error, EchoplanError)
    assert isinstance(error, builtin)
    assert issubclass(InvalidValueError, (EchoplanError, ValueError))


def test_an_input_error_says_where_what_and_the_remedy_in_one_line() -> None:
    error = InputError(Path("rec/pings.csv"), "range is 'x'", remedy="write metres", place="line 7")
    assert str(error) == "rec/pings.csv, line 7: range is 'x'; write metres"
    assert (error.source, error.place, error.problem, error.remedy) == (
        "rec/pings.csv",
        "line 7",
        "range is 'x'",
        "write metres",
    )


def test_an_input_error_without_a_place_names_the_source_alone() -> None:
    assert str(InputError("sim:attic", "no such room", remedy="try sim:paper")) == (
        "sim:attic: no such room; try sim:paper"
    )


def test_an_output_error_says_what_could_not_be_written() -> None:
    error = OutputError(Path("out/map.json"), "disk full", remedy="make room")
    assert str(error) == "out/map.json: disk full; make room"
    assert (error.target, error.problem, error.remedy) == ("out/map.json", "disk full", "make room")


def test_an_unknown_name_is_refused_with_the_nearest_and_all_known_names() -> None:
    error = UnknownNameError("method", "mdp-fuzy", known=["rcd", "mdp-fuzzy"])
    assert str(error) == "unknown method 'mdp-fuzy'; did you mean 'mdp-fuzzy'? known: mdp-fuzzy, rcd"


def test_a_name_like_no_other_gets_no_guess() -> None:
    assert str(UnknownNameError("rig", "qqq", known=["paper"])) == "unknown rig 'qqq'; known: paper"


def test_a_missing_extra_is_reported_with_the_command_that_installs_it() -> None:
    assert str(MissingExtraError("rosbags", extra="ros")) == (
        "rosbags is not installed; install it with: pip install rosbags (extra 'ros')"
    )


@pytest.mark.parametrize("error", ERRORS.values(), ids=lambda error: type(error).__name__)
def test_an_error_travels_between_processes_unchanged(error: EchoplanError) -> None:
    arrived = pickle.loads(pickle.dumps(error))
    assert (type(arrived), str(arrived), vars(arrived)) == (type(error), str(error), vars(error))
