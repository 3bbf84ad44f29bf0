import errno
import os
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import typer

from echoplan.cli.app import app
from echoplan.cli.main import main
from echoplan.errors import EchoplanError, InputError, OutputError, UnknownNameError

pytestmark = pytest.mark.slow

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


@pytest.mark.parametrize(("fault", "message"), FAULTS.values(), ids=list(FAULTS))
def test_a_fault_of_ours_becomes_one_line_and_status_2(
    fault: EchoplanError, message: str, typed: None, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(_: str, **__: object) -> None:
        raise fault

    monkeypatch.setattr("echoplan.sources.open_source", fail)
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    assert capsys.readouterr() == ("", f"echoplan: {message}\n")


REFUSALS: dict[str, tuple[BaseException, str]] = {
    "system": (PermissionError(errno.EACCES, "Permission denied", "/private/rec"), "/private/rec: Permission denied; "),
    "system without a name": (OSError(errno.EIO, "Input/output error"), "the system says: Input/output error; "),
    "memory": (MemoryError(), "the memory is not enough; try a shorter recording, or coarser settings"),
    "depth": (RecursionError(), "the input is nested too deeply"),
}


@pytest.mark.parametrize(("fault", "message"), REFUSALS.values(), ids=list(REFUSALS))
def test_what_system_and_memory_refuse_becomes_one_line_and_status_2(
    fault: BaseException,
    message: str,
    typed: None,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def fail(_: str, **__: object) -> None:
        raise fault

    monkeypatch.setattr("echoplan.sources.open_source", fail)
    with pytest.raises(SystemExit) as ended:
        main()
    out, err = capsys.readouterr()
    assert (ended.value.code, out, len(err.splitlines())) == (2, "", 1)
    assert err.startswith(f"echoplan: {message}")


def test_a_name_with_line_ends_and_commands_to_the_terminal_is_shown_in_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["echoplan", "info", "one\ntwo\x1b[2J\udce4" + "x" * 100_000])
    with pytest.raises(SystemExit):
        main()
    err = capsys.readouterr().err
    assert err.startswith("echoplan: one\\ntwo\\x1b[2J\\udce4xxx")
    assert (len(err.splitlines()), len(err) < 1100) == (1, True)


def test_handlers_of_signals_are_put_back(typed: None) -> None:
    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    with pytest.raises(SystemExit):
        main()
    assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)] == before


COMMAND = [sys.executable, "-m", "echoplan"]


@pytest.mark.parametrize("words", ["info nope", "--help"])
@pytest.mark.parametrize("stream", ["1", "2"])
@pytest.mark.parametrize("place", ["&-", "/dev/full"])
def test_streams_that_are_closed_or_full_make_no_other_noise(words: str, stream: str, place: str) -> None:
    line = f"{shlex.join(COMMAND)} {words} {stream}>{place}"
    done = subprocess.run(["bash", "-c", line], capture_output=True, text=True, check=False)
    full = stream == "1" and place == "/dev/full"
    assert done.returncode == (2 if full or "nope" in words else 0)
    assert len(done.stderr.splitlines()) <= 1
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("encoding", ["ascii", "utf-8"])
def test_terminals_of_any_encoding_show_what_they_can(encoding: str, tmp_path: Path) -> None:
    environment = {**os.environ, "PYTHONIOENCODING": encoding}
    words = ["simulate", "square", "--out", str(tmp_path / os.fsdecode(b"r\xe4um"))]
    done = subprocess.run([*COMMAND, *words], capture_output=True, env=environment, check=False)
    assert (done.returncode, done.stderr) == (0, b"")
    assert b"r?um" in done.stdout
    assert (tmp_path / os.fsdecode(b"r\xe4um") / "pings.csv").exists()


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_at_any_moment_ends_the_program_without_a_word(
    number: signal.Signals, status: int, tmp_path: Path
) -> None:
    words = ["map", "sim:paper-room", "--out", str(tmp_path / "map"), "--method", "rcd"]
    for wait in (0.4, 1.0):
        with subprocess.Popen([*COMMAND, *words], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) as process:
            time.sleep(wait)
            process.send_signal(number)
            assert process.stderr is not None
            assert process.stderr.read() == b""
        assert process.returncode in (status, 0)


def test_a_command_that_is_terminated_leaves_the_folder_as_it_was_and_nothing_beside_it(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "pings.csv").write_text("old")
    program = (
        "import os, signal, sys\n"
        "from echoplan.__main__ import main\n"
        "def stop(event, arguments):\n"
        "    if event == 'open' and str(arguments[0]).endswith('truth.json'):\n"
        "        os.kill(os.getpid(), signal.SIGTERM)\n"
        "sys.addaudithook(stop)\n"
        "main()\n"
    )
    words = ["simulate", "square", "--out", str(tmp_path / "out")]
    done = subprocess.run([sys.executable, "-c", program, *words], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (143, "", "")
    assert list(tmp_path.rglob("*")) == [tmp_path / "out", tmp_path / "out" / "pings.csv"]
    assert (tmp_path / "out" / "pings.csv").read_text() == "old"


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_in_a_destructor_ends_the_program_without_a_word(
    number: signal.Signals, status: int, tmp_path: Path
) -> None:
    program = (
        "import os, sys\n"
        "from echoplan.__main__ import main\n"
        "class Signalling:\n"
        "    def __del__(self):\n"
        f"        os.kill(os.getpid(), {number:d})\n"
        "def stop(event, arguments):\n"
        "    if event == 'open' and str(arguments[0]).endswith('truth.json'):\n"
        "        Signalling()\n"
        "sys.addaudithook(stop)\n"
        "main()\n"
    )
    words = ["simulate", "square", "--out", str(tmp_path / "out")]
    done = subprocess.run([sys.executable, "-c", program, *words], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (status, "")


def test_an_interrupt_while_the_command_line_is_imported_ends_the_program_without_a_word() -> None:
    program = (
        "import os, signal, sys\n"
        "class Finder:\n"
        "    def find_spec(self, name, *_):\n"
        "        if name == 'echoplan.cli.main':\n"
        "            os.kill(os.getpid(), signal.SIGINT)\n"
        "from echoplan.__main__ import main\n"
        "sys.meta_path.insert(0, Finder())\n"
        "main()\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (-signal.SIGINT, "", "")


def test_a_fault_in_the_program_itself_is_not_hidden(typed: None, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(_: str, **__: object) -> None:
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
    "a misspelt option": (
        "map rec --ouut out",
        "no such option: --ouut (Possible options: --mount, --out); see echoplan map",
    ),
    "an argument too many": ("info one two", "got unexpected extra argument(s) (two); see echoplan info --help"),
    "a word for a number": ("simulate square --out out --seed x", "invalid value for '--seed'"),
    "a number out of bounds": ("compare rec --jobs 0", "invalid value for '--jobs'"),
    "no such command": ("mapp rec", "no such command 'mapp'"),
    "an option of no command": ("--bogus", "no such option: --bogus; see echoplan --help"),
}


@pytest.mark.parametrize(("words", "message"), USAGE.values(), ids=list(USAGE))
def test_wrong_usage_is_reported_in_one_line_with_where_to_look(
    words: str, message: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["echoplan", *words.split()])
    with pytest.raises(SystemExit) as ended:
        main()
    out, err = capsys.readouterr()
    (line,) = err.splitlines()
    assert (ended.value.code, out) == (2, "")
    assert line.startswith(f"echoplan: {message}")
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
