"""Files are read with helpful errors and written whole or not at all."""

import errno
import os
import stat
from collections.abc import Callable
from pathlib import Path

import pytest

from echoplan.errors import InputError, OutputError
from echoplan.io.files import (
    check_folder,
    inside,
    open_text,
    read_text,
    readable,
    write_bytes,
    write_text,
    written_whole,
)


def test_text_is_read_alike_with_and_without_byte_order_mark_and_with_any_line_ends(tmp_path: Path) -> None:
    texts = []
    for number, data in enumerate((b"a\n\xc3\xa4\n", b"\xef\xbb\xbfa\r\n\xc3\xa4\r\n", b"a\r\xc3\xa4\r")):
        path = tmp_path / f"{number}.txt"
        path.write_bytes(data)
        texts.append(read_text(path))
    assert texts == ["a\nä\n"] * 3


def test_bytes_that_are_no_utf8_are_refused_with_their_line(tmp_path: Path) -> None:
    path = tmp_path / "notes.csv"
    path.write_bytes(b"a\nb\nM\xfcnchen\n")
    with pytest.raises(InputError, match=r"notes\.csv, line 3: it is no UTF-8 text; save it as UTF-8"):
        read_text(path)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.toml: there is no such file; check the name"):
        read_text(tmp_path / "none.toml")


def test_a_folder_is_no_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="it is a folder; name a file in it"):
        read_text(tmp_path)


def test_a_file_is_no_folder(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="it lies below a file"):
        read_text(tmp_path / "file" / "rig.toml")


def test_an_unreadable_file_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "rig.toml"
    path.touch()

    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(Path, "open", refuse)
    with pytest.raises(InputError, match=r"rig\.toml: it may not be read; ask its owner for permission"):
        read_text(path)


def test_what_else_the_system_says_is_passed_on(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="Input/output error; check the disk"), readable(tmp_path):
        raise OSError(errno.EIO, "Input/output error")


def test_an_error_of_the_reader_itself_is_not_blamed_on_the_file(tmp_path: Path) -> None:
    write_text(tmp_path / "a.txt", "a")
    with pytest.raises(KeyError), open_text(tmp_path / "a.txt"):
        raise KeyError("a")


def test_text_is_written_as_utf8_with_line_feeds(tmp_path: Path) -> None:
    write_text(tmp_path / "a.txt", "ä\n")
    assert (tmp_path / "a.txt").read_bytes() == b"\xc3\xa4\n"


def test_folders_above_the_target_are_made(tmp_path: Path) -> None:
    write_bytes(tmp_path / "deep" / "down" / "a.png", b"\x89PNG")
    assert (tmp_path / "deep" / "down" / "a.png").read_bytes() == b"\x89PNG"


def test_a_file_is_replaced_and_nothing_else_is_left(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    write_text(path, "old")
    write_text(path, "new")
    assert path.read_text() == "new"
    assert list(tmp_path.iterdir()) == [path]


def test_a_written_file_has_the_permissions_of_any_other(tmp_path: Path) -> None:
    (tmp_path / "plain").touch()
    write_text(tmp_path / "ours", "")
    modes = {stat.S_IMODE((tmp_path / name).stat().st_mode) for name in ("plain", "ours")}
    assert len(modes) == 1


def test_a_link_keeps_pointing_at_the_file_that_is_replaced(tmp_path: Path) -> None:
    write_text(tmp_path / "file", "old")
    (tmp_path / "link").symlink_to("file")
    write_text(tmp_path / "link", "new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "file").read_text() == "new"


def test_a_folder_that_exists_keeps_its_other_files(tmp_path: Path) -> None:
    target = tmp_path / "out"
    (target / "figures").mkdir(parents=True)
    (target / "figures" / "mine.png").touch()
    (target / "map.json").write_text("old")
    with written_whole(target) as draft:
        (draft / "figures").mkdir(parents=True)
        (draft / "figures" / "map.png").touch()
        (draft / "map.json").write_text("new")
    names = sorted(str(path.relative_to(target)) for path in target.rglob("*"))
    assert names == ["figures", "figures/map.png", "figures/mine.png", "map.json"]
    assert (target / "map.json").read_text() == "new"


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt])
def test_when_the_writer_fails_the_target_is_as_before(tmp_path: Path, error: type[BaseException]) -> None:
    path = tmp_path / "a.txt"
    write_text(path, "old")

    def break_off() -> None:
        with written_whole(path) as draft:
            draft.write_text("half")
            raise error

    with pytest.raises(error):
        break_off()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_full_disk_leaves_the_target_as_before(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    write_text(path, "old")
    with pytest.raises(OutputError, match=r"a\.txt: No space left on device; free some space"), written_whole(path):
        Path("/dev/full").write_text("new")
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_disk_that_fills_while_the_file_is_settled_leaves_the_target_as_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    path = tmp_path / "a.txt"
    write_text(path, "old")
    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OutputError, match="No space left on device"):
        write_text(path, "new")
    assert path.read_text() == "old"


def test_a_folder_without_permission_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr("tempfile._os.mkdir", refuse)
    with pytest.raises(OutputError, match=r"a\.txt: Permission denied; choose a folder that you may write to"):
        write_text(tmp_path / "a.txt", "new")


def spoil_with_file(path: Path) -> Path:
    path.touch()
    return path / "a.txt"


def spoil_with_folder(path: Path) -> Path:
    path.mkdir()
    return path


def spoil_with_device(_: Path) -> Path:
    return Path("/dev/full")


