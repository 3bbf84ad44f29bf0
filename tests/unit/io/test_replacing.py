"""Several files change at once, whatever happens in between."""

import errno
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from echoplan.errors import OutputError
from echoplan.io import written_whole
from echoplan.io.scratch import locked
from helpers import killed

pytestmark = pytest.mark.slow

OLD = {"map.json": "old", "run.toml": "old", "pictures/map.png": "old", "map.pgm": "old"}
NEW = {"map.json": "new", "run.toml": "new", "pictures/map.png": "new"}
FOREIGN = {"notes.txt": "mine", "pictures/mine.png": "mine", "more/deep/notes.txt": "mine"}


def content(folder: Path) -> dict[str, str]:
    return {str(path.relative_to(folder)): path.read_text() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with the results of an earlier run and files of the user."""
    for name, text in (OLD | FOREIGN).items():
        path = tmp_path / "out" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return tmp_path / "out"


def test_new_files_replace_old_ones_in_the_same_folder_and_others_stay(folder: Path) -> None:
    before = folder.stat().st_ino
    killed.write_new(folder)
    assert content(folder) == NEW | FOREIGN
    assert folder.stat().st_ino == before
    assert list(folder.parent.iterdir()) == [folder]


@pytest.mark.skipif(sys.platform != "linux", reason="Folders swap their names in one step on Linux only.")
def test_a_run_that_is_killed_leaves_all_old_files_or_all_new_ones(folder: Path) -> None:
    outcomes = []
    for step in range(1, 1000, 7):
        command = [sys.executable, killed.__file__, str(folder), str(step)]
        status = subprocess.run(command, check=False).returncode
        if status == 0:
            break
        assert status == -signal.SIGKILL
        found = content(folder)
        assert found in (OLD | FOREIGN, NEW | FOREIGN), f"killed before step {step}"
        outcomes.append(found["map.json"])
        for name, text in OLD.items():
            (folder / name).write_text(text)
    assert set(outcomes) == {"old", "new"}
    assert content(folder) == NEW | FOREIGN
    assert list(folder.parent.iterdir()) == [folder]


def refuse_run_toml(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the system refuse to rename or link one of the files, as if it were immutable."""
    rename, link = os.replace, os.link

    def checked_replace(source: Path, place: Path) -> None:
        if "run.toml" in (Path(source).name, Path(place).name) and Path(source).read_text() == "old":
            raise PermissionError(errno.EPERM, os.strerror(errno.EPERM))
        rename(source, place)

    def checked_link(source: str, place: str, **options: bool) -> None:
        if Path(source).name == "run.toml" and Path(source).read_text() == "old":
            raise PermissionError(errno.EPERM, os.strerror(errno.EPERM))
        link(source, place, **options)

    monkeypatch.setattr(os, "replace", checked_replace)
    monkeypatch.setattr(os, "link", checked_link)


def test_a_file_that_may_not_be_replaced_leaves_all_as_it_was(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    refuse_run_toml(monkeypatch)
    with pytest.raises(OutputError, match="Operation not permitted; choose a folder that you may write to"):
        killed.write_new(folder)
    assert content(folder) == OLD | FOREIGN
    assert list(folder.parent.iterdir()) == [folder]


def test_without_links_files_are_replaced_one_by_one(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(errno.EPERM, os.strerror(errno.EPERM))

    monkeypatch.setattr(os, "link", refuse)
    killed.write_new(folder)
    assert content(folder) == NEW | FOREIGN


def test_what_others_write_meanwhile_stays(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rename = os.replace

    def write_late(source: Path, place: Path) -> None:
        rename(source, place)
        (folder / "late").mkdir(exist_ok=True)
        (folder / "late" / "notes.txt").write_text("mine")

    monkeypatch.setattr(os, "replace", write_late)
    killed.write_new(folder)
    assert content(folder) == NEW | FOREIGN | {"late/notes.txt": "mine"}


def test_scratch_folders_of_dead_runs_go_and_those_of_living_ones_stay(folder: Path) -> None:
    dead = [folder / ".echoplan-dead", folder.parent / ".echoplan-dead"]
    for path in dead:
        path.mkdir()
        (path / "draft").touch()
    alive = folder.parent / ".echoplan-alive"
    alive.mkdir()
    with locked(alive):
        killed.write_new(folder)
    assert not any(path.exists() for path in dead)
    assert alive.exists()


def test_two_runs_write_into_one_folder(folder: Path) -> None:
    with written_whole(folder) as draft:
        draft.mkdir()
        (draft / "map.json").write_text("first")
        killed.write_new(folder)
    assert content(folder) == NEW | FOREIGN | {"map.json": "first"}
