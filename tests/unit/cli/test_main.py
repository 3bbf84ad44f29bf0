import sys

import pytest
import typer

from echoplan.cli.main import app, main
from echoplan.errors import EchoplanError, InputError, OutputError, UnknownNameError

FAULTS: dict[str, tuple[EchoplanError, str]] = {
    "input": (InputError("rig.toml", "it is empty", remedy="fill it"), "rig.toml: it is empty; fill it"),
    "output": (
        OutputError("map.json", "the disk is full", remedy="make room"),
        "map.json: the disk is full; make room",
    ),
    "name": (UnknownNameError("rig", "rnig", known=["ring"]), "unknown rig 'rnig'; did you mean 'ring'? known: ring"),
}


@pytest.fixture
def typed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["echoplan", "info", "rec/"])


@pytest.mark.parametrize(("fault", "told"), FAULTS.values(), ids=list(FAULTS))
def test_a_fault_of_ours_becomes_one_line_and_status_2(
    fault: EchoplanError, told: str, typed: None, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(_: str) -> None:
        raise fault

    monkeypatch.setattr("echoplan.sources.open_source", fail)
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    assert capsys.readouterr() == ("", f"echoplan: {told}\n")


def test_a_fault_in_the_program_itself_is_not_hidden(typed: None, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(_: str) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr("echoplan.sources.open_source", fail)
    with pytest.raises(ZeroDivisionError):
        main()


def test_every_command_has_a_summary_of_one_line() -> None:
    group = typer.main.get_command(app)
    commands = getattr(group, "commands", {})
    assert {"demo", "simulate", "map", "evaluate", "info"} <= set(commands)
    for command in commands.values():
        summary = command.help.split("\n\n")[0]
        assert "\n" not in summary
        assert summary.endswith(".")


def test_every_option_says_what_it_is_for() -> None:
    commands = getattr(typer.main.get_command(app), "commands", {})
    silent = [
        f"{name} {each.name}"
        for name, command in commands.items()
        for each in command.params
        if each.name != "help" and not each.help
    ]
    assert silent == []


USAGE = {
    "no argument": ("map", "missing argument 'source'; see echoplan map --help"),
    "no value": ("map rec --out", "option '--out' requires an argument; see echoplan map --help"),
    "a misspelt option": ("map rec --ouut out", "no such option: --ouut (Possible options: --out); see echoplan map"),
    "an argument too many": ("info one two", "got unexpected extra argument(s) (two); see echoplan info --help"),
    "a word for a number": ("simulate square --out out --seed x", "invalid value for '--seed'"),
    "a number out of bounds": ("compare rec --jobs 0", "invalid value for '--jobs'"),
    "no such command": ("mapp rec", "no such command 'mapp'"),
    "an option of no command": ("--bogus", "no such option: --bogus; see echoplan --help"),
}


@pytest.mark.parametrize(("words", "told"), USAGE.values(), ids=list(USAGE))
def test_what_is_typed_wrongly_is_told_in_one_line_with_where_to_look(
    words: str, told: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["echoplan", *words.split()])
    with pytest.raises(SystemExit) as ended:
        main()
    out, err = capsys.readouterr()
    (line,) = err.splitlines()
    assert (ended.value.code, out) == (2, "")
    assert line.startswith(f"echoplan: {told}")
    assert "--help" in line


def test_without_any_words_the_commands_are_listed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["echoplan"])
    with pytest.raises(SystemExit) as ended:
        main()
    out, err = capsys.readouterr()
    assert (ended.value.code or 0, err) == (0, "")
    assert "simulate" in out
