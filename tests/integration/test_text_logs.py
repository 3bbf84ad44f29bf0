"""Text logs of a simulated room with one mistake each, and public ones: read right, asked about, or refused."""

import math
from pathlib import Path

import numpy as np
import pytest

from echoplan.errors import InputError
from echoplan.io import read_rig
from echoplan.io.text_logs import LogOptions, Place, TextLog, read_text_log
from echoplan.model import Heading

SHARED = Path(__file__).parents[2] / ".." / "shared"
LOGS, FORMATS, HEADS = (SHARED / "cases" / name for name in ("builder-logs", "14-serial-formats", "builder-heads"))
REAL = SHARED / "data" / "real"


def log_of(path: Path, **options: object) -> TextLog:
    """Read a log, or skip the test where the data are missing."""
    if not path.is_file():
        pytest.skip(f"the log {path.name} is not here")
    return read_text_log([path], LogOptions(**options))  # type: ignore[arg-type]


def question_about(path: Path) -> str:
    """Return the refusal of a log, or the options that would state what was guessed."""
    try:
        return " ".join(guess.option for guess in log_of(path).guesses)
    except InputError as error:
        return str(error)


def pings(log: TextLog) -> np.ndarray:
    """Angle, range and pose of every ping, shape (n, 5)."""
    rows = [np.column_stack([each.servo_angles, each.ranges, each.map_from_base]) for each in log.recording.sweeps]
    return np.concatenate(rows)


# Read without a question, pings equal to those of good.txt; the number of lines skipped.
EQUAL = {
    **dict.fromkeys(
        [
            *(
                "bom",
                "cr",
                "crlf",
                "decimalcomma",
                "good",
                "header",
                "labels",
                "neg1",
                "none400",
                "none999",
                "noneblank",
            ),
            *("semicolon", "space", "stamps", "tab", "unit_cm", "utf16"),
        ],
        0,
    ),
    "garbage": 12,
}
# Read only after a question; the option that answers it makes the pings equal to those of good.txt.
ASKED: dict[str, tuple[str, dict[str, object], float]] = {
    "deg0_180": ("--center 90", {"center": 90.0}, 1e-9),
    "deg0_180_mirror": ("--center 90", {"center": 90.0, "clockwise": True}, 1e-9),
    "inch": ("--range-unit cm", {"range_unit": "in"}, 0.002),
    "metres": ("--range-unit m", {"range_unit": "m"}, 0.001),
    "mm": ("--range-unit mm", {"range_unit": "mm"}, 1e-9),
    "us": ("--range-unit us", {"range_unit": "us"}, 0.002),
    "place_m": ("--position-unit m", {"position_unit": "m"}, 1e-9),
    "place_mm": ("--position-unit mm", {"position_unit": "mm"}, 1e-9),
    "noplaces": (
        "--place",
        {
            "places": tuple(
                Place(x=x, y=y, heading=heading)
                for x, y, heading in [
                    *((60, 60, 30), (140, 80, 20), (240, 60, 0), (360, 140, 180)),
                    *((220, 140, 120), (140, 220, 90), (70, 270, -30), (190, 280, 195)),
                ]
            )
        },
        1e-9,
    ),
}
# Which way a servo turns, where it looks, and how places are counted, no text can show: the numbers are read as they
# stand, and ``info`` and ``map`` find these mistakes by the echoes. The option here makes them right.
READ_AS_WRITTEN: dict[str, dict[str, object]] = {
    "mirror_servo": {"clockwise": True},
    "backward": {"center": 180.0},
    "place_cw": {"heading": Heading.CLOCKWISE},
    "place_compass": {"heading": Heading.COMPASS},
}


@pytest.fixture
def good() -> np.ndarray:
    """Pings of the log without a mistake."""
    return pings(log_of(LOGS / "good.txt"))


@pytest.mark.parametrize("name", EQUAL)
def test_logs_that_differ_in_form_only_are_equal(name: str, good: np.ndarray) -> None:
    log = log_of(LOGS / f"{name}.txt")
    np.testing.assert_allclose(pings(log), good, atol=1e-9)
    assert len(log.skipped) == EQUAL[name]
    assert not log.guesses


