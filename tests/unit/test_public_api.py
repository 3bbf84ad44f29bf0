import subprocess
import sys
from typing import Any, cast

import pytest

import echoplan

# A name that goes, or changes its meaning, breaks the programs of others: see docs/api.md.
NAMES = [
    "Changes",
    "Corner",
    "Cylinder",
    "EchoplanError",
    "Evaluation",
    "FeatureMap",
    "InputError",
    "InvalidValueError",
    "JointMapper",
    "JointSettings",
    "METHODS",
    "Localisation",
    "LocateResult",
    "MapResult",
    "MissingExtraError",
    "OccupancyGrid",
    "OnlineMapper",
    "Opening",
    "OutputError",
    "Quality",
    "Recording",
    "Rig",
    "Sensor",
    "Simulation",
    "SimulationSettings",
    "Source",
    "Sweep",
    "Truth",
    "UnknownNameError",
    "Verdict",
    "Wall",
    "__version__",
    "builtin_rig",
    "compare",
    "evaluate",
    "find_rig",
    "locate",
    "map",
    "open",
    "read_map",
    "read_truth",
    "simulate",
    "write_recording",
]


def test_the_public_names_are_those_that_are_listed() -> None:
    assert dir(echoplan) == sorted(NAMES)
    # A star import leaves the builtins alone.
    assert {*NAMES} - {*echoplan.__all__} == {"map", "open"}


@pytest.mark.parametrize("name", NAMES)
def test_each_public_name_exists_and_help_names_it(name: str) -> None:
    assert getattr(echoplan, name) is not None
    assert name in (echoplan.__doc__ or "") or name == "__version__"


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = echoplan.nothing


def test_importing_echoplan_imports_no_heavy_package() -> None:
    heavy = "{'numpy', 'scipy', 'pydantic', 'matplotlib', 'numba'} & set(sys.modules)"
    asked = subprocess.run(
        [sys.executable, "-c", f"import sys, echoplan; print({heavy})"], capture_output=True, text=True, check=True
    )
    assert asked.stdout.strip() == "set()"


def test_a_simulated_drive_is_mapped_evaluated_and_compared_in_a_few_lines() -> None:
    recording = echoplan.simulate("square", seed=1)
    result = echoplan.map(recording, method="mdp-fuzzy")
    assert len(result.walls) == 4
    assert echoplan.evaluate(result, recording.truth).matches.walls.tally.found == 4
    (score,) = echoplan.compare([recording], methods=["mdp-fuzzy"])
    assert score.method == "mdp-fuzzy"


def test_one_name_is_as_good_as_a_list_and_what_is_no_map_is_refused() -> None:
    scores = echoplan.compare("sim:square,seed=1", methods="mdp-fuzzy,rcd")
    assert [score.method for score in scores] == ["mdp-fuzzy", "rcd"]
    with pytest.raises(echoplan.InvalidValueError, match="found must be a map"):
        echoplan.evaluate(cast("Any", None), "truth.json")
    with pytest.raises(echoplan.InvalidValueError, match="truth must be a Truth"):
        echoplan.evaluate(echoplan.FeatureMap(method="rcd"), cast("Any", 3))
