"""From the log of an Arduino's serial port to a recording: python examples/from_serial_log.py LOG RECORDING.

In the log, a line of three numbers says where the robot was put down: x and y in centimetres, heading in degrees.
A line of two numbers is a reading: angle of the servo in degrees, distance in centimetres, 0 for no echo.
"""

import csv
import math
import sys
from pathlib import Path

RIG = """\
name = "HC-SR04 on a servo"

[[sensor]]
id = 0
x = 0.03                # from the axis of the servo to the face of the sensor, in metres
half_aperture = 0.52    # a wall is heard up to some 30 degrees off
min_range = 0.02
max_range = 4.0
resolution = 0.003      # what an HC-SR04 can tell apart
"""

log, folder = map(Path, sys.argv[1:])
rows: list[tuple[float, ...]] = []
place, sweep = (0.0, 0.0, 0.0), -1
for line in filter(str.strip, log.read_text(encoding="utf-8").splitlines()):
    numbers = [float(word) for word in line.split(",")]
    if len(numbers) == 3:
        place, sweep = (numbers[0] / 100, numbers[1] / 100, math.radians(numbers[2])), sweep + 1
    else:
        angle, distance = numbers
        rows.append((0.06 * len(rows), sweep, 0, math.radians(angle), distance / 100 or math.inf, *place))

folder.mkdir(exist_ok=True)
(folder / "rig.toml").write_text(RIG, encoding="utf-8")
with (folder / "pings.csv").open("w", encoding="utf-8", newline="") as file:
    csv.writer(file).writerows([("t", "sweep", "sensor", "servo", "range", "x", "y", "yaw"), *rows])