@pytest.mark.parametrize("name", ASKED)
def test_logs_that_do_not_say_enough_are_asked_about(name: str, good: np.ndarray) -> None:
    option, answer, tolerance = ASKED[name]
    assert option in question_about(LOGS / f"{name}.txt")
    log = log_of(LOGS / f"{name}.txt", **answer)
    assert not log.guesses
    np.testing.assert_allclose(pings(log), good, atol=tolerance)


@pytest.mark.parametrize("name", READ_AS_WRITTEN)
def test_conventions_that_no_text_can_show_are_read_as_written_and_can_be_given(name: str, good: np.ndarray) -> None:
    def places_of(log: TextLog) -> np.ndarray:
        rows = pings(log)
        return np.column_stack([rows[:, 1:4], np.exp(1j * rows[:, 0]), np.exp(1j * rows[:, 4])])

    right = places_of(log_of(LOGS / "good.txt"))
    assert not np.allclose(places_of(log_of(LOGS / f"{name}.txt")), right)
    np.testing.assert_allclose(places_of(log_of(LOGS / f"{name}.txt", **READ_AS_WRITTEN[name])), right, atol=1e-9)


def test_centimetres_without_decimals_are_read_to_half_a_centimetre(good: np.ndarray) -> None:
    log = log_of(LOGS / "intcm.txt")
    np.testing.assert_allclose(pings(log), good, atol=0.0051)
    assert not log.guesses


def test_sweeps_to_and_fro_hold_the_same_number_of_pings(good: np.ndarray) -> None:
    log = log_of(LOGS / "alt.txt")
    ordered = np.concatenate([rows[np.argsort(rows[:, 0])] for rows in np.split(pings(log), 8)])
    np.testing.assert_allclose(ordered[:, [0, 2, 3, 4]], good[:, [0, 2, 3, 4]], atol=1e-9)


def test_one_place_is_the_first_sweep(good: np.ndarray) -> None:
    np.testing.assert_allclose(pings(log_of(LOGS / "oneplace.txt")), good[:91], atol=1e-9)


@pytest.mark.parametrize(("name", "lost", "skipped"), [("glued", 49, 1), ("reset_mid", 296, 2)])
def test_a_damaged_line_costs_its_reading_only(name: str, lost: int, skipped: int, good: np.ndarray) -> None:
    log = log_of(LOGS / f"{name}.txt")
    np.testing.assert_allclose(pings(log), np.delete(good, lost, axis=0), atol=1e-9)
    assert len(log.skipped) == skipped


@pytest.mark.parametrize("name", ["reset_restart", "reset_retype"])
def test_a_reset_adds_a_sweep_at_the_same_place(name: str, good: np.ndarray) -> None:
    log = log_of(LOGS / f"{name}.txt")
    assert [len(sweep) for sweep in log.recording.sweeps] == [39, *[91] * 8]
    np.testing.assert_allclose(pings(log)[:39], good[:39], atol=1e-9)
    np.testing.assert_allclose(pings(log)[39:], good, atol=1e-9)


@pytest.mark.parametrize("name", ["place_swap", "place_ydown"])
def test_mirrored_places_are_read_as_written(name: str, good: np.ndarray) -> None:
    np.testing.assert_allclose(pings(log_of(LOGS / f"{name}.txt"))[:, :2], good[:, :2], atol=1e-9)


def test_decimal_commas_between_commas_are_refused() -> None:
    with pytest.raises(InputError, match="a comma between numbers and in numbers"):
        log_of(LOGS / "decimalcomma2.txt")


def test_every_log_has_its_expectation() -> None:
    if not LOGS.is_dir():
        pytest.skip("the logs are not here")
    here = {path.stem for path in LOGS.glob("*.txt")}
    by_hand = {"alt", "decimalcomma2", "glued", "intcm", "oneplace", "place_swap", "place_ydown"}
    by_hand |= {"reset_mid", "reset_restart", "reset_retype"}
    assert here == {*EQUAL, *ASKED, *READ_AS_WRITTEN, *by_hand}


