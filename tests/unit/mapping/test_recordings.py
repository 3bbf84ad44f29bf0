from collections.abc import Iterator
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from echoplan.errors import InputError, InvalidValueError
from echoplan.geometry import compose
from echoplan.io import builtin_rig
from echoplan.joint.localisation import localise
from echoplan.mapping import map_source
from echoplan.mapping.recordings import open_recordings
from echoplan.model import Localisation, Rig, Source, Sweep
from echoplan.simulation import SimulationSettings
from echoplan.sources import open_source


class Unread:
    """A source that must not be read."""

    def __init__(self, rig: str = "rotary-array") -> None:
        self.name = rig
        self.rig: Rig = builtin_rig(rig)

    def __len__(self) -> int:
        return 1

    def __iter__(self) -> Iterator[Sweep]:
        pytest.fail("it was read")


class Moved:
    """A source with poses in another frame."""

    def __init__(self, source: Source, away: np.ndarray) -> None:
        self.name, self.rig, self.source, self.away = source.name, source.rig, source, away

    def __len__(self) -> int:
        return len(self.source)

    def __iter__(self) -> Iterator[Sweep]:
        for sweep in self.source:
            yield replace(sweep, map_from_base=compose(self.away, sweep.map_from_base))


@pytest.mark.parametrize(
    ("sources", "options", "problem"),
    [
        ([Unread(), Unread()], {"method": "rcd"}, "--method: it maps one recording only"),
        ([Unread(), Unread()], {"settings": {"poses": "trust"}}, "--poses: the poses of a recording that goes on"),
        ([Unread()], {"method": "rcd", "start": "nowhere"}, "--start: rcd cannot go on from a map"),
        ([Unread()], {"start": "nowhere"}, "nowhere"),
        ([Unread(), Unread("ring-16")], {}, "ring-16: its sensors are not those of rotary-array"),
    ],
    ids=["method", "poses", "start with another method", "missing map", "sensors"],
)
def test_what_cannot_be_mapped_is_refused_before_it_is_read(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, sources: list[Unread], options: dict[str, object], problem: str
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=problem):
        map_source(sources, **options)  # type: ignore[arg-type]


def test_recordings_of_one_name_have_numbers() -> None:
    opened = open_recordings([Unread(), Unread("ring-16"), Unread()])
    assert opened.names == ("rotary-array (recording 1)", "ring-16", "rotary-array (recording 3)")


@pytest.mark.parametrize(
    ("rigs", "words"),
    [
        (["ring-16"], "ring-16"),
        (["ring-16", "rotary-array"], "ring-16 and rotary-array"),
        (["ring-16", "rotary-array", "ring-16"], "ring-16 and 2 other recordings"),
    ],
)
def test_the_title_names_two_recordings_and_counts_more(rigs: list[str], words: str) -> None:
    assert open_recordings([Unread(rig) for rig in rigs]).in_words == words


def test_one_recording_given_twice_is_refused() -> None:
    with pytest.raises(InputError, match=r"\(recording 2\): it is given twice, so its echoes would count twice; name"):
        map_source([open_source("sim:square,seed=1")] * 2)


@pytest.mark.parametrize(("jaccard_index", "refused"), [(0.69, True), (0.71, False)])
def test_a_recording_of_which_too_little_is_like_the_map_is_refused(
    monkeypatch: pytest.MonkeyPatch, jaccard_index: float, *, refused: bool
) -> None:
    def disagreeing(*words: object, **options: object) -> Localisation:
        return replace(localise(*words, **options), jaccard_index=jaccard_index)  # type: ignore[arg-type]

    recordings = [open_source(f"sim:paper-room,seed={seed}") for seed in (1, 2)]
    monkeypatch.setattr("echoplan.mapping.recordings.localise", disagreeing)
    problem = r"its beginning is not in the map so far: echoes and map agree to only 69 % \(70 % are needed\)"
    with pytest.raises(InputError, match=problem) if refused else nullcontext():
        map_source(recordings)


def test_a_recording_that_begins_in_one_of_several_places_is_refused() -> None:
    recordings = [open_source(f"sim:square,seed={seed}") for seed in (1, 2)]
    turned = Moved(recordings[1], away=np.array([2.0, 1.0, 0.5]))
    places = r"places that look alike: x -?\d\.\d\d m, y .* \(\d\d %\) or x .*; begin it where"
    with pytest.raises(InputError, match=places):
        map_source([recordings[0], turned])


def test_a_recording_that_fits_nowhere_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    def nowhere(*_: object, **__: object) -> Localisation:
        raise InvalidValueError("the echoes fit the map nowhere")

    monkeypatch.setattr("echoplan.mapping.recordings.localise", nowhere)
    with pytest.raises(InputError, match="the echoes fit the map nowhere; begin it where"):
        map_source([open_source(f"sim:paper-room,seed={seed}") for seed in (1, 2)])


def test_a_recording_whose_poses_are_far_from_where_it_was_located_is_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def displaced(*words: object, **options: object) -> Localisation:
        found = localise(*words, **options)  # type: ignore[arg-type]
        return replace(found, poses=found.poses + np.array([0.15, 0.0, 0.0]))

    recordings = [open_source(f"sim:paper-room,seed={seed}") for seed in (1, 2)]
    assert not map_source(recordings).feature_map.changes[0]
    monkeypatch.setattr("echoplan.mapping.recordings.localise", displaced)
    with pytest.raises(
        InputError,
        match=r"its first poses in the map are 0\.1\d m \(median\) from where they were located; begin it where",
    ):
        map_source(recordings)


@pytest.mark.parametrize("seed", [3, 6])
def test_the_first_sweep_is_located_from_later_ones_if_only_these_fit_without_a_guess(
    monkeypatch: pytest.MonkeyPatch, seed: int
) -> None:
    drift = SimulationSettings.model_validate({"odometry": {"along": 0.05, "yaw_per_metre": 0.08}})
    true, drifting = (open_source(f"sim:paper-room,seed={seed}", simulation=each) for each in (None, drift))

    def from_the_fourth_on(*words: object, **options: object) -> Localisation:
        monkeypatch.setattr("echoplan.mapping.recordings.localise", localise)
        found = localise(*words, **options)  # type: ignore[arg-type]
        return replace(found, segments=(replace(found.segments[-1], first=int(found.sweeps[3])),))

    monkeypatch.setattr("echoplan.mapping.recordings.localise", from_the_fourth_on)
    found = map_source([open_source("sim:paper-room,seed=1"), drifting]).feature_map
    first = next(iter(true)).station
    assert not found.changes[0]
    assert np.hypot(*(found.poses[-len(true)] - first)[:2]) < 0.003
