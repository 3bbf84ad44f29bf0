"""Text logs whose right reading is not certain: read right, asked about, or refused with the option to give."""

import math
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from echoplan.errors import InputError
from echoplan.io import builtin_rig
from echoplan.io.text_logs import LogOptions, Place, TextLog, read_text_log

ANGLES = range(-90, 91, 3)
ORIGIN = (Place(x=0.0, y=0.0, heading=0.0),)


def distance(angle: float, place: int = 0) -> float:
    """Centimetres in some room."""
    return round(120.3 + 1.37 * abs(angle - 15 * place) + 40 * place, 1)


def sweep(place: int = 0) -> list[str]:
    """One sweep of a sensor on a servo."""
    return [f"{angle},{distance(angle, place)}" for angle in ANGLES]


@pytest.fixture
def read(tmp_path: Path) -> Callable[..., TextLog]:
    """Write lines into files, one for each list, and read them."""

    def write_and_read(*files: Sequence[str], **options: object) -> TextLog:
        paths = [tmp_path / f"log_{number}.txt" for number in range(len(files))]
        for path, lines in zip(paths, files, strict=True):
            path.write_text("\n".join(lines) + "\n")
        return read_text_log(paths, LogOptions(**options))  # type: ignore[arg-type]

    return write_and_read


class TestCountedAngles:
    DISTANCES: Sequence[str] = [f"{distance(angle)}" for angle in ANGLES]

    @pytest.mark.parametrize("lost", ["", "#reset", "400", "1.2.3"])
    def test_a_line_that_is_no_reading_keeps_its_angle(self, lost: str, read: Callable[..., TextLog]) -> None:
        lines = [*self.DISTANCES[:10], lost, *self.DISTANCES[11:]]
        log = read(lines, places=ORIGIN, angles=(-90.0, 3.0))
        (found,) = log.recording.sweeps
        np.testing.assert_allclose(np.degrees(found.servo_angles), [angle for angle in ANGLES if angle != -60])
        assert [fact.subject for fact in log.guesses] == (["skipped lines"] if lost else [])

    def test_blank_lines_that_are_frequent_are_readings_without_echo(self, read: Callable[..., TextLog]) -> None:
        lines = ["" if number % 9 == 4 else line for number, line in enumerate(self.DISTANCES)]
        (found,) = read(lines, places=ORIGIN, angles=(-90.0, 3.0)).recording.sweeps
        assert np.flatnonzero(np.isinf(found.ranges)).tolist() == list(range(4, 61, 9))

    def test_blank_lines_between_all_lines_are_none(self, read: Callable[..., TextLog]) -> None:
        lines = [each for line in self.DISTANCES for each in (line, "")]
        (found,) = read(lines, places=ORIGIN, angles=(-90.0, 3.0)).recording.sweeps
        assert (len(found), round(math.degrees(found.servo_angles[-1]))) == (61, 90)

    def test_they_begin_anew_at_each_place_and_file(self, read: Callable[..., TextLog]) -> None:
        lines = ["0,0,0", *self.DISTANCES, "50,0,0", *self.DISTANCES]
        log = read(lines, ["90,0,0", *self.DISTANCES], angles=(-90.0, 3.0))
        assert [len(each) for each in log.recording.sweeps] == [61, 61, 61]
        assert [round(math.degrees(each.servo_angles[-1])) for each in log.recording.sweeps] == [90, 90, 90]

    def test_more_lines_than_a_turn_has_are_refused(self, read: Callable[..., TextLog]) -> None:
        with pytest.raises(InputError, match="angles from -90 to 456 are more than a turn"):
            read([*self.DISTANCES] * 3, places=ORIGIN, angles=(-90.0, 3.0))


@pytest.mark.parametrize(("first", "step"), [(1200, 10), (0, 8)], ids=["pulses of a servo", "steps of a motor"])
def test_angles_beyond_a_turn_need_their_unit_whatever_looks_ahead(
    first: int, step: int, read: Callable[..., TextLog]
) -> None:
    lines = [f"{first + step * number},{distance(angle)}" for number, angle in enumerate(ANGLES)]
    for center in (None, first + 30.0 * step):
        with pytest.raises(InputError, match=r"are more than a turn in degrees; give --angle-unit"):
            read(lines, places=ORIGIN, center=center)
    unit = f"{180 / (60 * step)}"
    (found,) = read(lines, places=ORIGIN, center=first + 30.0 * step, angle_unit=unit).recording.sweeps
    np.testing.assert_allclose(np.degrees(found.servo_angles), ANGLES, atol=1e-9)


