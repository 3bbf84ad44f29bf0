"""Text logs: the same readings, however a program printed them, become the same pings; what is unclear is asked."""

import contextlib
import math
import random
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from echoplan.errors import InputError
from echoplan.io import builtin_rig
from echoplan.io.text_logs import LogOptions, Place, TextLog, parse_place, read_places, read_text_log
from echoplan.model import Heading

PLACES = [(60, 60, 30), (150, 80, 20), (240, 60, -90)]
ANGLES = range(-90, 91, 10)


def distance(place: int, angle: int) -> float:
    """Centimetres from a place in some room; 0 for no echo."""
    return 0.0 if (angle + 10 * place) % 70 == 0 else round(120.3 + 1.37 * abs(angle - 15 * place) + 40 * place, 1)


def sweep_lines(reading: str, place: str = "{x},{y},{heading}") -> list[str]:
    """The log, in the given words."""
    lines = []
    for number, (x, y, heading) in enumerate(PLACES):
        lines += [place.format(x=x, y=y, heading=heading)] if place else []
        lines += [reading.format(angle=angle, cm=distance(number, angle)) for angle in ANGLES]
    return lines


@pytest.fixture
def read(tmp_path: Path) -> Callable[..., TextLog]:
    """Write text or bytes into a file and read it."""

    def write_and_read(content: list[str] | str | bytes, **options: object) -> TextLog:
        text = "\n".join(content) + "\n" if isinstance(content, list) else content
        path = tmp_path / "log.txt"
        path.write_bytes(text.encode() if isinstance(text, str) else text)
        return read_text_log([path], LogOptions(**options))  # type: ignore[arg-type]

    return write_and_read


def pings(log: TextLog) -> np.ndarray:
    """Angle, range and pose of every ping."""
    sweeps = log.recording.sweeps
    rows = [np.column_stack([each.servo_angles, each.ranges, each.map_from_base]) for each in sweeps]
    return np.concatenate(rows)


@pytest.fixture
def expected() -> np.ndarray:
    """What every form of the log must become."""
    return np.array(
        [
            (math.radians(angle), distance(number, angle) / 100 or math.inf, x / 100, y / 100, math.radians(heading))
            for number, (x, y, heading) in enumerate(PLACES)
            for angle in ANGLES
        ]
    )


GOOD = sweep_lines("{angle},{cm}")
SAME: dict[str, list[str] | bytes] = {
    "plain": GOOD,
    "line ends of Windows": "\r\n".join(GOOD).encode(),
    "line ends of old Macs": "\r".join(GOOD).encode(),
    "line ends of a terminal": "\r\r\n".join(GOOD).encode(),
    "byte-order mark": "\n".join(GOOD).encode("utf-8-sig"),
    "UTF-16": "\n".join(GOOD).encode("utf-16"),
    "UTF-16 without a mark": "\n".join(GOOD).encode("utf-16-le"),
    "blank lines and blanks": [f"  {line} " for line in GOOD for line in (line, "")],
    "semicolons": [line.replace(",", ";") for line in GOOD],
    "tabs": [line.replace(",", "\t") for line in GOOD],
    "blanks": [line.replace(",", "  ") for line in GOOD],
    "bars": [line.replace(",", " | ") for line in GOOD],
    "decimal comma": [line.replace(",", ";").replace(".", ",") for line in GOOD],
    "trailing commas": [f"{line}," for line in GOOD],
    "header": ["angle,distance", *GOOD],
    "header with units after a greeting": ["Hello, world", "Servo (deg),Distance [cm]", *GOOD],
    "units": sweep_lines("{angle} deg,{cm} cm"),
    "units in Latin-1": "\n".join(sweep_lines("{angle}°,{cm}cm")).encode("latin-1"),
    "labels": sweep_lines("Angle: {angle}  Distance: {cm} cm"),
    "labels with commas": sweep_lines("angle={angle}, dist={cm}cm"),
    "labels in lines of their own": sweep_lines("Angle: {angle}\nDistance: {cm} cm"),
    "labelled places": sweep_lines("Angle: {angle} Distance: {cm}cm", "x: {x} y: {y} heading: {heading}"),
    "tuples of Python": sweep_lines("({angle}, {cm})", "({x}, {y}, {heading})"),
    "dictionaries of Python": sweep_lines("{{'angle': {angle}, 'distance': {cm}}}"),
    "quotation marks": [
        '"Angle","Distance (cm)"',
        *(",".join(f'"{cell}"' for cell in line.split(",")) for line in GOOD),
    ],
    "degree signs": sweep_lines("Angle: {angle}°, Distance: {cm}cm"),
    "out of range": [line.replace(",0.0", ",Out of range") for line in GOOD],
    "time stamps": [f"10:33:{number // 2:02}.{number % 2 * 5}00 -> {line}" for number, line in enumerate(GOOD)],
    "time stamps in brackets": [f"[23:59:{number:02}] {line}" for number, line in enumerate(GOOD)],
    "millimetres with a unit": [
        f"{line.split(',')[0]},{float(line.split(',')[1]) * 10:.0f} mm" if line.count(",") == 1 else line
        for line in GOOD
    ],
    "-1 for no echo": [line.replace(",0.0", ",-1") if line.count(",") == 1 else line for line in GOOD],
    "nothing for no echo": [line.replace(",0.0", ",") if line.count(",") == 1 else line for line in GOOD],
    "None for no echo": [line.replace(",0.0", ",None") if line.count(",") == 1 else line for line in GOOD],
    "400 for no echo": [line.replace(",0.0", ",400") if line.count(",") == 1 else line for line in GOOD],
}


