"""The commands as they are typed: what they write, what they say, and how they refuse."""

import contextlib
import errno
import json
import os
import pty
import re
import subprocess
import sys
import tomllib
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from echoplan.cli import main as application
from echoplan.io import builtin_world, read_grid, read_map, read_recording, read_truth, write_recording, write_world
from echoplan.model import Conventions, Heading, Recording, Verdict
from echoplan.sources import open_source
from helpers.typed import echoplan, succeed

COMMAND = [sys.executable, "-m", "echoplan"]
RESULTS = ["map.json", "map.svg", "report.html", "run.toml", "trajectory.tum"]
# A map of joint has what another recording needs to go on from it.
OF_JOINT = sorted([*RESULTS, "prior.npz"])


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording of a square room with the truth beside it."""
    folder = tmp_path_factory.mktemp("commands") / "rec"
    succeed("simulate", "square", "--out", folder, "--seed", "4")
    return folder


@pytest.fixture(scope="module")
def mapped(recording: Path) -> Path:
    """The map of the recording."""
    folder = recording.parent / "map"
    succeed("map", recording, "--out", folder)
    return folder


def with_a_stuck_sensor(recording: Path, folder: Path) -> Path:
    """A recording in which sensor 2 always reads 1.27 m."""
    source = read_recording(recording)
    sweeps = tuple(replace(sweep, ranges=np.where(sweep.sensor_ids == 2, 1.27, sweep.ranges)) for sweep in source)
    write_recording(folder, Recording(name="stuck", rig=source.rig, sweeps=sweeps))
    return folder


class TestSimulate:
    def test_it_writes_a_recording_its_truth_and_its_settings(self, recording: Path) -> None:
        assert names(recording) == ["pings.csv", "rig.toml", "run.toml", "truth.json"]
        assert len(read_recording(recording)) == 5
        assert len(read_truth(recording / "truth.json").walls_xy) == 4
        run = tomllib.loads((recording / "run.toml").read_text(encoding="utf-8"))["run"]
        assert (run["source"], run["seed"]) == ("sim:square,rig=rotary-array,seed=4", 4)
        again = [sweep.ranges for sweep in open_source(run["source"])]
        recorded = [sweep.ranges for sweep in read_recording(recording)]
        np.testing.assert_allclose(np.concatenate(again), np.concatenate(recorded), atol=1e-6)

    def test_its_source_names_another_rig_and_route(self, tmp_path: Path) -> None:
        way = tmp_path / "way, short.csv"
        way.write_text("x,y,yaw\n0.5,0.5,0\n", encoding="utf-8")
        succeed("simulate", "square", "--rig", "ring-16", "--route", way, "--out", tmp_path / "rec")
        run = tomllib.loads((tmp_path / "rec" / "run.toml").read_text(encoding="utf-8"))["run"]
        again, recorded = next(iter(open_source(run["source"]))), next(iter(read_recording(tmp_path / "rec")))
        np.testing.assert_allclose(again.ranges, recorded.ranges, atol=1e-6)
        assert again.station.tolist() == [0.5, 0.5, 0.0]

    def test_an_unknown_material_is_reported_with_its_world(self, tmp_path: Path) -> None:
        world = tmp_path / "attic.toml"
        world.write_text('[[wall]]\npoints = [[2, -1], [2, 1]]\nmaterial = "woood"\n', encoding="utf-8")
        done = echoplan("simulate", world, "--route", "square", "--out", tmp_path / "rec")
        assert done.status == 2
        assert f"{world}: unknown material 'woood'; did you mean 'wood'? known: brick" in done.err

    def test_a_route_out_of_reach_of_everything_is_refused(self, tmp_path: Path) -> None:
        route = tmp_path / "route.csv"
        route.write_text("x,y,yaw\n60.0,60.0,0.2\n140.0,70.0,0.9\n", encoding="utf-8")
        done = echoplan("simulate", "square", "--route", route, "--out", tmp_path / "rec")
        assert done.status == 2
        assert f"{route}: nothing of the world 'square' is in reach of it: the nearest is 81.7 m away" in done.err
        assert names(tmp_path) == ["route.csv"]

    def test_it_says_where_it_put_them(self, tmp_path: Path) -> None:
        assert f"{tmp_path / 'rec'}: pings.csv, rig.toml, truth.json" in succeed(
            "simulate", "square", "--out", tmp_path / "rec"
        )

    def test_another_process_gives_the_same_bytes_for_the_same_seed_and_others_for_another(
        self, recording: Path, tmp_path: Path
    ) -> None:
        command = [*COMMAND, "simulate", "square", "--out", "again", "--seed", "4"]
        subprocess.run(command, cwd=tmp_path, capture_output=True, check=True)
        for name in names(recording):
            assert (tmp_path / "again" / name).read_bytes() == (recording / name).read_bytes()
        succeed("simulate", "square", "--out", tmp_path / "other", "--seed", "5")
        assert (tmp_path / "other" / "pings.csv").read_bytes() != (recording / "pings.csv").read_bytes()

    def test_settings_are_applied_and_recorded_so_that_a_run_can_be_repeated(self, tmp_path: Path) -> None:
        (tmp_path / "deaf.toml").write_text("[simulation]\ndropout = 0.6\n", encoding="utf-8")
        succeed("simulate", "square", "--config", tmp_path / "deaf.toml", "--out", tmp_path / "deaf")
        ranges = np.concatenate([sweep.ranges for sweep in read_recording(tmp_path / "deaf")])
        assert np.isinf(ranges).mean() > 0.55
        succeed("simulate", "square", "--config", tmp_path / "deaf" / "run.toml", "--out", tmp_path / "again")
        first, again = ((tmp_path / name / "pings.csv").read_bytes() for name in ("deaf", "again"))
        assert first == again

    def test_a_world_file_is_simulated_along_the_route_beside_it(self, tmp_path: Path) -> None:
        write_world(tmp_path / "attic.toml", builtin_world("hexagon"))
        (tmp_path / "attic.csv").write_text("x,y,yaw\n0.1,0,0\n0.4,0.2,1\n", encoding="utf-8")
        succeed("simulate", tmp_path / "attic.toml", "--rig", "hc-sr04-servo", "--out", tmp_path / "rec")
        first, second = read_recording(tmp_path / "rec")
        assert first.station.tolist() == [0.1, 0.0, 0.0]
        assert second.station.tolist() == [0.4, 0.2, 1.0]


class TestMap:
    def test_it_writes_a_map_a_drawing_a_report_and_its_settings(self, recording: Path, mapped: Path) -> None:
        assert names(mapped) == OF_JOINT
        found = read_map(mapped / "map.json")
        assert (found.method, len(found.walls), len(found.poses)) == ("joint", 4, 5)
        assert ET.parse(mapped / "map.svg").getroot().tag.endswith("svg")
        report = (mapped / "report.html").read_text(encoding="utf-8")
        assert all(f"</svg>{words}" in report for words in ("wall", "concave corner", "cylinder", "station"))
        run = tomllib.loads((mapped / "run.toml").read_text(encoding="utf-8"))
        assert run["run"]["source"] == str(recording)
        assert run["method"]["poses"] == "auto"

    def test_a_stuck_sensor_is_left_out_and_named(self, recording: Path, tmp_path: Path) -> None:
        said = succeed("map", with_a_stuck_sensor(recording, tmp_path / "stuck"), "--out", tmp_path / "map")
        sentence = "Sensor 2 reads 1.27 m wherever the robot stands and the sensor points. It is left out."
        assert sentence in said
        assert sentence in (tmp_path / "map" / "report.html").read_text(encoding="utf-8")
        assert len(read_map(tmp_path / "map" / "map.json").walls) == 4

    @pytest.mark.parametrize(("kept", "stations", "method"), [(0.0, 5, "rcd"), (0.0, 5, "joint"), (1.0, 1, "joint")])
    def test_without_positions_or_from_one_place_no_features_are_drawn(
        self, recording: Path, tmp_path: Path, kept: float, stations: int, method: str
    ) -> None:
        source = read_recording(recording)
        sweeps = tuple(replace(sweep, map_from_base=kept * sweep.map_from_base) for sweep in source)[:stations]
        write_recording(tmp_path / "rec", Recording(name="rec", rig=source.rig, sweeps=sweeps))
        done = echoplan("map", tmp_path / "rec", "--out", tmp_path / "map", "--method", method)
        assert done.status == 0
        assert ("from one place" if kept else "no positions in this recording") in done.out
        found = read_map(tmp_path / "map" / "map.json")
        assert found.is_empty
        assert len(found.poses) == stations
        assert "echoes as points" in (tmp_path / "map" / "report.html").read_text(encoding="utf-8")

    def test_a_recording_without_echoes_is_reported_with_what_to_check(self, recording: Path, tmp_path: Path) -> None:
        original = read_recording(recording)
        silent = tuple(replace(sweep, ranges=np.full(len(sweep.ranges), np.inf)) for sweep in original)
        write_recording(tmp_path / "rec", Recording(name="silent", rig=original.rig, sweeps=silent))
        done = echoplan("map", tmp_path / "rec", "--out", tmp_path / "map")
        said = done.out
        assert done.status == 0
        assert said.splitlines()[0] == "Failed map: it does not show the room."
        assert "No wall, corner or cylinder was found." in said
        assert "Next step: " in said

    def test_the_first_line_says_whether_the_map_is_good(self, mapped: Path, recording: Path, tmp_path: Path) -> None:
        said = succeed("map", recording, "--out", tmp_path, "--strict")
        assert said.startswith("Good map: ")
        quality = read_map(mapped / "map.json").quality
        assert quality is not None
        assert quality.verdict is Verdict.GOOD
        assert "Good map: " in (mapped / "report.html").read_text(encoding="utf-8")

    def test_map_says_why_each_wall_is_in_the_map(self, recording: Path, tmp_path: Path) -> None:
        said = succeed("map", recording, "--out", tmp_path / "map", "--why")
        for number in range(4):
            assert re.search(
                rf"^wall {number}: added: log-likelihood ratio [0-9.]+ > 12\.0; detections \+", said, re.MULTILINE
            )
        assert "Why landmarks are in the map or not" in (tmp_path / "map" / "report.html").read_text(encoding="utf-8")

    def test_a_failed_map_is_written_with_the_remedy_that_makes_it_good(self, tmp_path: Path) -> None:
        # One sensor: with four, as in the tests of the assessment, a map without any explanation takes long.
        original = open_source("sim:square,rig=hc-sr04-servo,seed=4")
        mirrored = tuple(map(Conventions(servo_sign=-1).undo, original))[:4]
        write_recording(tmp_path / "rec", Recording(name="mirrored", rig=original.rig, sweeps=mirrored))
        done = echoplan("map", tmp_path / "rec", "--out", tmp_path / "map", "--strict")
        assert done.status == 2
        assert done.err.startswith("echoplan: the map failed: The servo seems to turn clockwise: ")
        quality = read_map(tmp_path / "map" / "map.json").quality
        assert quality is not None
        assert "set servo_sign = -1 under [conventions] in rig.toml" in quality.next_step.lower()
        with (tmp_path / "rec" / "rig.toml").open("a", encoding="utf-8") as file:
            file.write("\n[conventions]\nservo_sign = -1\n")
        assert succeed("map", tmp_path / "rec", "--out", tmp_path / "map", "--strict").startswith("Good map: ")

    def test_it_says_what_it_found(self, recording: Path, tmp_path: Path) -> None:
        assert "4 walls, 4 corners and 0 cylinders" in succeed("map", recording, "--out", tmp_path)

    def test_a_simulation_is_mapped_as_its_recording_is(self, recording: Path, mapped: Path, tmp_path: Path) -> None:
        succeed("map", "sim:square,seed=4", "--out", tmp_path)
        recorded, simulated = (read_map(folder / "map.json") for folder in (mapped, tmp_path))
        assert len(recorded.walls) == len(simulated.walls)
        for one, other in zip(recorded.walls, simulated.walls, strict=True):
            assert one.endpoints_xy == pytest.approx(other.endpoints_xy, abs=1e-6)

    def test_a_run_can_be_run_again_from_its_own_record(self, recording: Path, tmp_path: Path) -> None:
        (tmp_path / "c.toml").write_text("[method.clustering]\nmin_pings = 6\n", encoding="utf-8")
        succeed("map", recording, "--method", "rcd", "--config", tmp_path / "c.toml", "--out", tmp_path / "first")
        succeed("map", recording, "--config", tmp_path / "first" / "run.toml", "--out", tmp_path / "again")
        first, again = (tmp_path / out / "map.json" for out in ("first", "again"))
        assert first.read_bytes() == again.read_bytes()
        found = read_map(first)
        assert found.method == "rcd"
        assert dict(found.parameters)["clustering"]["min_pings"] == 6  # type: ignore[index]

    def test_a_grid_method_also_writes_its_grid_for_map_server(self, recording: Path, tmp_path: Path) -> None:
        said = succeed("map", recording, "--method", "grid-bayes", "--out", tmp_path)
        assert names(tmp_path) == sorted([*RESULTS, "map.pgm", "map.yaml"])
        assert "map.yaml, map.pgm" in said
        grid = read_grid(tmp_path / "map.yaml")
        first, *_ = read_recording(recording)
        assert grid.values[tuple(grid.cells_of(first.station[:2]))] == 0.0

    def test_another_run_takes_away_the_grid_of_an_earlier_one(self, recording: Path, tmp_path: Path) -> None:
        for method in ("grid-bayes", "rcd"):
            succeed("map", recording, "--method", method, "--out", tmp_path)
        assert names(tmp_path) == sorted(RESULTS)

    def test_a_grid_that_no_run_left_there_stays(self, recording: Path, tmp_path: Path) -> None:
        (tmp_path / "map.yaml").write_text("image: mine.png", encoding="utf-8")
        succeed("map", recording, "--method", "rcd", "--out", tmp_path)
        assert (tmp_path / "map.yaml").read_text(encoding="utf-8") == "image: mine.png"

    def test_other_files_in_the_folder_stay(self, recording: Path, tmp_path: Path) -> None:
        (tmp_path / "notes.txt").write_text("mine", encoding="utf-8")
        succeed("map", recording, "--method", "rcd", "--out", tmp_path)
        assert names(tmp_path) == sorted([*RESULTS, "notes.txt"])
        assert (tmp_path / "notes.txt").read_text(encoding="utf-8") == "mine"


class TestEvaluate:
    def test_it_says_why_poses_are_not_compared(self, mapped: Path, recording: Path, tmp_path: Path) -> None:
        truth = json.loads((recording / "truth.json").read_text(encoding="utf-8"))
        shorter = {name: rows[:3] if name in ("poses", "given") else rows for name, rows in truth.items()}
        (tmp_path / "truth.json").write_text(json.dumps(shorter), encoding="utf-8")
        said = succeed("evaluate", mapped, tmp_path)
        assert said.splitlines()[-1] == "Poses are not compared: the map has 5, the truth 3."
        assert "not compared" not in succeed("evaluate", mapped, recording)

    def test_a_map_can_be_compared_with_a_world(self, mapped: Path, tmp_path: Path) -> None:
        write_world(tmp_path / "world.toml", builtin_world("square"))
        assert "everywhere" in succeed("evaluate", mapped, tmp_path / "world.toml")

    def test_folders_and_files_are_the_same_to_it(self, recording: Path, mapped: Path) -> None:
        by_folder = succeed("evaluate", mapped, recording)
        assert by_folder == succeed("evaluate", mapped / "map.json", recording / "truth.json")
        assert "Accuracy of the walls" in by_folder
        assert "Recall and precision" in by_folder

    def test_on_request_all_numbers_are_json(self, recording: Path, mapped: Path) -> None:
        document = json.loads(succeed("evaluate", mapped, recording, "--json"))
        assert document["method"] == "joint"
        assert (document["walls"]["recall"], document["walls"]["precision"]) == (1.0, 1.0)
        table = succeed("evaluate", mapped, recording)
        rows = [line.split() for line in table.splitlines() if re.match(r"[1-4]\s", line)]
        assert [row[0] for row in rows] == ["1", "2", "3", "4"]
        assert all(float(row[1]) < 5.0 for row in rows)

    def test_features_detected_by_few_stations_do_not_count_as_missed(self, recording: Path, mapped: Path) -> None:
        asked = [
            json.loads(succeed("evaluate", mapped, recording, "--json", "--min-stations", stations))["walls"]["wanted"]
            for stations in ("5", "6")
        ]
        assert asked == [4, 0]

    def test_the_former_name_of_min_stations_still_works_with_a_warning(self, recording: Path, mapped: Path) -> None:
        former = echoplan("evaluate", mapped, recording, "--min-heard", "6")
        assert (former.status, former.out) == (0, succeed("evaluate", mapped, recording, "--min-stations", "6"))
        assert "--min-stations" in former.err
        assert former.err.count("\n") == 1


class TestInfo:
    def test_it_counts_sweeps_and_pings_by_their_results(self, recording: Path) -> None:
        text = succeed("info", recording)
        assert "5 sweeps, 1820 pings" in text
        rows = [line.split() for line in text.splitlines() if re.match(r"[0-3]\s", line)]
        assert [row[1] for row in rows] == ["455"] * 4
        for row in rows:
            assert sum(map(float, row[2:6])) == pytest.approx(100.0, abs=0.2)

    def test_it_prints_the_temperature_if_it_was_measured(self, recording: Path, tmp_path: Path) -> None:
        assert "Celsius" not in succeed("info", recording)
        assert json.loads(succeed("info", recording, "--json"))["temperature"] is None
        config = tmp_path / "warm.toml"
        config.write_text("[simulation]\nthermometer = 0.0\nair = { temperature = 28.5 }\n")
        succeed("simulate", "square", "--config", config, "--out", tmp_path / "warm")
        assert "air of 28.5 degrees Celsius" in succeed("info", tmp_path / "warm")
        assert json.loads(succeed("info", tmp_path / "warm", "--json"))["temperature"] == 28.5

    def test_on_request_all_numbers_are_json(self, recording: Path) -> None:
        document = json.loads(succeed("info", recording, "--json"))
        assert (document["sweeps"], document["pings"], document["rig"]) == (5, 1820, "rotary array")
        assert [sensor["pings"] for sensor in document["sensors"]] == [455] * 4
        assert document["sensors"][0]["shortest"] < document["sensors"][0]["longest"] < 3.0

    def test_it_names_what_seems_to_be_wrong(self, tmp_path: Path) -> None:
        source = "sim:square,rig=hc-sr04-servo,seed=4"
        assert "No mistake was found in how the recording is written." in succeed("info", source)
        original = open_source(source)
        compass = tuple(map(Conventions(heading=Heading.COMPASS).undo, original))[:4]
        write_recording(tmp_path / "rec", Recording(name="compass", rig=original.rig, sweeps=compass))
        assert 'Set heading = "compass" under [conventions]' in succeed("info", tmp_path / "rec")
        assert json.loads(succeed("info", tmp_path / "rec", "--json"))["quality"]["verdict"] == "failed"

    def test_the_ranges_of_a_sensor_without_echoes_are_null(self, recording: Path, tmp_path: Path) -> None:
        (tmp_path / "rig.toml").write_bytes((recording / "rig.toml").read_bytes())
        rows = "t,sweep,sensor,servo,range,x,y,yaw\n0.1,0,0,0,1.5,0,0,0\n0.2,0,1,0,inf,0,0,0\n"
        (tmp_path / "pings.csv").write_text(rows, encoding="utf-8")
        document = json.loads(succeed("info", tmp_path, "--json"))
        assert [sensor["longest"] for sensor in document["sensors"][:2]] == [1.5, None]

    def test_it_says_what_is_wrong_with_the_readings_and_what_to_do(self, recording: Path, tmp_path: Path) -> None:
        assert json.loads(succeed("info", recording, "--json"))["faults"] == []
        stuck = with_a_stuck_sensor(recording, tmp_path / "stuck")
        said = "Sensor 2 reads 1.27 m wherever the robot stands and the sensor points. It is left out."
        assert said in succeed("info", stuck)
        document = json.loads(succeed("info", stuck, "--json"))
        assert document["faults"] == [{"sensor_id": 2, "kind": "stuck", "value": 1.27, "share": 1.0}]


BAD_INPUT = {
    "map of nothing": (["map", "nowhere", "--out", "out"], "nowhere: there is no such file or folder"),
    "map by no method": (
        ["map", "REC", "--method", "rdc", "--out", "out"],
        "unknown method 'rdc'; did you mean 'rcd'?",
    ),
    "map by a misspelt key": (
        ["map", "REC", "--method", "mdp-fuzzy", "--config", "typo.toml", "--out", "out"],
        "typo.toml, line 2, method.filtre: the key 'filtre' is unknown; did you mean 'filter'?",
    ),
    "map by a bad value": (
        ["map", "REC", "--method", "mdp-fuzzy", "--config", "value.toml", "--out", "out"],
        "must be greater than",
    ),
    "map with no such poses": (["map", "REC", "--poses", "guess", "--out", "out"], "unknown value of --poses 'guess'"),
    "poses of another method": (
        ["map", "REC", "--method", "rcd", "--poses", "trust", "--out", "out"],
        "use --method joint",
    ),
    "map by no config": (["map", "REC", "--config", "none.toml", "--out", "out"], "none.toml: there is no such file"),
    "map into a file": (
        ["map", "REC", "--out", "typo.toml"],
        "typo.toml: there is a file of that name",
    ),
    "map of a broken recording": (["map", "broken", "--out", "out"], "broken/pings.csv"),
    "map of no world": (["map", "sim:sqare", "--out", "out"], "unknown world 'sqare'; did you mean 'square'?"),
    "map of a bad option": (["map", "sim:square,sead=3", "--out", "out"], "unknown option 'sead'"),
    "simulation of no world": (["simulate", "cellar", "--out", "out"], "unknown world 'cellar'"),
    "simulation of no file": (["simulate", "cellar.toml", "--out", "out"], "cellar.toml"),
    "simulation by no rig": (["simulate", "square", "--rig", "ring", "--out", "out"], "unknown rig 'ring'"),
    "simulation on no route": (["simulate", "square", "--route", "way.csv", "--out", "out"], "way.csv"),
    "simulation of wool": (["simulate", "wool.toml", "--route", "square", "--out", "out"], "unknown material 'wool'"),
    "simulation by a misspelt key": (
        ["simulate", "square", "--config", "typo.toml", "--out", "out"],
        "typo.toml, line 1",
    ),
    "simulation before time": (["simulate", "square", "--seed", "-1", "--out", "out"], "seed must be at least 0"),
    "simulation into a file": (["simulate", "square", "--out", "typo.toml"], "typo.toml: there is a file of that name"),
    "evaluation of nothing": (["evaluate", "nowhere", "REC"], "nowhere: there is no such file"),
    "evaluation against nothing": (["evaluate", "MAP", "nowhere"], "nowhere: there is no such file"),
    "evaluation of what is no map": (["evaluate", "REC/truth.json", "REC"], "truth.json"),
    "info of nothing": (["info", "square"], "square: there is no such file or folder; name sim:square"),
    "info of a broken recording": (["info", "broken"], "broken/pings.csv, line 3"),
}


class TestBadInput:
    @pytest.fixture
    def place(self, tmp_path: Path, recording: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
        """A folder with files in which something is wrong."""
        (tmp_path / "typo.toml").write_text("[method]\nfiltre = 4\n", encoding="utf-8")
        (tmp_path / "value.toml").write_text("[method.filter]\nmin_members = 0\n", encoding="utf-8")
        wool = '[[wall]]\npoints = [[1, 0], [1, 1]]\nmaterial = "wool"\n'
        (tmp_path / "wool.toml").write_text(wool, encoding="utf-8")
        (tmp_path / "broken").mkdir()
        (tmp_path / "broken" / "rig.toml").write_bytes((recording / "rig.toml").read_bytes())
        lines = (recording / "pings.csv").read_text(encoding="utf-8").splitlines()
        lines[2] = lines[2].replace(",", ";")
        (tmp_path / "broken" / "pings.csv").write_text("\n".join(lines), encoding="utf-8")
        monkeypatch.chdir(tmp_path)
        return tmp_path

    @pytest.mark.parametrize(("words", "message"), BAD_INPUT.values(), ids=list(BAD_INPUT))
    def test_it_is_refused_with_status_2_in_one_line_and_nothing_is_written(
        self, words: list[str], message: str, place: Path, recording: Path, mapped: Path
    ) -> None:
        before = sorted(path.as_posix() for path in place.rglob("*"))
        done = echoplan(*(word.replace("REC", str(recording)).replace("MAP", str(mapped)) for word in words))
        assert done.status == 2
        (line,) = done.err.splitlines()
        assert line.startswith("echoplan: ")
        assert message in line
        assert sorted(path.as_posix() for path in place.rglob("*")) == before

    def test_what_was_there_before_is_not_touched(self, place: Path, recording: Path, mapped: Path) -> None:
        kept = (mapped / "map.json").read_bytes()
        assert echoplan("map", recording, "--config", "typo.toml", "--out", mapped).status == 2
        assert echoplan("map", "broken", "--out", mapped).status == 2
        assert (mapped / "map.json").read_bytes() == kept
        assert names(mapped) == OF_JOINT

    def test_a_folder_that_cannot_be_written_is_reported_before_any_work(
        self, place: Path, recording: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr("echoplan.sources.open_source", lambda _: pytest.fail("the recording was opened"))
        for command in ("map REC", "compare REC --methods rcd"):
            done = echoplan(*command.replace("REC", str(recording)).split(), "--out", "typo.toml")
            assert done.status == 2
            assert done.err.startswith("echoplan: typo.toml: there is a file of that name; choose another place")

    def test_a_full_disk_leaves_no_partial_results(
        self, recording: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        def full(*_: object) -> None:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

        monkeypatch.setattr("echoplan.config.write_text", full)
        for command in (f"map {recording} --method rcd", "simulate square"):
            done = echoplan(*command.split(), "--out", tmp_path / "out")
            assert (done.status, len(done.err.splitlines())) == (2, 1)
            assert "No space left on device; free some space" in done.err
            assert list(tmp_path.iterdir()) == []

    def test_no_traceback_reaches_the_terminal(self, place: Path) -> None:
        command = [*COMMAND, "info", "broken"]
        done = subprocess.run(command, cwd=place, capture_output=True, text=True, check=False)
        assert (done.returncode, done.stdout) == (2, "")
        assert len(done.stderr.splitlines()) == 1
        assert "Traceback" not in done.stderr


class TestTerminal:
    def test_a_pipe_gets_plain_lines_and_no_bar(self, recording: Path, tmp_path: Path) -> None:
        command = [*COMMAND, "map", str(recording), "--method", "rcd", "--out", "map"]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
        assert done.stderr == ""
        assert re.search(r"[\x00-\x09\x0b-\x1f\x7f]", done.stdout) is None

    def test_a_terminal_gets_a_bar_on_standard_error_only(self, recording: Path, tmp_path: Path) -> None:
        ours, theirs = pty.openpty()
        command = [*COMMAND, "map", str(recording), "--method", "rcd", "--out", "map"]
        surroundings = os.environ | {"TERM": "xterm"}
        with subprocess.Popen(
            command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=theirs, env=surroundings, text=True
        ) as process:
            os.close(theirs)
            shown = b""
            # Linux reports that the other end closed as an error.
            with contextlib.suppress(OSError):
                while chunk := os.read(ours, 65536):
                    shown += chunk
            os.close(ours)
            printed = process.communicate()[0]
        assert process.returncode == 0
        assert b"mapping" in shown
        assert "mapping" not in printed
        assert "\x1b" not in printed

    @pytest.mark.parametrize("words", ["info REC", "info REC --json", "map REC --method rcd --out map"])
    def test_a_closed_pipe_is_no_error_and_the_results_are_complete(
        self, words: str, recording: Path, tmp_path: Path
    ) -> None:
        command = [*COMMAND, *words.replace("REC", str(recording)).split()]
        with subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            assert process.stdout is not None
            assert process.stderr is not None
            process.stdout.close()
            assert process.stderr.read() == b""
        assert process.returncode == 0
        assert (tmp_path / "map" / "run.toml").exists() == words.startswith("map")

    def test_printing_to_a_full_disk_is_reported_in_one_line(self, recording: Path) -> None:
        with Path("/dev/full").open("w", encoding="utf-8") as full:
            command = [*COMMAND, "info", str(recording)]
            done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
        assert done.returncode == 2
        assert done.stderr.startswith("echoplan: standard output: No space left on device; free some space")
        assert len(done.stderr.splitlines()) == 1

    def test_help_does_not_wait_for_numpy(self) -> None:
        probe = (
            "import sys; import echoplan.cli.app; "
            "print(sorted({'numpy', 'scipy', 'numba', 'matplotlib', 'sklearn', 'pydantic'} & set(sys.modules)))"
        )
        done = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, check=True)
        assert done.stdout.strip() == "[]"

    def test_errors_are_printed_before_anything_heavy_is_imported(self) -> None:
        probe = (
            "import sys; import echoplan.cli.main; "
            "print(sorted({'typer', 'rich', 'numpy', 'pathlib', 'echoplan.errors'} & set(sys.modules)))"
        )
        # Without site-packages, where others may import what they like, the package must be found by name.
        environment = {**os.environ, "PYTHONPATH": str(Path(application.__file__).parents[2])}
        words = [sys.executable, "-S", "-c", probe]
        done = subprocess.run(words, capture_output=True, text=True, check=True, env=environment)
        assert done.stdout.strip() == "[]"

    @pytest.mark.parametrize("name", ["demo", "simulate", "map", "evaluate", "info", "doctor", "batch"])
    def test_every_command_shows_an_example_of_itself(self, name: str) -> None:
        assert f"Example: echoplan {name} " in succeed(name, "--help")
