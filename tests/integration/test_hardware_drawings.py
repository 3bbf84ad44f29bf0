"""The drawings of the build guide show what the sketch, the program for MicroPython and the rig say."""

import importlib
import math
import re
import shutil
import xml.etree.ElementTree as ET
from pathlib import Path
from types import ModuleType

import pytest

from echoplan.io import builtin_rig

ROOT = Path(__file__).parents[2]
PICTURES = ROOT / "docs" / "pictures"
CONFIG = ROOT / "firmware" / "arduino" / "echohead" / "config.h"
PROGRAM = ROOT / "firmware" / "micropython" / "main.py"
SVG = "{http://www.w3.org/2000/svg}"
# What an HC-SR04 measures [mm].
SPACING, DIAMETER = 26.0, 16.0


@pytest.fixture
def drawings(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The script that draws."""
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    return importlib.import_module("drawings")


def connections(drawing: Path) -> dict[str, str]:
    """Pins of the parts in a wiring diagram, with the pins of the board that the drawing names at their wires."""
    found = {}
    for group in ET.parse(drawing).getroot().iter(f"{SVG}g"):
        title = group.findtext(f"{SVG}title") or ""
        end, _, pin = title.partition(" to ")
        written = [each.text for each in group.iter(f"{SVG}text") if each.text and "Ω" not in each.text]
        assert written in ([pin], [])
        assert written or pin in ("5V", "GND")
        found[end] = pin
    return found


def in_config(name: str, config: Path = CONFIG) -> list[str]:
    """Values of a line of config.h; a number is a digital pin."""
    (line,) = [each for each in config.read_text().splitlines() if each.split()[:2] == ["#define", name]]
    return [
        f"D{each}" if each.isdigit() else each
        for each in line.partition("//")[0].split(name)[1].replace(",", " ").split()
    ]


def check_arduino(drawing: Path, config: Path) -> None:
    wires = connections(drawing)
    for end, name in (("TRIG", "TRIGGER_PINS"), ("ECHO", "ECHO_PINS")):
        assert [wires[f"sensor {number} {end}"] for number in range(4)] == in_config(name, config)
    assert [wires["servo signal"]] == in_config("SERVO_PIN", config)
    assert [wires["TMP36 OUT"]] == in_config("THERMOMETER_PIN", config)
    for side in ("left", "right"):
        assert [wires[f"{side} encoder {each}"] for each in "AB"] == in_config(f"{side.upper()}_WHEEL_PINS", config)


def test_the_wiring_of_an_arduino_is_that_of_the_sketch() -> None:
    check_arduino(PICTURES / "wiring-arduino.svg", CONFIG)


def test_the_wiring_of_a_board_of_3_volts_is_that_of_its_program_with_a_divider_at_each_echo_pin() -> None:
    wires = connections(PICTURES / "wiring-esp32.svg")
    block = PROGRAM.read_text().partition("End of the configuration")[0]
    (sensors,) = re.findall(r"^SENSORS = \[(.+)\]$", block, flags=re.MULTILINE)
    pairs = re.findall(r"\((\d+), (\d+)\)", sensors)
    assert len(pairs) == 4
    for number, (trigger, echo) in enumerate(pairs):
        assert wires[f"sensor {number} TRIG"] == f"GPIO{trigger}"
        assert wires[f"sensor {number} ECHO"] == f"GPIO{echo}"
    assert re.findall(r"^SERVO = (\d+)$", block, flags=re.MULTILINE) == [wires["servo signal"].removeprefix("GPIO")]
    text = (PICTURES / "wiring-esp32.svg").read_text(encoding="utf-8")
    assert (text.count("1 kΩ"), text.count("2 kΩ")) == (4, 4)
    assert "kΩ" not in (PICTURES / "wiring-arduino.svg").read_text(encoding="utf-8")


def test_a_builder_who_changes_the_pins_gets_a_diagram_of_these(
    drawings: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = tmp_path / "arduino" / "echohead" / "config.h"
    shutil.copytree(CONFIG.parent, config.parent)
    shutil.copytree(PROGRAM.parent, tmp_path / "micropython")
    text = CONFIG.read_text()
    for line, changed in (
        ("TRIGGER_PINS 2, 3, 4, 5 ", "TRIGGER_PINS 12, 13, 7,4 "),
        ("ECHO_PINS A0, A1, A2, A3 ", "ECHO_PINS A5, A4, A3, A2 "),
        ("THERMOMETER_PIN A4", "THERMOMETER_PIN A1"),
        ("WHEELS 0 ", "WHEELS 2 "),
    ):
        assert text.count(line) == 1
        text = text.replace(line, changed)
    config.write_text(text)
    program = tmp_path / "micropython" / "main.py"
    program.write_text(PROGRAM.read_text().replace("ENCODERS = None", "ENCODERS = ((25, 26), (27, 14))"))
    monkeypatch.setattr(drawings, "FIRMWARE", tmp_path)
    drawings.main(tmp_path / "out")
    check_arduino(tmp_path / "out" / "wiring-arduino.svg", config)
    assert connections(tmp_path / "out" / "wiring-esp32.svg")["right encoder B"] == "GPIO14"


def test_the_drawings_are_those_that_the_script_makes_and_small(drawings: ModuleType, tmp_path: Path) -> None:
    drawings.main(tmp_path)
    for made in tmp_path.iterdir():
        kept = PICTURES / made.name
        assert kept.stat().st_size < 200_000
        # DXF files of other versions of ezdxf differ; the test below measures in them.
        if kept.suffix == ".svg":
            assert kept.read_text(encoding="utf-8") == made.read_text(encoding="utf-8"), "run python docs/drawings.py"


def points_of(path: ET.Element) -> list[tuple[float, float]]:
    """Corners of a path of straight lines, y downwards."""
    numbers = [float(each) for each in re.findall(r"-?\d+(?:\.\d+)?", path.attrib["d"])]
    return list(zip(numbers[::2], numbers[1::2], strict=True))


def check_head(faces: list[list[tuple[float, float]]], circles: list[tuple[float, float, float]], *, up: float) -> None:
    """Check faces (two points each) and circles (centre and radius) [mm] against the built-in rig."""
    rig = builtin_rig("rotary-array")
    (axis,) = [circle[:2] for circle in circles if circle[2] < 5]
    in_robot = sorted(
        (round(up * ((y1 + y2) / 2 - axis[1]), 3), round(axis[0] - (x1 + x2) / 2, 3)) for (x1, y1), (x2, y2) in faces
    )
    expected = []
    for sensor in rig.sensors:
        for side in (-SPACING / 2, SPACING / 2):
            x = 1000 * sensor.x - side * math.sin(sensor.yaw)
            y = 1000 * sensor.y + side * math.cos(sensor.yaw)
            expected.append((round(x, 3), round(y, 3)))
    for found, each in zip(in_robot, sorted(expected), strict=True):
        assert found == pytest.approx(each, abs=0.1)
    assert [math.dist(*face) for face in faces] == pytest.approx([DIAMETER] * 8, abs=0.1)
    holes = [circle for circle in circles if circle[2] > 5]
    assert [2 * radius for *_, radius in holes] == pytest.approx([DIAMETER] * 8)
    assert [math.dist(a[:2], b[:2]) for a, b in zip(holes[::2], holes[1::2], strict=True)] == pytest.approx(
        [SPACING] * 4
    )


def test_the_head_on_paper_has_the_dimensions_of_the_rig_and_is_to_scale() -> None:
    root = ET.parse(PICTURES / "head.svg").getroot()
    assert (root.attrib["width"], root.attrib["height"], root.attrib["viewBox"]) == ("210mm", "297mm", "0 0 210 297")
    faces = [points_of(each) for each in root.iter(f"{SVG}path") if each.get("class") == "faces"]
    circles = [
        (float(each.attrib["cx"]), float(each.attrib["cy"]), float(each.attrib["r"]))
        for each in root.iter(f"{SVG}circle")
    ]
    check_head(faces, circles, up=-1.0)
    lengths = [math.dist(*points_of(each)) for each in root.iter(f"{SVG}path") if each.get("class") == "scale"]
    assert max(lengths) == 100.0
    written = [each.text for each in root.iter(f"{SVG}text") if each.get("class") == "dimension"]
    assert {"50", "26", "Ø 16"} <= set(written)


def test_the_head_for_cad_has_the_dimensions_of_the_rig() -> None:
    ezdxf = pytest.importorskip("ezdxf")
    document = ezdxf.readfile(PICTURES / "head.dxf")
    assert document.header["$INSUNITS"] == 4
    assert not document.audit().errors
    space = document.modelspace()
    faces = [[point[:2] for point in line] for line in space.query('LWPOLYLINE[layer=="FACES"]')]
    circles = [(*each.dxf.center.vec2, each.dxf.radius) for each in space.query("CIRCLE")]
    check_head(faces, circles, up=1.0)
    assert {50.0, SPACING, DIAMETER} <= {round(each.get_measurement(), 6) for each in space.query("DIMENSION")}