@pytest.mark.parametrize("form", SAME)
def test_the_same_readings_in_another_form_are_the_same_pings(
    form: str, read: Callable[..., TextLog], expected: np.ndarray
) -> None:
    log = read(SAME[form])
    np.testing.assert_allclose(pings(log), expected, atol=1e-9)
    assert len(log.recording.sweeps) == len(PLACES)
    assert not log.guesses


def test_a_list_of_tuples_in_one_line_and_columns_for_places_are_read(
    read: Callable[..., TextLog], expected: np.ndarray
) -> None:
    words = ", ".join(f"({angle}, {distance(0, angle)})" for angle in ANGLES)
    log = read(f"60,60,30\n[{words}]\n")
    np.testing.assert_allclose(pings(log), expected[: len(ANGLES)], atol=1e-9)
    rows = [
        f"{angle},{distance(number, angle)},{x},{y},{heading}"
        for number, (x, y, heading) in enumerate(PLACES)
        for angle in ANGLES
    ]
    # The index of a table has no name.
    indexed = [f"{number},{row}" for number, row in enumerate(rows)]
    log = read([",angle,distance_cm,x_cm,y_cm,heading_deg", *indexed])
    np.testing.assert_allclose(pings(log), expected, atol=1e-9)
    assert len(log.recording.sweeps) == len(PLACES)


def test_the_sketch_of_a_radar_without_line_ends_is_read(read: Callable[..., TextLog]) -> None:
    stream = "".join(f"{angle},{100 + angle}." for angle in range(181))
    log = read(f"120,115,0\n{stream}\n", center=90.0)
    assert pings(log)[:, 1].tolist() == [round(1 + angle / 100, 9) for angle in range(181)]
    np.testing.assert_allclose(np.degrees(pings(log)[[0, 90, 180], 0]), [-90.0, 0.0, 90.0])


@pytest.mark.parametrize(
    ("option", "factor"), [("mm", 10.0), ("m", 0.01), ("us", 1 / 0.01716)], ids=["mm", "m", "microseconds"]
)
def test_a_unit_that_the_numbers_show_is_guessed_and_can_be_given(
    option: str, factor: float, read: Callable[..., TextLog], expected: np.ndarray
) -> None:
    lines = [
        f"{line.split(',')[0]},{float(line.split(',')[1]) * factor:.3f}" if line.count(",") == 1 else line
        for line in GOOD
    ]
    log = read(lines)
    assert [(fact.value, fact.option) for fact in log.guesses] == [(option, f"--range-unit {option}")]
    np.testing.assert_allclose(pings(log), expected, atol=1e-4)
    given = read(lines, range_unit=option)
    assert not given.guesses
    np.testing.assert_array_equal(pings(given), pings(log))


