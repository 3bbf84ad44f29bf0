"""What signals do."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from echoplan.signals import at_signal, noted_signals, raised_signals

NUMBERS = (signal.SIGINT, signal.SIGTERM)


@pytest.mark.slow
@pytest.mark.parametrize("number", NUMBERS)
def test_a_signal_in_compiled_code_ends_the_process_and_calls_the_actions(number: signal.Signals) -> None:
    program = (
        "import os, subprocess\n"
        "from echoplan.signals import at_signal, ended_by_signals\n"
        "from echoplan.sources import open_source\n"
        "source = open_source('sim:paper-room')\n"
        "next(iter(source))\n"
        "with ended_by_signals(), at_signal(lambda: 1 / 0), at_signal(lambda: os.write(1, b'cleared')):\n"
        f"    subprocess.Popen(['sh', '-c', f'sleep 0.2; kill -{number:d} {{os.getpid()}}'])\n"
        "    while True:\n"
        "        list(source)\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, check=False, timeout=60)
    assert (done.returncode, done.stdout, done.stderr) == (128 + number, b"cleared", b"")


@pytest.mark.parametrize("number", NUMBERS)
def test_a_signal_may_be_raised_or_noted_and_calls_no_action(number: signal.Signals, tmp_path: Path) -> None:
    before = signal.getsignal(number)
    with at_signal((tmp_path / "done").touch):
        with pytest.raises(SystemExit) as ended, raised_signals():
            signal.raise_signal(number)
        with noted_signals() as came:
            signal.raise_signal(number)
    assert (ended.value.code, came) == (128 + number, [number])
    assert signal.getsignal(number) == before
    assert not (tmp_path / "done").exists()


def test_an_ignored_signal_stays_ignored() -> None:
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with noted_signals() as came:
            os.kill(os.getpid(), signal.SIGINT)
        assert came == []
    finally:
        signal.signal(signal.SIGINT, before)
