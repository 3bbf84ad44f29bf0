"""What the documents name is there: tests, functions, files, commands, settings."""

import importlib.util
import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
from pydantic import BaseModel

from echoplan.classical.covering import Covering
from echoplan.classical.fuzzy import class_of, corrected_memberships
from echoplan.methods import Method, map_sweeps
from echoplan.model import FeatureClass, Transducer
from echoplan.simulation import SimulationSettings
from echoplan.sources import open_source

ROOT = Path(__file__).parents[2]
DOCUMENTS = {
    path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8")
    for path in sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
}
TESTS = "\n".join(path.read_text(encoding="utf-8") for path in sorted((ROOT / "tests").rglob("test_*.py")))
PACKAGES = "acoustics|classical|diagnosis|evaluation|extraction|grids|io|model|preprocessing|simulation|viewer"


@pytest.fixture(params=DOCUMENTS)
def document(request: pytest.FixtureRequest) -> str:
    """The text of each document in turn."""
    return DOCUMENTS[request.param]


def test_every_test_that_is_named_exists(document: str) -> None:
    named = set(re.findall(r"`(test_\w+)`", document))
    assert [name for name in sorted(named) if f"def {name}(" not in TESTS] == []


def test_every_class_of_tests_that_is_named_exists(document: str) -> None:
    named = set(re.findall(r"class `(Test\w+)`", document))
    assert [name for name in sorted(named) if f"class {name}:" not in TESTS] == []


def test_every_function_that_is_named_with_its_package_exists(document: str) -> None:
    missing = []
    for package, name in re.findall(rf"`(?:echoplan\.)?({PACKAGES})\.(\w+)`", document):
        module = importlib.import_module(f"echoplan.{package}")
        if not hasattr(module, name):
            try:
                importlib.import_module(f"echoplan.{package}.{name}")
            except ModuleNotFoundError:
                missing.append(f"{package}.{name}")
    assert missing == []


def test_every_module_of_joint_that_is_named_exists() -> None:
    named = {name for text in DOCUMENTS.values() for name in re.findall(r"`(joint(?:\.\w+)+)`", text)}
    assert len(named) > 10
    assert [name for name in sorted(named) if importlib.util.find_spec(f"echoplan.{name}") is None] == []


def test_each_question_of_a_maintainer_is_answered_by_one_file_that_defines_the_name() -> None:
    rows = re.findall(r"^\| (.+\?) \| `(\S+)` \| `(\w+)` \|$", DOCUMENTS["docs/architecture.md"], flags=re.MULTILINE)
    assert len(rows) >= 10
    missing = []
    for question, path, name in rows:
        text = (ROOT / path).read_text(encoding="utf-8") if (ROOT / path).is_file() else ""
        if not re.search(rf"^ *(?:def|class) {name}\b|^{name}\b.* = ", text, flags=re.MULTILINE):
            missing.append((question, path, name))
    assert missing == []


def test_every_source_file_that_is_named_exists(document: str) -> None:
    named = set(re.findall(r"`(?:\.\./)*(src/[\w./-]+)`", document))
    assert [path for path in sorted(named) if not (ROOT / path).exists()] == []


def test_the_glossary_names_a_module_for_each_term() -> None:
    modules = re.findall(r"^\| .+ `([\w./]+)` \|$", DOCUMENTS["docs/glossary.md"], flags=re.MULTILINE)
    assert len(modules) > 60
    missing = [
        name for name in modules if not (ROOT / name).exists() and importlib.util.find_spec(f"echoplan.{name}") is None
    ]
    assert missing == []


def test_documents_are_written_in_plain_words(document: str) -> None:
    prose = re.sub(r"```.*?```|`[^`]*`|\]\([^)]*\)", "", document, flags=re.DOTALL)
    odd = (
        r"\b(told|tells|torn|astray|glances?|believed|beliefs|reckoned|heard|hears|sounded|mend|nudged|nobody"
        r"|way-points?)\b"
    )
    assert re.findall(odd, prose, flags=re.IGNORECASE) == []