def test_readings_that_can_be_centimetres_or_inches_must_be_confirmed(read: Callable[..., TextLog]) -> None:
    lines = [f"{angle},{60 + abs(angle)}" for angle in ANGLES]
    (guess,) = read(["60,60,0", *lines]).guesses
    assert (guess.value, guess.option) == ("cm (or in?)", "--range-unit cm")
    assert pings(read(["60,60,0", *lines], range_unit="in"))[0, 1] == pytest.approx(150 * 0.0254)


@pytest.mark.parametrize(("unit", "factor"), [("m", 0.01), ("mm", 10)])
def test_places_in_another_unit_are_recognised_by_the_distances_between_them(
    unit: str, factor: float, read: Callable[..., TextLog], expected: np.ndarray
) -> None:
    lines = [
        ",".join([*(f"{float(word) * factor:g}" for word in line.split(",")[:2]), line.split(",")[2]])
        if line.count(",") == 2
        else line
        for line in GOOD
    ]
    log = read(lines)
    assert [fact.option for fact in log.guesses] == [f"--position-unit {unit}"]
    np.testing.assert_allclose(pings(log), expected, atol=1e-9)


def test_radians_are_recognised(read: Callable[..., TextLog], expected: np.ndarray) -> None:
    lines = [
        f"{math.radians(float(line.split(',')[0])):.6f},{line.split(',')[1]}" if line.count(",") == 1 else line
        for line in GOOD
    ]
    log = read(lines)
    assert [fact.option for fact in log.guesses] == ["--angle-unit rad"]
    np.testing.assert_allclose(pings(log), expected, atol=1e-6)


def test_a_round_value_within_reach_that_is_often_the_greatest_must_be_confirmed_as_no_echo(
    read: Callable[..., TextLog],
) -> None:
    lines = [line.replace(",0.0", ",390.0") if line.count(",") == 1 else line for line in GOOD]
    log = read(lines)
    assert [fact.option for fact in log.guesses] == ["--no-echo 390"]
    assert np.isinf(pings(log)[:, 1]).any()
    kept = read(lines, no_echo=(0.0,))
    assert not kept.guesses
    assert (pings(kept)[:, 1] == 3.9).any()


def test_the_angle_that_looks_ahead_and_the_direction_can_be_given(
    read: Callable[..., TextLog], expected: np.ndarray
) -> None:
    turned = [f"{90 - int(line.split(',')[0])},{line.split(',')[1]}" if line.count(",") == 1 else line for line in GOOD]
    with pytest.raises(InputError, match=r"angles from 0 to 180 do not say .* --center 90"):
        read(turned)
    log = read(turned, center=90.0, clockwise=True)
    np.testing.assert_allclose(pings(log), expected, atol=1e-9)
    steps = [
        f"{(int(line.split(',')[0]) + 90) / 1.8:g},{line.split(',')[1]}" if line.count(",") == 1 else line
        for line in GOOD
    ]
    log = read(steps, center=50.0, angle_unit="1.8")
    np.testing.assert_allclose(pings(log), expected, atol=1e-3)


def test_headings_of_a_compass_are_turned(read: Callable[..., TextLog], expected: np.ndarray) -> None:
    lines = [
        ",".join([*line.split(",")[:2], f"{90 - int(line.split(',')[2])}"]) if line.count(",") == 2 else line
        for line in GOOD
    ]
    np.testing.assert_allclose(pings(read(lines, heading=Heading.COMPASS)), expected, atol=1e-9)


DAMAGED = {
    "a reset": ["rst:0x1 (POWERON_RESET),boot:0x13 (SPI_FAST_FLASH_BOOT)", "ets Jul 29 2019 12:21:46", "Ready"],
    "part of a line": ["4", "-3", ",,", "45,12.3,", "\0\x12\u00fe@"],
    "two lines run together": ["8,010,0.0"],
    "two lines run together at the point": ["8,0.010,0.0"],
    "a lost point": ["-70,1573"],
    "a lost digit of the angle": ["7,140.3"],
}


@pytest.mark.parametrize("kind", DAMAGED)
def test_damaged_lines_are_skipped_and_counted(kind: str, read: Callable[..., TextLog], expected: np.ndarray) -> None:
    lines = [*GOOD[:4], *DAMAGED[kind], *GOOD[4:]]
    log = read(lines)
    assert [line.text.replace("?", "") for line in log.skipped] == [
        line.replace("\0", "").replace("\x12", "") for line in DAMAGED[kind]
    ]
    assert log.skipped[0].place.endswith("log.txt, line 5")
    np.testing.assert_allclose(pings(log), expected, atol=1e-9)