@pytest.mark.parametrize(
    "name", ["all", "byhand", "byhand_worse", "flyback", "horn7", "lag8", "scale94", "slowflyback"]
)
def test_heads_with_one_sensor_are_read(name: str) -> None:
    log = log_of(HEADS / f"{name}.txt")
    assert [len(sweep) for sweep in log.recording.sweeps] == [91] * 8
    assert (log.guesses, log.skipped) == ((), ())


@pytest.mark.parametrize("name", ["four", "four_cw"])
def test_heads_with_four_sensors_are_read(name: str) -> None:
    log = log_of(HEADS / f"{name}.txt")
    assert [len(sweep) for sweep in log.recording.sweeps] == [180] * 8
    assert log.recording.sweeps[0].ranges[0] == 3.594
    assert (log.guesses, log.skipped) == ((), ())


SKETCHES: dict[str, tuple[str, dict[str, object]]] = {
    "labelled": ("", {}),
    "lines180": ("--center 90", {"center": 90.0, "range_unit": "cm"}),
    "pantilt": (
        "--columns range,angle,-",
        {"columns": "range,angle,-", "center": 90.0, "range_unit": "cm", "places": (Place(x=0, y=0, heading=0),)},
    ),
    "radar": ("--center 90", {"center": 90.0, "range_unit": "cm"}),
    "semi": ("--range-unit cm", {"range_unit": "cm"}),
    "tab": ("--range-unit cm", {"range_unit": "cm"}),
}


@pytest.mark.parametrize("name", SKETCHES)
def test_what_sketches_print_is_read_or_asked_about(name: str) -> None:
    option, answer = SKETCHES[name]
    assert option in question_about(FORMATS / f"{name}.txt")
    (sweep,) = log_of(FORMATS / f"{name}.txt", **answer).recording.sweeps
    np.testing.assert_allclose(np.degrees(sweep.servo_angles), np.arange(-90, 91), atol=1e-9)
    assert sweep.ranges[0] == pytest.approx(1.12, abs=0.003)


def test_a_drive_with_encoders_is_asked_about_and_read() -> None:
    path = REAL / "bigface-Garden_27_03_20.txt"
    with pytest.raises(InputError, match=r"its lines have 9 numbers, and nothing says what they are; .* --columns"):
        log_of(path)
    options = {"columns": "dleft,dright,heading,range@0,range@180,-*4", "tick": 0.005}
    assert [guess.option for guess in log_of(path, **options).guesses] == ["--heading clockwise"]
    log = log_of(path, **options, heading=Heading.CLOCKWISE)
    rows = np.genfromtxt(path, delimiter=",")
    assert (log.guesses, log.skipped) == ((), ())
    np.testing.assert_allclose(np.array([sweep.ranges for sweep in log.recording.sweeps]), rows[:, 3:5] / 100)
    poses = np.array([sweep.map_from_base[0] for sweep in log.recording.sweeps])
    assert np.abs(np.angle(np.exp(1j * (poses[:, 2] + np.radians(rows[:, 2]))))).max() < 1e-9
    way = np.linalg.norm(np.diff(poses[:, :2], axis=0), axis=1)
    np.testing.assert_allclose(way, 0.005 * np.abs(rows[1:, :2].mean(axis=1)), atol=1e-9)


def test_a_wide_ring_is_asked_about_and_read() -> None:
    path, rig = REAL / "uci24.csv", REAL / "uci-150s" / "rig.toml"
    with pytest.raises(InputError, match=r"a line has 24 distances, .* sensors point; give --rig"):
        log_of(path)
    options = {"rig": read_rig(rig), "places": (Place(x=0.0, y=0.0, heading=0.0),)}
    assert [guess.option for guess in log_of(path, **options).guesses] == ["--range-unit m"]
    log = log_of(path, **options, range_unit="m", no_echo=(5.0,))
    assert len(log.recording.sweeps) == 5456
    assert log.recording.sweeps[0].ranges[:5].tolist() == [0.438, 0.498, 3.625, 3.645, math.inf]
