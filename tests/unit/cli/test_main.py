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
