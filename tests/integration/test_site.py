"""The documentation site builds without a warning, and its references are complete."""

import importlib.util
import re
import subprocess
import sys
from collections.abc import Iterator
from html import unescape
from pathlib import Path

import pytest
import typer.main
from pydantic import BaseModel

import echoplan
from echoplan.cli.app import app
from echoplan.joint.mapper import JointSettings

DOCS = Path(__file__).parents[2] / "docs"
PACKAGES = ("sphinx", "myst_parser", "numpydoc", "pydata_sphinx_theme", "sphinx_design")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the site, as ``make docs`` does."""
    missing = [name for name in PACKAGES if importlib.util.find_spec(name) is None]
    if missing:
        pytest.skip(f"{missing[0]} is not installed; `make docs` installs what builds the site")
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "-n", "--keep-going", "-d", f"{folder}/doctrees"]
    built = subprocess.run([*command, DOCS, folder / "html"], capture_output=True, text=True, check=False)
    assert built.stderr == ""
    assert built.returncode == 0
    return folder / "html"


def text_of(page: Path) -> str:
    """What a page shows."""
    return unescape(re.sub(r"<[^>]+>", "", page.read_text(encoding="utf-8")))


def test_every_page_is_built_and_can_be_reached_from_the_first_one(site: Path) -> None:
    pages = {path.relative_to(DOCS).with_suffix(".html") for path in DOCS.rglob("*.md")}
    assert sorted(page for page in pages if not (site / page).is_file()) == []
    reached, waiting = set[Path](), [site / "index.html"]
    while waiting:
        page = waiting.pop().resolve()
        if page not in reached and page.is_file():
            reached.add(page)
            links = re.findall(r'href="([^":#]+\.html)[#"]', page.read_text(encoding="utf-8"))
            waiting += [page.parent / link for link in links]
    assert sorted(page for page in pages if (site / page).resolve() not in reached) == []


def test_every_command_and_every_option_is_in_the_reference(site: Path) -> None:
    text = text_of(site / "reference" / "cli.html")
    commands = vars(typer.main.get_command(app))["commands"]
    assert len(commands) >= 7
    for name, command in commands.items():
        assert f"echoplan {name}" in text
        shown = [each for each in command.params if not each.hidden]
        options = [option for each in shown for option in each.opts if option.startswith("-")]
        assert [option for option in options if option not in text] == []


def test_every_public_name_is_in_the_reference(site: Path) -> None:
    pages = "".join(page.read_text(encoding="utf-8") for page in (site / "reference").glob("python-*.html"))
    assert [name for name in dir(echoplan) if f'id="echoplan.{name}"' not in pages] == []


def setting_names(settings: type[BaseModel], prefix: str = "") -> Iterator[str]:
    """Yield the dotted names of all settings."""
    for name, field in settings.model_fields.items():
        if isinstance(field.annotation, type) and issubclass(field.annotation, BaseModel):
            yield from setting_names(field.annotation, f"{prefix}{name}.")
        else:
            yield prefix + name


def test_every_setting_of_joint_is_in_the_reference(site: Path) -> None:
    text = text_of(site / "reference" / "joint-settings.html")
    names = list(setting_names(JointSettings))
    assert len(names) > 30
    assert [name for name in names if name not in text] == []


def test_no_page_needs_the_network(site: Path) -> None:
    loaded = [
        (page.name, link)
        for page in site.rglob("*.html")
        for link in re.findall(
            r'<(?:script|img|link rel="stylesheet")[^>]+(?:src|href)="(https?:[^"]+)"', page.read_text(encoding="utf-8")
        )
    ]
    assert loaded == []
