from pathlib import Path

import numpy as np

from echoplan.simulation import echoes, threshold
from echoplan.simulation.compiled import compiled, compiled_and_kept

SOURCES = Path(echoes.__file__).parent


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


def test_a_kept_function_calls_compiled_functions_of_its_own_file_only() -> None:
    # The machine code that is kept beside a file is renewed when that file changes, and no other.
    for module in (echoes, threshold):
        text = Path(module.__file__ or "").read_text(encoding="utf-8")
        assert "@compiled_and_kept" in text
        imported = [line for line in text.splitlines() if line.startswith("from echoplan.simulation.")]
        for line in imported:
            name = line.split()[1].rsplit(".", 1)[1]
            source = (SOURCES / f"{name}.py").read_text(encoding="utf-8")
            assert name == "compiled" or "@compiled" not in source
    assert compiled_and_kept.__doc__
