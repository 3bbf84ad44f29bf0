"""Pages of the site whose text is in the code or beside ``docs/``: commands, settings, CONTRIBUTING.md, CHANGELOG.md.

Each has a stub in ``docs/`` that is read on GitHub; when the site is built, its text is added to or replaces the stub.
"""

import inspect
import os
import re
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from typing import Any, TypeGuard

import typer.main
from pydantic import BaseModel
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment

from echoplan.cli.app import app as command_line
from echoplan.joint.mapper import JointSettings

__all__ = ["command_pages", "setting_tables", "setup"]

DOCS = Path(__file__).parents[1]
# Files beside docs/ that are pages of the site, by their paths from docs/.
PAGES_BESIDE = {"../CONTRIBUTING.md": "contributing", "../CHANGELOG.md": "changelog", "../README.md": "index"}


def setup(app: Sphinx) -> dict[str, bool]:
    """Register with Sphinx."""
    app.connect("source-read", complete)
    app.connect("env-get-outdated", always_outdated)
    return {"parallel_read_safe": True}


def always_outdated(app: Sphinx, env: BuildEnvironment, *_: object) -> list[str]:  # noqa: ARG001 - Sphinx passes it
    """Name the pages whose text comes from elsewhere, so that an incremental build reads them again."""
    return [name for name in ("contributing", "changelog", *GENERATED) if name in env.found_docs]


def complete(app: Sphinx, docname: str, source: list[str]) -> None:  # noqa: ARG001 - Sphinx passes it
    """Put in the generated text, and let links out of ``docs/`` lead to pages of the site."""
    beside = [path for path, name in PAGES_BESIDE.items() if name == docname and name != "index"]
    if beside:
        path = PurePosixPath(beside[0])
        source[0] = with_links_from((DOCS / path).read_text(encoding="utf-8"), folder="..", to=".")
    elif docname in GENERATED:
        source[0] += "\n" + GENERATED[docname]()
    else:
        folder = str(PurePosixPath(docname).parent)
        source[0] = with_links_from(source[0], folder=folder, to=folder)


def with_links_from(text: str, *, folder: str, to: str) -> str:
    """Rewrite relative links of a page in ``folder`` for a page in ``to``; both are relative to ``docs/``."""

    def rewritten(match: re.Match[str]) -> str:
        path = os.path.normpath(PurePosixPath(folder) / match[1])
        page = f"{PAGES_BESIDE[path]}.md" if path in PAGES_BESIDE else path
        return f"]({os.path.relpath(page, to)}"

    return re.sub(r"\]\((?!#|[a-z]+:)([^)#\s]+)", rewritten, text)


def command_pages() -> str:
    """Describe every command: usage, text, arguments and options."""
    commands = vars(typer.main.get_command(command_line))["commands"]
    return "\n".join(line for name, command in commands.items() for line in command_lines(name, command))


def command_lines(name: str, command: Any) -> Iterator[str]:
    """Yield the lines of one command in Markdown."""
    given = [each for each in command.params if not is_option(each)]
    arguments = [each.name.upper() + (" ..." if each.nargs != 1 else "") for each in given]
    required = [f"{each.opts[0]} {kind_of(each)}" for each in command.params if is_option(each) and each.required]
    yield f"## echoplan {name}\n"
    yield f"```text\n{' '.join(['echoplan', name, *arguments, *required, '[OPTIONS]'])}\n```\n"
    for paragraph in re.split(r"\n\s*\n", inspect.cleandoc(command.help or "")):
        example = paragraph.removeprefix("Example: ")
        yield f"```sh\n{example}\n```\n" if example != paragraph else f"{escaped(paragraph)}\n"
    by_panel: dict[str, list[Any]] = {}
    for each in command.params:
        if not each.hidden:
            by_panel.setdefault(each.rich_help_panel or "", []).append(each)
    for panel, parameters in by_panel.items():
        yield from [f"**{panel}**\n"] if panel else []
        yield "| argument or option | meaning | default |\n|---|---|---|"
        yield from map(parameter_row, parameters)
        yield ""


def parameter_row(parameter: Any) -> str:
    """Return the row of one argument or option."""
    names = [*parameter.opts, *parameter.secondary_opts] if is_option(parameter) else [parameter.name.upper()]
    kind = kind_of(parameter) if is_option(parameter) else ""
    written = ", ".join(f"`{name} {kind}`" if kind else f"`{name}`" for name in names)
    return f"| {written} | {escaped(parameter.help or '')} | {default_of(parameter)} |"


def default_of(parameter: Any) -> str:
    """Return what holds where an option is left out."""
    if parameter.required:
        return "required"
    if isinstance(parameter.show_default, str):
        return escaped(parameter.show_default)
    is_plain = isinstance(parameter.default, str | int | float) and not isinstance(parameter.default, bool)
    return f"`{parameter.default}`" if is_plain and parameter.default != "" else ""


def is_option(parameter: Any) -> bool:
    """Return True if it is written with dashes."""
    return bool(parameter.opts[0].startswith("-"))


def kind_of(parameter: Any) -> str:
    """Return what follows an option: nothing for a switch."""
    kinds = {"bool": "", "Path": "PATH", "int": "N", "float": "X", "list": "TEXT"}
    annotation = parameter.type_descriptor.annotation
    return parameter.metavar or kinds.get(getattr(annotation, "__name__", ""), "TEXT")


def setting_tables() -> str:
    """Describe every setting of ``joint``, one table a stage."""
    return "\n".join(settings_lines(JointSettings, name="", title="All stages"))


def settings_lines(settings: type[BaseModel], *, name: str, title: str) -> Iterator[str]:
    """Yield the table of one stage and those of the stages in it."""
    annotations = {key: each.annotation for key, each in settings.model_fields.items()}
    stages = {key: annotation for key, annotation in annotations.items() if is_settings(annotation)}
    plain = {key: each for key, each in settings.model_fields.items() if key not in stages}
    if plain:
        yield f"## {title}\n"
        yield f"{escaped(inspect.cleandoc(settings.__doc__ or '').partition(chr(10))[0])}\n"
        yield "| setting | default | meaning |\n|---|---|---|"
        for key, each in plain.items():
            default = each.get_default(call_default_factory=True)
            yield f"| `{name}{key}` | `{getattr(default, 'value', default)}` | {escaped(each.description or '')} |"
        yield ""
    for key, stage in stages.items():
        yield from settings_lines(stage, name=f"{name}{key}.", title=f"{name}{key}")


def is_settings(annotation: object) -> TypeGuard[type[BaseModel]]:
    """Return True for settings of a stage."""
    return isinstance(annotation, type) and issubclass(annotation, BaseModel)


def escaped(text: str) -> str:
    """Return a text on one line, of which Markdown makes no markup but code."""
    escape_outside_code = r"`[^`]*`|[\\*_<>\[\]|]"
    return re.sub(
        escape_outside_code, lambda found: ("" if found[0][0] == "`" else "\\") + found[0], " ".join(text.split())
    )


GENERATED = {"reference/cli": command_pages, "reference/joint-settings": setting_tables}
