"""From the log of an Arduino's serial port to a recording: python examples/from_serial_log.py LOG RECORDING.

In the log, a line of three numbers says where the robot was put down: x and y in centimetres, heading in degrees.
A line of two numbers is a reading: angle of the servo in degrees, distance in centimetres, 0 for no echo.  A line of
five has the distances of four sensors on the servo, each a quarter turn farther to the left.  Time stamps of a serial
monitor (``10:33:01.123 -> ``) and lines without a comma (``Ready``) are passed over.
"""

import csv
import math
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NoReturn

SENSOR = """
[[sensor]]
id = {number}
x = {x:.3f}               # from the axis of the servo to the face of the sensor, in metres
y = {y:.3f}
yaw = {yaw:.6f}
half_aperture = 0.52    # a wall is detected up to some 30 degrees off
min_range = 0.02
max_range = 4.0
resolution = 0.003      # the smallest step of an HC-SR04
"""
PLACE, ONE, FOUR = 3, 2, 5
# From the axis of the servo to the face of a sensor [m]; from one ping to the next [s].
ARM, PERIOD = 0.03, 0.06


def main() -> None:
    """Read the log and write the recording beside it."""
    if len(sys.argv) != 3:
        refuse("name the log and the folder for the recording: python from_serial_log.py LOG RECORDING")
    log, folder = map(Path, sys.argv[1:])
    rows = readings(log)
    folder.mkdir(parents=True, exist_ok=True)
    sensors = [sensor(number) for number in sorted({row[2] for row in rows})]
    (folder / "rig.toml").write_text('name = "HC-SR04 on a servo"\n' + "".join(sensors), encoding="utf-8")
    with (folder / "pings.csv").open("w", encoding="utf-8", newline="") as file:
        csv.writer(file).writerows([("t", "sweep", "sensor", "servo", "range", "x", "y", "yaw"), *rows])


def readings(log: Path) -> list[tuple[float, ...]]:
    """List the rows of pings.csv."""
    rows: list[tuple[float, ...]] = []
    place, sweep = (0.0, 0.0, 0.0), -1
    for where, numbers in lines_of(log):
        if len(numbers) == PLACE:
            place, sweep = (numbers[0] / 100, numbers[1] / 100, math.radians(numbers[2])), sweep + 1
        elif len(numbers) not in (ONE, FOUR):
            refuse(f"{where}: {len(numbers)} numbers; write x,y,heading or angle,distance")
        elif sweep < 0:
            refuse(f"{where}: a reading before any place; write x,y,heading in a line before it")
        else:
            servo = math.radians(numbers[0])
            for which, distance in enumerate(numbers[1:]):
                rows.append((PERIOD * len(rows), sweep, which, servo, distance / 100 or math.inf, *place))
    if not rows:
        refuse(f"{log}: there is no reading in it; write lines angle,distance in degrees and centimetres")
    return rows


def lines_of(log: Path) -> Iterator[tuple[str, list[float]]]:
    """Yield the lines of numbers, and where each stands."""
    if not log.is_file():
        refuse(f"{log}: there is no such file; save what the serial monitor shows under this name")
    for number, line in enumerate(log.read_text(encoding="utf-8", errors="replace").splitlines(), start=1):
        where, words = f"{log}, line {number}", line.rpartition("->")[2]
        if "," in words:
            yield where, [as_number(word, where) for word in words.split(",")]


def sensor(number: float) -> str:
    """Describe one sensor: the first looks ahead, the others each a quarter turn farther to the left."""
    yaw = number * math.pi / 2
    return SENSOR.format(number=int(number), x=ARM * math.cos(yaw), y=ARM * math.sin(yaw), yaw=yaw)


def as_number(word: str, place: str) -> float:
    """Read a number, or refuse the line."""
    try:
        return float(word)
    except ValueError:
        refuse(f"{place}: {word.strip()!r} is no number; fix or delete this line")


def refuse(message: str) -> NoReturn:
    """Say in one line what is wrong."""
    sys.stderr.write(f"{message}\n")
    sys.exit(2)


if __name__ == "__main__":
    main()
