"""Cases: a command on mutated files, a reader against itself, or a run that is killed."""

import shutil
from dataclasses import dataclass
from pathlib import Path
from random import Random

import numpy as np

from echoplan.io import read_recording, write_recording
from echoplan.io import table as table_module
from fuzz.mutations import mutate_file, odd_path, spoil_path

__all__ = ["Case", "draw_case", "read_twice"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """What is tried: words of a command, or a function, in a folder of its own.

    Parameters
    ----------
    name : str
        What kind of case it is.
    words : tuple of str
        The command; the first word of a function's case is its name.
    out : str
        The folder that it writes into, relative to that of the case; nothing if it writes none.
    kill_step : int
        Before which change of the file system it is killed; 0 for none.
    kill_time : float
        After how many seconds it is killed; 0 for never.
    """

    name: str
    words: tuple[str, ...]
    out: str = ""
    kill_step: int = 0
    kill_time: float = 0.0

    @property
    def is_killed(self) -> bool:
        """Whether it is killed, unless it ends before."""
        return self.kill_step > 0 or self.kill_time > 0.0


def draw_case(base: Path, folder: Path, rng: Random) -> Case:
    """Copy the base files into a folder, change some of them and choose a command."""
    shutil.copytree(base, folder, dirs_exist_ok=True)
    if rng.random() < 0.5:
        shutil.copytree(folder / "old", folder / "out")
    if (folder / "out").exists() and rng.random() < 0.2:
        # Such a run takes 110 steps and half a second.
        moment = {"kill_step": rng.randrange(1, 110)} if rng.random() < 0.7 else {"kill_time": rng.uniform(0.01, 0.6)}
        return Case(name="kill", words=("map", "rec", "--out", "out", "--method", "rcd"), out="out", **moment)
    # Comparing starts a process of its own, and takes as long as twenty others.
    name = rng.choice([each for each in _COMMANDS for _ in range(1 if each == "compare" else 4)])
    words, files = _COMMANDS[name]
    target = folder / rng.choice(files)
    (spoil_path if rng.random() < 0.05 else mutate_file)(target, rng)
    typed = [*words]
    if rng.random() < 0.1:
        place = rng.randrange(1, len(typed))
        typed[place] = str(odd_path(folder, rng)) if not typed[place].startswith("--") else typed[place]
    out = typed[typed.index("--out") + 1] if "--out" in typed else ""
    return Case(name=name, words=tuple(typed), out=out)


_COMMANDS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "read twice": (("read twice", "rec"), ("rec/pings.csv",)),
    "info": (("info", "rec"), ("rec/pings.csv", "rec/rig.toml")),
    "info --json": (("info", "rec", "--json"), ("rec/pings.csv", "rec/rig.toml")),
    "info sim:": (("info", "sim:world.toml,rig=rec/rig.toml,seed=3"), ("world.toml", "world.csv", "rec/rig.toml")),
    "map": (
        ("map", "rec", "--out", "out", "--method", "rcd"),
        ("rec/pings.csv", "rec/pings.csv", "rec/rig.toml", "rec/truth.json"),
    ),
    "map --config": (("map", "rec", "--out", "out", "--config", "old/run.toml"), ("old/run.toml",)),
    "simulate": (
        ("simulate", "world.toml", "--out", "out", "--rig", "rec/rig.toml", "--config", "rec/run.toml"),
        ("world.toml", "world.csv", "rec/rig.toml", "rec/run.toml"),
    ),
    "compare": (
        ("compare", "rec", "--methods", "rcd", "--out", "out", "--jobs", "1"),
        ("rec/pings.csv", "rec/rig.toml", "rec/truth.json"),
    ),
    "evaluate": (("evaluate", "old", "rec"), ("old/map.json", "rec/truth.json")),
    "evaluate --json": (("evaluate", "old", "world.toml", "--json"), ("old/map.json", "world.toml")),
}


def read_twice(folder: Path) -> None:
    """Read a recording in chunks of two sizes, write it and read it again: the same sweeps, or a refusal each time."""
    whole = _outcome(folder)
    chunk, table_module._CHUNK = table_module._CHUNK, 7
    parts = _outcome(folder)
    table_module._CHUNK = chunk
    _check_same(whole, parts)
    if isinstance(whole, list):
        write_recording(folder / "again", read_recording(folder))
        _check_same(whole, _outcome(folder / "again"))


def _outcome(folder: Path) -> list[np.ndarray] | str:
    try:
        recording = read_recording(folder)
        sweeps = list(recording)
    except ValueError as error:
        return str(error)
    assert len(recording) == len(sweeps), "the count of the sweeps is wrong"
    names = ("stamps_ns", "sensor_ids", "servo_angles", "ranges", "map_from_base")
    return [getattr(sweep, name) for sweep in sweeps for name in names]


def _check_same(one: list[np.ndarray] | str, other: list[np.ndarray] | str) -> None:
    if isinstance(one, str) or isinstance(other, str):
        # Which of several faults is found first depends on the chunk, and so does what the first rows give away.
        assert isinstance(one, str) == isinstance(other, str) or "look like" in f"{one}{other}", f"{one} != {other}"
    else:
        assert len(one) == len(other), "the numbers of sweeps differ"
        assert all(map(_equal, one, other)), "the readings differ"


def _equal(one: np.ndarray, other: np.ndarray) -> bool:
    return np.array_equal(one, other, equal_nan=one.dtype.kind == "f")
