import gc
import os
import subprocess
import sys
from collections import namedtuple
from contextlib import suppress
from enum import IntEnum
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest

from echoplan import compiled as module
from echoplan.compiled import compiled, inlined

pytestmark = pytest.mark.slow


@compiled
def halves(x: float) -> float:
    return x / 2


@inlined
def third(x: float) -> float:
    return x / 3


@inlined
def ninth(x: float) -> float:
    return third(third(x))


@compiled
def twenty_seventh(x: float) -> float:
    return third(ninth(x))


@compiled
def inverse(x: float) -> float:
    return 1 / x


def test_compiled_functions_do_what_python_would() -> None:
    assert [halves(x) for x in (1.0, 3.0, -2.0)] == [0.5, 1.5, -1.0]


def test_inlined_functions_become_part_of_those_that_call_them() -> None:
    assert [twenty_seventh(27.0), third(27.0)] == [1.0, 9.0]
    assert not hasattr(third, "overloads")


def test_dividing_by_nothing_is_infinite() -> None:
    assert inverse(0.0) == np.inf


def test_that_it_compiles_is_logged_once(caplog: pytest.LogCaptureFixture) -> None:
    module._log_once.cache_clear()
    with caplog.at_level("INFO", logger="echoplan"):
        for number in range(2):
            compiled(lambda x: x + number)(1.0)  # noqa: B023 - called at once
    assert [record.message[:9] for record in caplog.records] == ["Compiling"]


@pytest.mark.parametrize("is_enabled", [True, False])
@pytest.mark.parametrize("value", ["x", "None"])
def test_garbage_is_collected_after_compiling_as_before_it(*, is_enabled: bool, value: str) -> None:
    during = set()

    def looked(x: float) -> float:
        return x

    @numba.extending.overload(looked)
    def look(x: Any) -> Any:
        during.add(gc.isenabled())
        return looked if isinstance(x, numba.types.Float) else None

    (gc.enable if is_enabled else gc.disable)()
    try:
        with suppress(numba.TypingError):
            compiled(eval(f"lambda x: looked({value})", {"looked": looked}))(1.0)
        assert (during, gc.isenabled()) == ({False}, is_enabled)
    finally:
        gc.enable()


PARTS = {
    "unused": "UNUSED = 1",
    "constant": "SCALE = 2.0",
    "field": "Pair = namedtuple('Pair', 'a b')",
    "member": "Kind = IntEnum('Kind', 'WALL POST')",
    "callee": "def inner(x):\n    return x + 1.0",
    "default": "def outer(x, a=0.0):\n    return [SCALE * inner(each) + Pair(1.0, a).a + Kind.WALL for each in x]",
}


def digest(**changed: str) -> str:
    """The digest of a function of which some parts are changed."""
    names: dict[str, Any] = {"namedtuple": namedtuple, "IntEnum": IntEnum}
    for name, code in PARTS.items():
        old, new = changed.get(name, "nothing = nothing").split(" = ")
        exec(code.replace(old, new), names)
        if name == "callee":
            names["inner"] = compiled(names["inner"])
    return module.digest_of(names["outer"])


@pytest.mark.parametrize(
    "changed",
    [
        {"constant": "2.0 = 3.0"},
        {"field": "a b = b a"},
        {"member": "WALL POST = POST WALL"},
        {"callee": "x + = x - "},
        {"default": "0.0 = 1.0"},
    ],
    ids=str,
)
def test_a_change_of_what_the_code_uses_changes_its_digest(changed: dict[str, str]) -> None:
    assert digest(**changed) != digest()


def test_a_change_of_anything_else_does_not() -> None:
    assert digest(unused="1 = 2") == digest()


def test_the_order_of_the_fields_of_an_argument_is_in_the_key() -> None:
    named: Any = namedtuple
    values = [named("Pair", "a b")(1.0, 2.0), named("Pair", "b a")(1.0, 2.0), 1.0]
    one, other, number = (module._fields_of(numba.typeof(each)) for each in values)  # type: ignore[no-untyped-call]
    assert one != other
    assert number == ()


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
