import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from echoplan import compiled as module
from echoplan.compiled import compiled

pytestmark = pytest.mark.slow


@compiled
def halves(x: float) -> float:
    return x / 2


@compiled
def inverse(x: float) -> float:
    return 1 / x


def test_compiled_functions_do_what_python_would() -> None:
    assert [halves(x) for x in (1.0, 3.0, -2.0)] == [0.5, 1.5, -1.0]


def test_dividing_by_nothing_is_infinite() -> None:
    assert inverse(0.0) == np.inf


def test_that_it_compiles_is_logged_once(caplog: pytest.LogCaptureFixture) -> None:
    module._log_once.cache_clear()
    with caplog.at_level("INFO", logger="echoplan"):
        for number in range(2):
            compiled(lambda x: x + number)(1.0)  # noqa: B023 - called at once
    assert [record.message[:9] for record in caplog.records] == ["Compiling"]


def test_the_machine_code_is_kept_and_renewed_when_any_file_of_the_package_changes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    state = module._state_of_package.__wrapped__
    (tmp_path / "compiled.py").write_text("")
    (tmp_path / "other.py").write_text("a = 1\n")
    monkeypatch.setattr(module, "__file__", str(tmp_path / "compiled.py"))
    before = state()
    assert state() == before
    (tmp_path / "other.py").write_text("a = 12\n")
    assert state() != before


WORK = """
from echoplan.compiled import compiled
@compiled
def twice(x):
    return 2 * x
assert twice(1.0) == 2.0
print(sum(twice.stats.cache_hits.values()))
"""


def hits(folder: Path, **environment: str) -> str:
    """Run a compiled function in a process of its own; return how often its machine code was found."""
    (folder / "work.py").write_text(WORK)
    command = [sys.executable, str(folder / "work.py")]
    done = subprocess.run(
        command, check=True, capture_output=True, text=True, env={**os.environ, "NUMBA_CACHE_DIR": "", **environment}
    )
    assert not done.stderr
    return done.stdout.strip()


def test_a_second_process_takes_the_machine_code_of_the_first(tmp_path: Path) -> None:
    assert [hits(tmp_path, NUMBA_CACHE_DIR=str(tmp_path)) for _ in range(2)] == ["0", "1"]


def test_where_nothing_can_be_kept_functions_are_compiled_in_memory(tmp_path: Path) -> None:
    (tmp_path / "__pycache__").write_text("a file where a folder should be")
    nowhere = {name: str(tmp_path / "work.py" / "x") for name in ("NUMBA_CACHE_DIR", "HOME", "XDG_CACHE_HOME")}
    assert [hits(tmp_path, **nowhere) for _ in range(2)] == ["0", "0"]


@pytest.mark.parametrize("rubbish", [b"", b"\x80\x04K\x01."])
@pytest.mark.parametrize("kind", ["nbi", "nbc"])
def test_damaged_machine_code_is_compiled_and_kept_again(tmp_path: Path, kind: str, rubbish: bytes) -> None:
    environment = {"NUMBA_CACHE_DIR": str(tmp_path)}
    assert hits(tmp_path, **environment) == "0"
    for path in tmp_path.rglob(f"*.{kind}"):
        path.write_bytes(rubbish)
    assert [hits(tmp_path, **environment) for _ in range(2)] == ["0", "1"]
