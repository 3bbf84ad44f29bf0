"""Mutations: small changes of files and odd paths, drawn at random."""

import os
import re
from collections.abc import Callable
from pathlib import Path
from random import Random

__all__ = ["mutate_file", "odd_path", "spoil_path"]

_NUMBER = re.compile(rb"[-+]?[0-9]+(?:\.[0-9]+)?(?:[eE][-+]?[0-9]+)?")
_NUMBERS = (
    *(b"0", b"-1", b"-0.0", b"1e-300", b"1e300", b"-1e308", b"1e999", b"nan", b"inf", b"-inf", b"1_000", b"0x10"),
    *(b"", b" ", b"1.2.3", b"40.-725", b"3 1", b"1e6", b"-1e6", b"2e7", b"9999.9", b"9" * 25, b"9" * 5000, b"true"),
    *(b"1e-6", b"1e-12", b"1000", b"100000", b"0.5", b"3", b"[1]", b'"1"', b"{}", b"null", b"'", "\u0663".encode()),
)
_CHARACTERS = (
    *(b'"', b"'", b",", b"\n", b"\r", b"\0", b"\xff", b"#", b"=", b"[", b"]", b"{", b"}", b".", b"-", b"\t", b"\\"),
    *("\ufffd".encode(), "\u2028".encode(), b"\xef\xbb\xbf", b"[[", b'"""', b"a." * 50, b"[" * 3000, b"x" * 200_000),
)


def mutate_file(path: Path, rng: Random) -> None:
    """Change a file in one to three places."""
    data = path.read_bytes()
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        data = rng.choice(_MUTATIONS)(data, rng)
    path.write_bytes(data)


def _other_number(data: bytes, rng: Random) -> bytes:
    found = list(_NUMBER.finditer(data))
    if not found:
        return data
    place = rng.choice(found)
    return data[: place.start()] + rng.choice(_NUMBERS) + data[place.end() :]


def _other_character(data: bytes, rng: Random) -> bytes:
    at = rng.randrange(len(data) + 1)
    return data[:at] + rng.choice(_CHARACTERS) + data[at + rng.randrange(2) :]


def _other_column(data: bytes, rng: Random) -> bytes:
    """Put the same number into a field of many lines, as a wrong unit or a broken sensor does."""
    lines, text = data.split(b"\n"), rng.choice(_NUMBERS)
    column, first = rng.randrange(8), rng.randrange(1, max(2, len(lines)))
    for number in range(first, len(lines)):
        fields = lines[number].split(b",")
        if column < len(fields) > 2:
            fields[column] = text
            lines[number] = b",".join(fields)
    return b"\n".join(lines)


def _other_lines(data: bytes, rng: Random) -> bytes:
    lines = data.split(b"\n")
    one, other = sorted((rng.randrange(len(lines)), rng.randrange(len(lines))))
    action = rng.randrange(4)
    if action == 0:
        del lines[one:other]
    elif action == 1:
        lines[one], lines[other] = lines[other], lines[one]
    elif action == 2:
        lines[one:one] = lines[one:other]
    else:
        return b"\n".join(lines)[: rng.randrange(len(data) + 1)]
    return b"\n".join(lines)


_MUTATIONS: tuple[Callable[[bytes, Random], bytes], ...] = (
    *(_other_number, _other_number, _other_number),
    *(_other_character, _other_column, _other_lines),
)


def odd_path(folder: Path, rng: Random) -> Path:
    """Make something odd in a folder, or nothing, and return its path."""
    path = folder / os.fsdecode(
        rng.choice((b"odd", b"odd \xe4", b"=odd", b"-odd", b"odd\nname", "odd \u00df".encode()))
    )
    if not path.exists():
        rng.choice((_nothing, _loop, _dangling, _fifo, _file, _empty_folder))(path)
    return rng.choice((path, path, path / "below", folder / ("n" * 300), Path("/dev/null"), Path("/proc/self/mem")))


def spoil_path(path: Path, rng: Random) -> None:
    """Put something odd in the place of a file."""
    path.unlink()
    rng.choice((_nothing, _loop, _dangling, _fifo, _empty_folder))(path)


def _nothing(_: Path) -> None: ...


def _loop(path: Path) -> None:
    path.symlink_to(path.name)


def _dangling(path: Path) -> None:
    path.symlink_to("nowhere")


def _fifo(path: Path) -> None:
    os.mkfifo(path)


def _file(path: Path) -> None:
    path.write_text("a file")


def _empty_folder(path: Path) -> None:
    path.mkdir()