class TestPlaces:
    def test_the_place_of_a_file_is_not_that_of_the_next(self, read: Callable[..., TextLog]) -> None:
        with pytest.raises(InputError, match=r"log_1.txt, line 1: there is a reading before any place of its file"):
            read(["60,60,0", *sweep()], sweep(1))

    def test_places_behind_their_sweeps_are_refused(self, read: Callable[..., TextLog]) -> None:
        with pytest.raises(InputError, match=r"line 125: no reading follows this place; write each place before"):
            read(["0,0,0", *sweep(), "60,60,0", *sweep(1), "150,80,0"])

    @pytest.mark.parametrize(("name", "values"), [("heading", [0, 0, 90]), ("x", [60, 120, 180])])
    def test_a_part_of_a_place_is_not_thrown_away(
        self, name: str, values: list[int], read: Callable[..., TextLog]
    ) -> None:
        rows = [f"{line},{value}" for place, value in enumerate(values) for line in sweep(place)]
        with pytest.raises(InputError, match=f"its column '{name}' changes, and has no use without"):
            read([f"angle,distance,{name}", *rows], places=ORIGIN)
        assert len(read(rows, places=ORIGIN, columns="angle,range,-").recording.sweeps) == 3


class TestUnits:
    def test_a_number_with_another_unit_or_none_is_skipped(self, read: Callable[..., TextLog]) -> None:
        lines = [f"{line}cm" for line in sweep()]
        log = read(["60,60,0", *lines[:20], "-30,1.6m", "-27,157.3", *lines[22:]])
        assert [line.text for line in log.skipped] == ["-30,1.6m", "-27,157.3"]
        assert {line.reason for line in log.skipped} == {"a number has not the unit of the others"}

    def test_a_header_and_numbers_that_contradict_each_other_are_refused(self, read: Callable[..., TextLog]) -> None:
        rows = [f"{line}cm" for line in sweep()]
        with pytest.raises(InputError, match="the column 'range' are in 'cm', not in 'mm' as is said"):
            read(["angle,distance_mm", *rows], places=ORIGIN)

    def test_times_that_cannot_be_seconds_need_their_unit(self, read: Callable[..., TextLog]) -> None:
        rows = [f"{1000 + 60 * number},{line}" for number, line in enumerate(sweep())]
        with pytest.raises(InputError, match=r"have no unit, and go up by 60 from line to line; name the column t:ms"):
            read(["time,angle,distance", *rows], places=ORIGIN)
        (found,) = read(["time,angle,distance", *rows], places=ORIGIN, columns="t:ms,angle,range").recording.sweeps
        assert set(np.diff(found.stamps_ns)) == {60_000_000}


class TestOptionsWithoutEffect:
    def test_wheels_that_are_not_in_the_log(self, read: Callable[..., TextLog]) -> None:
        for options in ({"tick": 0.005}, {"wheel_base": 0.15}):
            with pytest.raises(InputError, match="--tick and --wheel-base have no effect"):
                read(sweep(), places=ORIGIN, **options)

    def test_directions_beside_those_of_a_rig(self, read: Callable[..., TextLog]) -> None:
        rig = builtin_rig("hc-sr04-servo")
        with pytest.raises(InputError, match=r"says where its sensors point, and so does @ in --columns"):
            read(sweep(), places=ORIGIN, columns="angle,range@90", rig=rig)