def test_a_sweep_that_a_reset_began_anew_is_a_sweep_of_its_own(read: Callable[..., TextLog]) -> None:
    log = read([*GOOD[:9], "Ready", *GOOD[1:]])
    assert [len(sweep) for sweep in log.recording.sweeps] == [8, 19, 19, 19]
    assert (np.diff([sweep.stamps_ns[0] for sweep in log.recording.sweeps]) > 0).all()


def test_a_servo_that_sweeps_to_and_fro_makes_a_sweep_of_each_pass(read: Callable[..., TextLog]) -> None:
    there = [f"{angle},{distance(0, angle)}" for angle in ANGLES]
    log = read(["60,60,30", *there, *reversed(there[:-1]), *there[1:]])
    assert [len(sweep) for sweep in log.recording.sweeps] == [19, 18, 18]


def test_a_robot_that_says_where_it_is_before_each_reading_moves_while_its_servo_turns(
    read: Callable[..., TextLog],
) -> None:
    there = [(angle, distance(0, angle)) for angle in ANGLES]
    lines = [
        line
        for number, (angle, cm) in enumerate([*there, *there])
        for line in (f"{60 + number},60,{number}", f"{angle},{cm}")
    ]
    log = read(lines, position_unit="cm", range_unit="cm")
    assert [len(sweep) for sweep in log.recording.sweeps] == [19, 19]
    np.testing.assert_allclose(pings(log)[:, 2], 0.6 + 0.01 * np.arange(38))


@pytest.mark.parametrize(("first", "second"), [(80, 90), (90, 90), (90, 80)])
def test_a_sweep_ends_where_the_place_in_columns_changes(first: int, second: int, read: Callable[..., TextLog]) -> None:
    there, back = range(-90, first + 1, 10), range(second, -91, -10)
    readings = [*((angle, 60) for angle in there), *((angle, 150) for angle in back)]
    rows = [f"{angle},{distance(0, angle)},{x},60,0" for angle, x in readings]
    log = read(["angle,distance_cm,x_cm,y_cm,heading", *rows])
    assert [len(sweep) for sweep in log.recording.sweeps] == [len(there), len(back)]


def test_places_in_columns_that_change_within_sweeps_end_none(read: Callable[..., TextLog]) -> None:
    angles = [*ANGLES, *reversed(ANGLES)]
    rows = [f"{angle},{distance(0, angle)},{60 + number // 4},60,0" for number, angle in enumerate(angles)]
    log = read(["angle,distance_cm,x_cm,y_cm,heading", *rows])
    assert [len(sweep) for sweep in log.recording.sweeps] == [19, 19]


def test_a_sensor_that_keeps_its_angle_makes_a_sweep_of_each_line(read: Callable[..., TextLog]) -> None:
    rows = [f"0,{distance(0, angle)},{60 + number},60,0" for number, angle in enumerate(ANGLES)]
    log = read(["angle,distance_cm,x_cm,y_cm,heading", *rows])
    assert [len(sweep) for sweep in log.recording.sweeps] == [1] * 19


def test_a_place_among_lines_of_three_columns_is_no_reading(read: Callable[..., TextLog]) -> None:
    rows = [f"{1000 + 50 * n},{10 * n - 90},{250 + n}" for n in range(19)]
    log = read(
        ["t:ms,angle,distance", "60,60,0", *rows[:9], "60,80,0", *rows[9:]],
        columns="t:ms,angle,range",
        places=(Place(x=0.0, y=0.0, heading=0.0),),
    )
    assert len(log.recording.sweeps[0]) == 19
    assert [line.text for line in log.skipped][-1] == "60,80,0"


def test_x_and_y_without_a_heading_must_be_confirmed(read: Callable[..., TextLog]) -> None:
    rows = [f"{angle},{distance(0, angle)},0.5,1.5" for angle in ANGLES]
    (guess,) = read(["angle,distance_cm,x_m,y_m", *rows]).guesses
    assert (guess.subject, guess.value) == ("heading", "always 0")


