"""Which results a batch trusts."""

import json
import os
from pathlib import Path
from shutil import copytree

import pytest

from echoplan.batch import Job, find_recordings, finished_rows, plan_jobs, run_job
from echoplan.errors import InputError
from echoplan.methods import find_method
from library.fleet import METHOD, write_fleet


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a recording in it that was mapped."""
    folder = tmp_path_factory.mktemp("batch")
    write_fleet(folder / "fleet", 1)
    run_job(planned(folder))
    return folder


@pytest.fixture
def folder(finished: Path, tmp_path: Path) -> Path:
    """A copy of it for each test."""
    copytree(finished, tmp_path / "copy")
    return tmp_path / "copy"


@pytest.fixture
def job(folder: Path) -> Job:
    """The job that was run."""
    return planned(folder)


def planned(folder: Path, method: str = METHOD) -> Job:
    settings = find_method(method).settings_type()
    (job,) = plan_jobs(find_recordings(folder / "fleet"), maps=folder / "maps", method=method, settings=settings)
    return job


def test_the_row_counts_what_is_in_recording_and_map(job: Job) -> None:
    row = finished_rows([job])[job.name]
    assert (row.name, row.status, row.error, row.verdict) == ("site-000/rec-0", "ok", "", "doubtful")
    assert (row.sweeps, row.pings) == (5, 80)
    drawn = json.loads((job.folder / "map.json").read_text(encoding="utf-8"))
    assert (row.walls, row.corners) == (len(drawn["walls"]), len(drawn["corners"]))
    assert row.wall_recall == 1.0
    assert row.seconds is not None
    assert row.seconds > 0


def test_a_finished_recording_is_not_mapped_again(job: Job) -> None:
    before = (job.folder / "map.json").stat()
    assert run_job(job) == finished_rows([job])[job.name]
    assert os.path.samestat(before, (job.folder / "map.json").stat())


def test_other_settings_or_another_method_are_another_job(folder: Path) -> None:
    assert not finished_rows([planned(folder, method="rcd")])


@pytest.mark.parametrize("name", ["pings.csv", "rig.toml", "truth.json"])
def test_a_recording_that_changed_is_another_job(name: str, folder: Path) -> None:
    file = folder / "fleet" / "site-000" / "rec-0" / name
    status = file.stat()
    os.utime(file, ns=(status.st_atime_ns, status.st_mtime_ns + 1))
    assert not finished_rows([planned(folder)])


@pytest.mark.parametrize("text", ["", "{", "{}", '{"format": "echoplan-result/1", "fingerprint": "x", "row": 1}'])
def test_a_result_that_is_cut_off_is_not_trusted(text: str, job: Job) -> None:
    (job.folder / "result.json").write_text(text, encoding="utf-8")
    assert not finished_rows([job])


def test_a_result_without_its_map_is_not_trusted(job: Job) -> None:
    (job.folder / "map.json").unlink()
    assert not finished_rows([job])


def test_the_map_of_a_recording_that_changed_goes_even_if_mapping_fails(job: Job, folder: Path) -> None:
    (folder / "fleet" / "site-000" / "rec-0" / "rig.toml").unlink()
    with pytest.raises(InputError, match="there is no such file"):
        run_job(planned(folder))
    assert list(job.folder.parent.iterdir()) == []


def test_a_link_to_nowhere_stops_no_plan(tmp_path: Path) -> None:
    recording = tmp_path / "fleet" / "a"
    recording.mkdir(parents=True)
    (recording / "pings.csv").write_text("t", encoding="utf-8")
    (recording / "rig.toml").symlink_to(tmp_path / "nowhere")
    assert planned(tmp_path).name == "a"