def test_every_file_that_is_linked_exists() -> None:
    links = [(name, link) for name, text in DOCUMENTS.items() for link in re.findall(r"\]\(([^)#:]+)[)#]", text)]
    assert [link for link in links if not (ROOT / link[0]).parent.joinpath(link[1]).exists()] == []


def anchors(text: str) -> set[str]:
    """Anchors that GitHub gives to the headings of a document."""
    headings = re.findall(r"^#+ (.+)$", text, flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def test_every_heading_that_is_linked_exists() -> None:
    links = [
        (name, link, anchor)
        for name, text in DOCUMENTS.items()
        for link, anchor in re.findall(r"\]\(([\w./-]*)#([^)]+)\)", text)
    ]
    missing = []
    for name, link, anchor in links:
        path = (ROOT / name).parent.joinpath(link).resolve() if link else ROOT / name
        if path.is_file() and anchor not in anchors(path.read_text(encoding="utf-8")):
            missing.append((name, link, anchor))
    assert len(links) > 20
    assert missing == []


def test_every_script_and_folder_that_a_document_runs_exists() -> None:
    named = {
        path for text in DOCUMENTS.values() for path in re.findall(r"\b((?:benchmarks|tests|docs)/[\w./-]+)", text)
    }
    # What make docs builds is there only afterwards.
    named = {path for path in named if not path.startswith("docs/_build/")}
    assert [path for path in sorted(named) if not (ROOT / path.rstrip(".")).exists()] == []


def flattened(settings: BaseModel, prefix: str = "") -> dict[str, object]:
    """Every setting by its dotted name, with its default."""
    found: dict[str, object] = {}
    for name, value in settings:
        found |= flattened(value, f"{prefix}{name}.") if isinstance(value, BaseModel) else {prefix + name: value}
    return found


def test_every_option_of_the_simulator_is_in_its_table_with_its_default() -> None:
    table = dict(re.findall(r"^\| `([\w.]+)` \| (\S+) \|", DOCUMENTS["docs/simulator.md"], flags=re.MULTILINE))
    documented = {name: tomllib.loads(f"value = {default}")["value"] for name, default in table.items()}
    assert documented == flattened(SimulationSettings())


def examples(language: str) -> list[str]:
    """Blocks of a language in the guide for contributors."""
    return re.findall(rf"^```{language}\n(.*?)^```$", DOCUMENTS["CONTRIBUTING.md"], flags=re.DOTALL | re.MULTILINE)


def test_the_method_that_contributors_are_shown_maps_a_room_by_its_entry_in_the_registry() -> None:
    shown: dict[str, Any] = {}
    exec(examples("python")[0], shown)
    entry = eval(examples("py")[0].rstrip().rstrip(","), {"Method": Method})
    source = open_source("sim:square,seed=1")
    mapper = shown[entry.mapper](source.rig, shown[entry.settings]())
    found = map_sweeps(mapper, source)
    assert found.method == entry.name
    assert len(found.walls) >= 4


def test_the_transducer_that_contributors_are_shown_how_to_measure_is_an_hc_sr04(
    capsys: pytest.CaptureFixture[str],
) -> None:
    exec(examples("python")[1], {})
    measured = Transducer(**tomllib.loads(capsys.readouterr().out))
    assert measured.figure_of_merit == pytest.approx(Transducer().figure_of_merit, abs=1.0)
    assert measured.piston_radius == pytest.approx(Transducer().piston_radius, rel=0.05)


def test_the_table_of_borders_between_classes_is_what_the_rules_do() -> None:
    rows = re.findall(r"^\| ([\w ]+) \| (0\.\d{4}) \| (0\.\d{4}) \|$", DOCUMENTS["docs/paper.md"], flags=re.MULTILINE)
    states = {"nowhere": Covering.NONE, "left or right": Covering.LEFT, "in front": Covering.FRONT}
    assert [name for name, *_ in rows] == list(states)
    for name, *borders in rows:
        for border, beyond in zip(map(float, borders), (FeatureClass.CORNER, FeatureClass.WALL), strict=True):
            # The table rounds to four places.
            around = [
                class_of(corrected_memberships(border + half, states[name], rules="monotone")) for half in (-5e-5, 5e-5)
            ]
            assert around[0] is not around[1]
            assert beyond in around