class TestLostPlaces:
    def test_a_sweep_in_whose_middle_lines_are_missing_is_refused(self, read: Callable[..., TextLog]) -> None:
        second = GOOD.index("150,80,20")
        with pytest.raises(
            InputError, match=r"line 16: a sweep begins in its middle \(the angle goes from 40 to -30\)"
        ):
            read([*GOOD[: second - 5], *GOOD[second + 7 :]])

    def test_two_readings_that_ran_together_to_a_place_are_none(self, read: Callable[..., TextLog]) -> None:
        second = GOOD.index("150,80,20")
        with pytest.raises(InputError, match="a sweep begins in its middle"):
            read([*GOOD[: second - 5], "40,17,30.5", *GOOD[second + 7 :]])

    def test_a_few_lost_readings_are_no_lost_place(self, read: Callable[..., TextLog]) -> None:
        assert [len(sweep) for sweep in read([*GOOD[:5], *GOOD[7:]]).recording.sweeps] == [17, 19, 19]

    def test_a_place_out_of_order_is_refused(self, read: Callable[..., TextLog]) -> None:
        second = GOOD.index("150,80,20")
        swapped = [*GOOD[: second - 1], GOOD[second], GOOD[second - 1], *GOOD[second + 1 :]]
        with pytest.raises(InputError, match="'150,80,20' may be a place that was not written whole"):
            read(swapped)


def test_a_distance_that_is_missing_once_was_cut_off(read: Callable[..., TextLog]) -> None:
    (skipped,) = read([*GOOD[:5], "-50,", *GOOD[6:]]).skipped
    assert skipped.reason == "its distance is missing, which is rare in this log"


def test_four_sensors_stand_crosswise(read: Callable[..., TextLog]) -> None:
    lines = [f"{angle},{100 + angle},{200 + angle},0,{300 + angle}" for angle in range(-40, 41, 10)]
    log = read(["60,60,0", *lines])
    (sweep,) = log.recording.sweeps
    assert sweep.ranges[:4].tolist() == [0.6, 1.6, math.inf, 2.6]
    assert sweep.sensor_ids[:5].tolist() == [0, 1, 2, 3, 0]
    yaws = [round(math.degrees(sensor.yaw)) for sensor in log.recording.rig.sensors]
    assert yaws == [0, 90, 180, 270]
    assert {round(math.hypot(sensor.x, sensor.y), 9) for sensor in log.recording.rig.sensors} == {0.03}


def test_times_are_those_of_the_log(read: Callable[..., TextLog]) -> None:
    rows = [f"{1000 + 50 * n},{10 * n - 90},{250 + n}" for n in range(19)]
    log = read(["millis,angle,distance", *rows], places=(Place(x=0.0, y=0.0, heading=0.0),))
    (sweep,) = log.recording.sweeps
    assert (np.diff(sweep.stamps_ns) == 50_000_000).all()
    past_midnight = [
        f"23:59:{40 + n} -> {line}" if n < 20 else f"00:00:{n - 20:02} -> {line}" for n, line in enumerate(GOOD)
    ]
    stamps = np.concatenate([sweep.stamps_ns for sweep in read(past_midnight).recording.sweeps])
    assert stamps[-1] - stamps[0] == (len(GOOD) - 2) * 1_000_000_000