@pytest.mark.parametrize(
    ("spoil", "problem"),
    [
        (spoil_with_file, "it lies below a file"),
        (spoil_with_folder, "there is a folder of that name"),
        (spoil_with_device, "it is a device, not a file"),
    ],
)
def test_a_target_that_cannot_be_a_file_is_refused(tmp_path: Path, spoil: Callable[[Path], Path], problem: str) -> None:
    path = spoil(tmp_path / "in the way")
    before = path.exists(), stat.S_IFMT(path.stat().st_mode) if path.exists() else 0
    with pytest.raises(OutputError, match=problem):
        write_text(path, "new")
    assert (path.exists(), stat.S_IFMT(path.stat().st_mode) if path.exists() else 0) == before


def test_a_folder_does_not_replace_a_file(tmp_path: Path) -> None:
    (tmp_path / "out").write_text("mine")
    with pytest.raises(OutputError, match="there is a file of that name"), written_whole(tmp_path / "out") as draft:
        draft.mkdir()
    assert (tmp_path / "out").read_text() == "mine"


def test_a_draft_may_itself_be_written_whole(tmp_path: Path) -> None:
    with written_whole(tmp_path / "out") as draft:
        with written_whole(draft) as inner:
            inner.mkdir()
            write_text(inner / "pings.csv", "t")
        write_text(draft / "truth.json", "{}")
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["pings.csv", "truth.json"]
    assert list(tmp_path.iterdir()) == [tmp_path / "out"]


def test_an_error_from_a_draft_names_the_target(tmp_path: Path) -> None:
    def write_below_a_file() -> None:
        with written_whole(tmp_path / "out") as draft:
            draft.touch()
            write_text(draft / "map.json", "")

    with pytest.raises(OutputError, match="out: it lies below a file") as caught:
        write_below_a_file()
    assert ".echoplan-" not in str(caught.value)


def test_of_a_folder_all_is_replaced_or_nothing(tmp_path: Path) -> None:
    target = tmp_path / "out"
    (target / "map.svg").mkdir(parents=True)
    (target / "map.json").write_text("old")

    def replace_both() -> None:
        with written_whole(target) as draft:
            draft.mkdir()
            (draft / "map.json").write_text("new")
            (draft / "map.svg").write_text("new")

    with pytest.raises(OutputError, match="there is a folder of that name"):
        replace_both()
    assert (target / "map.json").read_text() == "old"
    assert sorted(path.name for path in target.iterdir()) == ["map.json", "map.svg"]


def test_a_folder_that_can_be_made_or_filled_is_let_pass_and_left_alone(tmp_path: Path) -> None:
    (tmp_path / "map.json").write_text("old")
    for folder in (tmp_path, tmp_path / "new", tmp_path / "deep" / "down"):
        check_folder(folder, ["map.json"])
    assert list(tmp_path.iterdir()) == [tmp_path / "map.json"]


def test_a_folder_that_cannot_be_filled_is_refused_beforehand(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").touch()
    (tmp_path / "map.json").mkdir()
    for folder, message in (
        (tmp_path / "file", r"file: there is a file of that name; choose another place"),
        (tmp_path / "file" / "out", r"file/out: it lies below a file, not a folder; choose another place"),
        (tmp_path, r"map\.json: there is a folder of that name; choose another place"),
    ):
        with pytest.raises(OutputError, match=message):
            check_folder(folder, ["map.json"])
    monkeypatch.setattr(os, "access", lambda *_: False)
    with pytest.raises(OutputError, match="new: Permission denied; choose a folder that you may write to"):
        check_folder(tmp_path / "new", ["map.json"])


def test_a_pipe_is_refused_at_once(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pings.csv")
    with pytest.raises(InputError, match=r"pings\.csv: it is a pipe or a device, not a file; save it as a file"):
        read_text(tmp_path / "pings.csv")
    with pytest.raises(InputError, match="it is a pipe or a device"):
        read_text("/dev/null")


@pytest.mark.parametrize("name", ["loop", "loop/x", "loop/x/y"])
def test_links_in_a_circle_are_refused_to_read_and_to_write(tmp_path: Path, name: str) -> None:
    (tmp_path / "loop").symlink_to("loop")
    with pytest.raises(InputError, match="its links lead in a circle; name the file itself"):
        read_text(tmp_path / name)
    with pytest.raises(OutputError, match=r"Too many levels of symbolic links; choose another place"):
        check_folder(tmp_path / name, ["map.json"])
    with pytest.raises(OutputError, match=r"Too many levels of symbolic links; choose another place"):
        write_text(tmp_path / name, "new")


@pytest.mark.parametrize(("name", "problem"), [("a\0b", "zero byte"), ("a" * 300, "its name is too long")])
def test_a_name_that_no_file_can_have_is_refused(tmp_path: Path, name: str, problem: str) -> None:
    with pytest.raises(InputError, match=problem):
        read_text(tmp_path / name)


def test_text_from_a_name_that_is_no_utf8_is_written_with_question_marks(tmp_path: Path) -> None:
    write_text(tmp_path / "a.txt", "r\udce4um")
    assert (tmp_path / "a.txt").read_bytes() == b"r?um"


def test_a_file_may_be_named_by_its_folder(tmp_path: Path) -> None:
    assert inside(tmp_path, "map.json") == tmp_path / "map.json"
    (tmp_path / "other.json").touch()
    assert inside(tmp_path / "other.json", "map.json") == tmp_path / "other.json"
    assert inside(tmp_path / "missing", "map.json") == tmp_path / "missing"