class TestHeaders:
    def test_german_names_and_units_are_known(self, read: Callable[..., TextLog]) -> None:
        for header in ("Winkel [Grad];Abstand [cm]", "Servowinkel;Entfernung (cm)"):
            lines = [header, *(line.replace(",", ";").replace(".", ",") for line in sweep())]
            (found,) = read(lines, places=ORIGIN).recording.sweeps
            np.testing.assert_allclose(np.degrees(found.servo_angles), ANGLES)
            assert found.ranges[0] == pytest.approx(distance(-90) / 100)

    @pytest.mark.parametrize("header", ["pos,distance", "Servo test, distance", "step,range"])
    def test_unknown_names_above_numbers_like_angles_are_asked_about(
        self, header: str, read: Callable[..., TextLog]
    ) -> None:
        with pytest.raises(InputError, match=r"has names that are not known; .* --columns angle,range"):
            read([header, *sweep()], places=ORIGIN)

    def test_what_a_board_says_first_is_no_header(self, read: Callable[..., TextLog]) -> None:
        (found,) = read(["Sonar ready", *(line.replace(",", " ") for line in sweep())], places=ORIGIN).recording.sweeps
        np.testing.assert_allclose(np.degrees(found.servo_angles), ANGLES)

    @pytest.mark.parametrize("name", ["sensor", "id"])
    def test_lines_of_two_sensors_are_refused(self, name: str, read: Callable[..., TextLog]) -> None:
        rows = [f"{sensor},{line}" for line in sweep() for sensor in range(2)]
        with pytest.raises(InputError, match="its lines are of 2 sensors, '0', '1', one below the other"):
            read([f"{name},angle,distance", *rows], places=ORIGIN)
        assert read([f"{name},angle,distance", *rows[::2]], places=ORIGIN).recording.sweeps

    def test_counts_of_wheels_are_known(self, read: Callable[..., TextLog]) -> None:
        rows = [f"{10 * number},{10 * number},{line}" for number, line in enumerate(sweep())]
        (found,) = read(["left,right,angle,distance", *rows], tick=0.005, wheel_base=0.15).recording.sweeps
        np.testing.assert_allclose(found.map_from_base[-1], [3.0, 0.0, 0.0], atol=1e-9)


def test_numbers_of_lines_that_look_like_angles_are_a_guess(read: Callable[..., TextLog]) -> None:
    lines = [f"{number},{line.split(',')[1]}" for number, line in enumerate(sweep())]
    (guess,) = read(lines, places=ORIGIN).guesses
    assert guess.option == "--columns angle,range"
    assert not read(lines, places=ORIGIN, columns="angle,range").guesses


def test_long_lines_are_asked_about_in_short(read: Callable[..., TextLog]) -> None:
    with pytest.raises(InputError, match=r"its lines have 61 numbers, .* --columns range\*61 if all are distances"):
        read([" ".join(line.split(",")[1] for line in sweep(place)) for place in range(3)])


@pytest.mark.parametrize("form", ['"{}","{}"', '{},"{}"'])
def test_quotation_marks_may_hold_a_decimal_comma(form: str, read: Callable[..., TextLog]) -> None:
    lines = [form.format(*(word.replace(".", ",") for word in line.split(","))) for line in sweep()]
    (found,) = read(["angle,distance", *lines], places=ORIGIN).recording.sweeps
    assert found.ranges[0] == pytest.approx(distance(-90) / 100)


@pytest.mark.parametrize(
    ("header", "stamp"),
    [
        ("time,", "10:33:{:02}.000,"),
        ("date,time,", "2024-05-01,10:33:{:02},"),
        ("", "2024-05-01T10:33:{:02}.500Z "),
        ("", "2024-05-01 10:33:{:02}+02:00,"),
    ],
)
def test_clock_times_are_times(header: str, stamp: str, read: Callable[..., TextLog]) -> None:
    lines = [f"{stamp.format(number)}{line}" for number, line in enumerate(sweep()[:60])]
    (found,) = read([f"{header}angle,distance"] * bool(header) + lines, places=ORIGIN).recording.sweeps
    assert set(np.diff(found.stamps_ns)) == {1_000_000_000}
    np.testing.assert_allclose(np.degrees(found.servo_angles), [*ANGLES][:60])


def test_commas_that_may_separate_thousands_are_refused(read: Callable[..., TextLog]) -> None:
    lines = [f'{angle},"{10 * distance(angle):,.0f}"' for angle in ANGLES]
    with pytest.raises(
        InputError, match=r"the comma in numbers such as '2,436' may separate thousands; .* --decimal-co"
    ):
        read(["angle,distance_mm", *lines], places=ORIGIN)