class TestPlaces:
    def test_one_place_for_all(self, read: Callable[..., TextLog]) -> None:
        lines = sweep_lines("{angle},{cm}", place="")
        log = read(lines, places=(Place(x=100.0, y=50.0, heading=90.0),))
        assert len(log.recording.sweeps) == 3
        assert np.unique(pings(log)[:, 2:], axis=0).round(6).tolist() == [[1.0, 0.5, 1.570796]]

    def test_one_place_for_each_sweep(self, read: Callable[..., TextLog], expected: np.ndarray) -> None:
        lines = sweep_lines("{angle},{cm}", place="")
        places = tuple(Place(x=x, y=y, heading=heading) for x, y, heading in PLACES)
        np.testing.assert_allclose(pings(read(lines, places=places)), expected, atol=1e-9)
        with pytest.raises(InputError, match="2 places are given for 3 sweeps"):
            read(lines, places=places[:2])

    def test_one_place_for_each_file_of_plain_distances(self, tmp_path: Path, expected: np.ndarray) -> None:
        paths = [tmp_path / f"loc_{number:02}.dat" for number in range(3)]
        for number, path in enumerate(paths):
            values = [distance(number, angle) for angle in ANGLES]
            path.write_text("\n".join(f"{value or 400:g}" for value in values))
        (tmp_path / "places.txt").write_text("name x y heading\na 60 60 30\nb 150 80 20 # moved\n\nc 240 60 -90\n")
        places = read_places((), tmp_path / "places.txt")
        log = read_text_log(paths, LogOptions(places=places, angles=(-90.0, 10.0)))
        np.testing.assert_allclose(pings(log), expected, atol=1e-9)
        with pytest.raises(InputError, match=r'each line is one number; .* --angles "-90 2"'):
            read_text_log(paths, LogOptions(places=places))

    def test_no_place_is_refused_with_the_remedy(self, read: Callable[..., TextLog]) -> None:
        with pytest.raises(InputError, match=r"does not say where the robot stood in its 3 sweeps; give --place"):
            read(sweep_lines("{angle},{cm}", place=""))

    def test_places_in_the_log_and_on_the_command_line_contradict(self, read: Callable[..., TextLog]) -> None:
        with pytest.raises(InputError, match="the log has places of its own"):
            read(GOOD, places=(Place(x=0.0, y=0.0, heading=0.0),))

    def test_a_reading_before_any_place_is_refused(self, read: Callable[..., TextLog]) -> None:
        with pytest.raises(InputError, match="line 1: there is a reading before any place"):
            read([f"-100,{distance(0, 0)}", *GOOD])

    def test_a_place_that_was_cut_off_is_refused(self, read: Callable[..., TextLog]) -> None:
        second = GOOD.index("150,80,20")
        with pytest.raises(InputError, match=r"'150,8,' may be a place that was not written whole"):
            read([*GOOD[:second], "150,8,", *GOOD[second + 1 :]])


class TestDriving:
    COLUMNS = "dleft,dright,heading,range@0,range@180,-*2"

    @staticmethod
    def drive(sign: int = -1) -> list[str]:
        """Counts of a robot that curves to and fro, and a compass in degrees."""
        rng = np.random.default_rng(0)
        yaw, lines = 90.0, []
        for _ in range(200):
            left, right = rng.integers(5, 25, 2)
            yaw += (right - left) * 5 / 150 * 180 / math.pi
            heading = (sign * yaw + 180) % 360 - 180
            lines.append(f"{left},{right},{heading:.0f},{120 + left},{210 - right},19,469")
        return lines

    def test_encoders_and_compass_become_poses(self, read: Callable[..., TextLog]) -> None:
        log = read(self.drive(), columns=self.COLUMNS, tick=0.005, heading=Heading.CLOCKWISE)
        assert len(log.recording.sweeps) == 200
        assert [round(math.degrees(sensor.yaw)) for sensor in log.recording.rig.sensors] == [0, 180]
        by_wheels = read(self.drive(), columns=self.COLUMNS.replace("heading", "-"), tick=0.005, wheel_base=0.15)
        moved = pings(log)[:, 2:4] - pings(log)[0, 2:4]
        start = pings(log)[0, 4] - pings(by_wheels)[0, 4]
        turn = np.array([[math.cos(start), math.sin(start)], [-math.sin(start), math.cos(start)]])
        np.testing.assert_allclose(moved, pings(by_wheels)[:, 2:4] @ turn, atol=0.06)

    def test_how_headings_grow_is_seen_by_the_wheels(self, read: Callable[..., TextLog]) -> None:
        (guess,) = read(self.drive(), columns=self.COLUMNS, tick=0.005).guesses
        assert guess.option == "--heading clockwise"
        assert not read(self.drive(sign=1), columns=self.COLUMNS, tick=0.005).guesses
        with pytest.raises(InputError, match=r"by the wheels they grow clockwise; correct --heading"):
            read(self.drive(), columns=self.COLUMNS, tick=0.005, heading=Heading.COUNTER_CLOCKWISE)

    def test_running_counts_are_distinguished_from_counts_since_the_row_before(
        self, read: Callable[..., TextLog]
    ) -> None:
        counts = np.cumsum([[int(word) for word in line.split(",")[:2]] for line in self.drive()], axis=0)
        running = [
            ",".join([str(left), str(right), *line.split(",")[2:]])
            for (left, right), line in zip(counts, self.drive(), strict=True)
        ]
        options = {"tick": 0.005, "heading": Heading.CLOCKWISE}
        log = read(running, columns=self.COLUMNS.replace("dleft,dright", "left,right"), **options)
        np.testing.assert_allclose(pings(log), pings(read(self.drive(), columns=self.COLUMNS, **options)), atol=1e-9)
        with pytest.raises(InputError, match=r"go up and down from row to row.* dleft,dright"):
            read(self.drive(), columns=self.COLUMNS.replace("dleft,dright", "left,right"), **options)

    def test_what_is_missing_is_named(self, read: Callable[..., TextLog]) -> None:
        with pytest.raises(InputError, match=r"give --tick with its unit"):
            read(self.drive(), columns=self.COLUMNS)
        with pytest.raises(InputError, match=r"or give --wheel-base with its unit"):
            read(self.drive(), columns=self.COLUMNS.replace("heading", "-"), tick=0.005)


