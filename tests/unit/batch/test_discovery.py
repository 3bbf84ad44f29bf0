"""Which recordings a batch finds."""

from pathlib import Path

import pytest

from echoplan.batch import find_recordings
from echoplan.errors import InputError
from echoplan.io.ros import is_bag


def write(folder: Path, *names: str) -> None:
    for name in names:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("x", encoding="utf-8")


def names(folder: Path, **options: Path) -> list[str]:
    return [each.name for each in find_recordings(folder, **options)]


def test_folders_with_pings_and_bags_are_found_at_any_depth_in_order(tmp_path: Path) -> None:
    write(
        tmp_path, "b/pings.csv", "b/rig.toml", "a/deep/pings.csv", "c.mcap", "d/run.bag", "e/metadata.yaml", "e/e.db3"
    )
    write(tmp_path, "notes.txt", "f/readme.md")
    assert names(tmp_path) == ["a/deep", "b", "c.mcap", "d/run.bag", "e"]


@pytest.mark.parametrize("suffix", [".bag", ".mcap", ".db3"])
def test_every_bag_that_is_found_is_opened_as_one(suffix: str, tmp_path: Path) -> None:
    write(tmp_path, f"run{suffix}")
    assert [is_bag(each.path) for each in find_recordings(tmp_path)] == [True]


def test_a_folder_may_be_a_recording_itself(tmp_path: Path) -> None:
    write(tmp_path / "rec", "pings.csv")
    (found,) = find_recordings(tmp_path / "rec")
    assert (found.name, found.path) == ("rec", tmp_path / "rec")


def test_what_lies_inside_a_recording_is_no_other_recording(tmp_path: Path) -> None:
    write(tmp_path, "a/pings.csv", "a/old/pings.csv", "a/run.mcap")
    assert names(tmp_path) == ["a"]


def test_maps_and_hidden_folders_are_not_searched(tmp_path: Path) -> None:
    write(tmp_path, "a/pings.csv", "out/maps/a/pings.csv", ".git/pings.csv")
    assert names(tmp_path, without=tmp_path / "out" / "maps") == ["a"]


def test_links_are_followed_but_not_in_circles(tmp_path: Path) -> None:
    write(tmp_path, "far/a/pings.csv", "near/b/pings.csv")
    (tmp_path / "near" / "far").symlink_to(tmp_path / "far")
    (tmp_path / "near" / "loop").symlink_to(tmp_path / "near")
    assert names(tmp_path / "near") == ["b", "far/a"]


def test_the_files_of_a_recording_are_those_that_change_its_map(tmp_path: Path) -> None:
    write(tmp_path, "a/pings.csv", "a/rig.toml", "a/truth.json", "a/notes.txt")
    (found,) = find_recordings(tmp_path)
    assert [each.name for each in found.files] == ["pings.csv", "rig.toml", "truth.json"]


@pytest.mark.parametrize(
    ("name", "problem"),
    [("nowhere", "there is no such folder"), ("file", "it is a file"), ("empty", "there is no recording in it")],
)
def test_a_folder_without_recordings_is_refused(name: str, problem: str, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    write(tmp_path, "file")
    with pytest.raises(InputError, match=problem):
        find_recordings(tmp_path / name)
