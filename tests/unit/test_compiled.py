import os
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest

from echoplan import compiled as module
from echoplan.compiled import compiled


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


def test_that_it_compiles_is_told_once(caplog: pytest.LogCaptureFixture) -> None:
    module._tell_once.cache_clear()
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


def test_a_second_process_takes_the_machine_code_of_the_first(tmp_path: Path) -> None:
    (tmp_path / "work.py").write_text(
        textwrap.dedent("""
        from echoplan.compiled import compiled
        @compiled
        def twice(x):
            return 2 * x
        twice(1.0)
        print(sum(twice.stats.cache_hits.values()))
        """)
    )
    hits = [
        subprocess.run(
            [sys.executable, str(tmp_path / "work.py")],
            check=True,
            capture_output=True,
            text=True,
            env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)},
        ).stdout.strip()
        for _ in range(2)
    ]
    assert hits == ["0", "1"]