def test_a_ring_has_one_column_for_each_sensor(read: Callable[..., TextLog]) -> None:
    rig = builtin_rig("ring-16")
    header = ",".join([*(f"S{number}" for number in range(1, 17)), "OUTPUT"])
    rows = [",".join([*(f"{0.5 + 0.1 * number + 0.01 * row:.3f}" for number in range(16)), "Turn"]) for row in range(6)]
    place = (Place(x=0.0, y=0.0, heading=0.0),)
    with pytest.raises(InputError, match="a line has 16 distances, and nothing says where the sensors point"):
        read([header, *rows], places=place)
    log = read([header, *rows], places=place, rig=rig, range_unit="m")
    assert len(log.recording.sweeps) == 6
    assert log.recording.sweeps[1].ranges[:3].tolist() == [0.51, 0.61, 0.71]
    assert log.recording.rig.sensors == rig.sensors
    with pytest.raises(InputError, match="a line has 16 distances, but the rig"):
        read([header, *rows], places=place, rig=builtin_rig("hc-sr04-servo"))


REFUSED = {
    "unknown labels": (
        "\n".join(f"gap left: {a % 7 + 40} gap right: {a}" for a in range(60)),
        "none of its labels names a distance: 'gap left', 'gap right'; say what they are, such as --columns -,range",
    ),
    "nothing": ("", "it is empty"),
    "words": ("hello\nworld\n", "there is no line of numbers in it"),
    "binary": (bytes(range(32)) * 9, "it is no text"),
    "a decimal comma between commas": (
        "\n".join(line.replace(".", ",") for line in GOOD),
        "have a comma between numbers and in numbers",
    ),
    "a temperature": (
        "60,60,0\n" + "\n".join(f"{a},{250 + a},21.5,44,{300 - a}" for a in range(-30, 30)),
        "its lines have 5 numbers, and nothing says what they are",
    ),
    "three columns": ("\n".join(f"{112 + a % 7}.{a % 10} {a} 30" for a in range(60)), "--columns range,angle,-"),
    "distance first": (
        "60,60,0\n" + "\n".join(f"{150 + 37 * a * a % 97},{a}" for a in range(-30, 30)),
        "--columns range,angle",
    ),
    "no angle": (
        "60,60,0\n" + "\n".join(f"{37 * a * a % 97},{41 * a * a % 89}" for a in range(60)),
        "goes up and down in steps",
    ),
    "steps of a motor": (
        "60,60,0\n" + "\n".join(f"{a},{150 + 7 * a % 40}" for a in range(-900, 900, 20)),
        "--angle-unit",
    ),
    "no echo": ("60,60,0\n" + "\n".join(f"{a},0" for a in range(-30, 30)), "there is not one echo in it"),
    "distances that nothing explains": (
        "60,60,0\n" + "\n".join(f"{a},{2 ** (a % 17)}" for a in range(-30, 30)),
        "fit this sensor in no unit",
    ),
    "too much garbage": (
        "\n".join([*GOOD, *["what is this"] * 20]),
        "20 of 80 lines cannot be read, more than 20 % of the text",
    ),
    "numbers padded with zeros": (
        "60,60,0\n" + "\n".join(f"{a:03d},{150 + a}" for a in range(0, 91, 2)),
        "46 of 47 lines cannot be read, more than 20 % of the text; this one: a number begins with zeros",
    ),
    "numbers all padded with zeros": (
        "\n".join(f"{a:03d},{500 + a:04d}" for a in range(0, 91, 2)),
        "this one: a number begins with zeros, as where two lines ran together",
    ),
    "two units in a column": (
        "60,60,0\n" + "\n".join(f"{a},{150 + a} {'cm' if a % 2 else 'in'}" for a in range(-30, 30)),
        "different units: 'cm' and 'in'",
    ),
}


@pytest.mark.parametrize("kind", REFUSED)
def test_a_log_that_does_not_say_enough_is_refused_in_one_line(kind: str, read: Callable[..., TextLog]) -> None:
    content, message = REFUSED[kind]
    with pytest.raises(InputError) as caught:
        read(content)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ("angle,rnge", "unknown column in --columns 'rnge'; did you mean 'range'"),
        ("angle,range:furlong", "'furlong' is no unit of 'range'; write one of m, cm"),
        ("angle@9,range", "'angle@9' is no range with a direction"),
        ("angle,angle", "no column holds distances"),
        ("angle,range,-", "--columns names 3 columns"),
        ("range*x", "'range*x' is no number of columns"),
    ],
)
def test_columns_that_cannot_be_are_refused(columns: str, message: str, read: Callable[..., TextLog]) -> None:
    lines = sweep_lines("{angle},{cm}", place="")
    with pytest.raises((InputError, LookupError)) as caught:
        read(lines, columns=columns, places=(Place(x=0.0, y=0.0, heading=0.0),))
    assert message in str(caught.value)


def test_a_place_is_three_numbers() -> None:
    assert parse_place("60, 60 30", option="--place") == Place(x=60.0, y=60.0, heading=30.0)
    with pytest.raises(InputError, match="'60 60' is no place"):
        parse_place("60 60", option="--place")


def damaged(data: bytes, rng: random.Random) -> bytes:
    """Lose, change, insert or cut bytes, or lose, join, repeat or swap lines."""
    for _ in range(rng.choice([1, 1, 3])):
        at = rng.randrange(len(data))
        lines = data.split(b"\n")
        line = rng.randrange(len(lines) - 1)
        data = rng.choice(
            [
                data[:at] + data[at + rng.choice([1, 2, 40]) :],
                data[:at] + bytes([data[at] ^ 1 << rng.randrange(8)]) + data[at + 1 :],
                data[:at] + rng.randbytes(rng.choice([1, 3, 9])) + data[at:],
                b"\n".join([*lines[:line], lines[line][: rng.randrange(len(lines[line]) + 1)], *lines[line + 1 :]]),
                b"\n".join([*lines[:line], *lines[line + 1 :]]),
                b"\n".join([*lines[:line], lines[line] + lines[line + 1], *lines[line + 2 :]]),
                b"\n".join([*lines[:line], lines[line], *lines[line:]]),
                b"\n".join([*lines[:line], lines[line + 1], lines[line], *lines[line + 2 :]]),
            ]
        )
    return data


@pytest.mark.parametrize("seed", range(25))
@pytest.mark.parametrize("form", ["plain", "labels", "time stamps", "UTF-16"])
def test_random_damage_is_refused_or_costs_the_damaged_readings_only(
    form: str, seed: int, read: Callable[..., TextLog], expected: np.ndarray
) -> None:
    content = SAME[form]
    whole = content if isinstance(content, bytes) else ("\n".join(content) + "\n").encode()
    broken = damaged(whole, random.Random(seed))
    with contextlib.suppress(InputError):
        log = read(broken)
        true = {(*ping,) for ping in expected.round(6)}
        wrong = [ping for ping in pings(log).round(6) if (*ping,) not in true]
        # A digit that is lost or changed in a number cannot be seen: it costs one reading each time, or moves a place.
        text = broken.decode("utf-16" if form == "UTF-16" else "latin-1", errors="replace")
        has_all_places = all("\n".join([place, ""]) in f"{text}\n" for place in ("60,60,30", "150,80,20", "240,60,-90"))
        assert len(wrong) <= 3 or log.guesses or not has_all_places
