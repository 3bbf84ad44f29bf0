"""Wiring diagrams, drawn from the pins in the configuration of the firmware: they cannot disagree with it."""

import ast
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from svg import element, label, page  # type: ignore[import-not-found]  # beside this file

__all__ = ["Part", "Wiring", "draw_wiring", "read_arduino", "read_micropython"]

# Colours of the wires by what they carry.
_COLORS = {
    "5V": "#d32f2f",
    "3V3": "#d32f2f",
    "GND": "#222222",
    "TRIG": "#1565c0",
    "ECHO": "#2e7d32",
    "signal": "#ef6c00",
    "OUT": "#00838f",
    "A": "#6a1b9a",
    "B": "#ad1457",
}
# Sensors of the built-in rig of four, and of any other number.
_DIRECTIONS = ("front", "left", "back", "right")

# The drawing [px]: width, rows of pins, columns, and what stands above the pins of a part.
_WIDTH, _PITCH, _HEAD, _GAP, _TOP = 700, 22, 26, 16, 52
_LEFT, _LEFT_EDGE = 14, 178
_LIVE_RAIL, _GROUND_RAIL = 206, 224
_BOARD, _BOARD_EDGE = 396, 508
_SERVO_GROUND, _SERVO_LIVE = 534, 552
_RIGHT, _RIGHT_EDGE = 572, 688


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """A part: its pins by their names, with those of the board; a note; whether the configuration switches it on."""

    name: str
    pins: dict[str, str]
    note: str = ""
    is_used: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class Wiring:
    """What is connected to a board: the parts that draw from it, and the servo, which has a supply of its own."""

    board: str
    source: str
    sensors: tuple[Part, ...]
    servo: str | None
    others: tuple[Part, ...]
    has_dividers: bool


def read_arduino(config: Path) -> Wiring:
    """Read the pins of the sketch from its ``config.h``."""
    text = config.read_text(encoding="ascii")
    values = {name: value.strip() for name, value in re.findall(r"^#define (\w+) ([^/\n]+)", text, flags=re.MULTILINE)}

    def pins(name: str) -> list[str]:
        return [pin if pin.startswith("A") else f"D{pin}" for pin in re.split(r",\s*", values[name])]

    count, wheels = int(values["SENSORS"]), int(values["WHEELS"])
    thermometer = Part(
        name="TMP36",
        pins={"+Vs": "5V", "OUT": pins("THERMOMETER_PIN")[0], "GND": "GND"},
        note="THERMOMETER 1",
        is_used=values["THERMOMETER"] == "1",
    )
    encoders = (
        _encoder(side, pins(f"{side.upper()}_WHEEL_PINS")[: wheels or 2], supply="5V", is_used=wheels > 0)
        for side in ("left", "right")
    )
    return Wiring(
        board="Arduino Uno or Nano",
        source="config.h",
        sensors=_sensors(list(zip(pins("TRIGGER_PINS"), pins("ECHO_PINS"), strict=True))[:count]),
        servo=pins("SERVO_PIN")[0] if values["SERVO"] == "1" else None,
        others=(thermometer, *encoders),
        has_dividers=False,
    )


def read_micropython(program: Path) -> Wiring:
    """Read the pins of a 3.3 V board from the configuration block of ``main.py``."""
    block = program.read_text(encoding="utf-8").partition("# ---- End of the configuration")[0]
    values = {
        target.id: ast.literal_eval(node.value)
        for node in ast.parse(block).body
        if isinstance(node, ast.Assign)
        for target in node.targets
        if isinstance(target, ast.Name)
    }

    def pin(number: int) -> str:
        return f"GPIO{number}"

    others = []
    if values["THERMOMETER"] is not None:
        others.append(Part(name="TMP36", pins={"+Vs": "3V3", "OUT": pin(values["THERMOMETER"]), "GND": "GND"}))
    for side, pins in zip(("left", "right"), values["ENCODERS"] or (), strict=False):
        others.append(_encoder(side, [pin(each) for each in pins], supply="3V3", is_used=True))
    return Wiring(
        board={"esp32": "ESP32"}.get(values["NAME"], values["NAME"]),
        source="main.py",
        sensors=_sensors([(pin(trigger), pin(echo)) for trigger, echo in values["SENSORS"]]),
        servo=None if values["SERVO"] is None else pin(values["SERVO"]),
        others=tuple(others),
        has_dividers=True,
    )


def _sensors(pins: Sequence[tuple[str, str]]) -> tuple[Part, ...]:
    names = _DIRECTIONS if len(pins) == len(_DIRECTIONS) else [""] * len(pins)
    return tuple(
        Part(name=f"sensor {number}", note=name, pins={"VCC": "5V", "TRIG": trigger, "ECHO": echo, "GND": "GND"})
        for number, (name, (trigger, echo)) in enumerate(zip(names, pins, strict=True))
    )


def _encoder(side: str, pins: Sequence[str], *, supply: str, is_used: bool) -> Part:
    channels = dict(zip("AB", pins, strict=False))
    return Part(
        name=f"{side} encoder", pins={"VCC": supply, **channels, "GND": "GND"}, note="WHEELS 2", is_used=is_used
    )


def draw_wiring(wiring: Wiring) -> str:
    """Draw a board with its parts and wires."""
    items = [
        label(f"{wiring.board}: the pins of {wiring.source}", _LEFT, 24, font_size=17, font_weight="bold"),
    ]
    y = float(_TOP)
    wires, modules = list[str](), list[str]()
    for sensor in wiring.sensors:
        modules += _module(sensor, _LEFT, y, right=True)
        wires += _sensor_wires(sensor, y, has_divider=wiring.has_dividers)
        y += _height(sensor) + _GAP
    rails = _supply_of_sensors(wiring, y + 10)
    bottom = max(y + 10 + 2 * _PITCH, _TOP + 40)
    right, y = ([], float(_TOP)) if wiring.servo is None else _servo(wiring.servo)
    for part in wiring.others:
        right += [*_module(part, _RIGHT, y, right=False), *_straight_wires(part, y)]
        y += _height(part) + _GAP
    bottom = max(bottom, y - _GAP)
    # Rails lie below the wires that cross them.
    items += [*_board(wiring, bottom), *rails, *wires, *modules, *right, *_notes(wiring, bottom + 14)]
    height = bottom + 14 + 18 * len(_sentences(wiring)) + 16
    return str(page(items, width=_WIDTH, height=height, title=f"Wiring of an {wiring.board}"))


def _height(part: Part) -> int:
    return _HEAD + _PITCH * len(part.pins)


def _rows(part: Part, top: float) -> Iterator[tuple[str, str, float]]:
    """Yield the pins of a part: their names, those of the board, and their heights in the drawing."""
    for row, (name, pin) in enumerate(part.pins.items()):
        yield name, pin, top + _HEAD + _PITCH * (row + 0.5)


def _module(part: Part, x: float, y: float, *, right: bool) -> list[str]:
    """Draw a part with the names of its pins along its right or left edge."""
    width = (_LEFT_EDGE - _LEFT) if right else (_RIGHT_EDGE - _RIGHT)
    dashes = {} if part.is_used else {"stroke_dasharray": "6 4"}
    fill = "#e3f2fd" if right else "#fff8e1"
    items = [
        element("rect", x=x, y=y, width=width, height=_height(part), rx=6, fill=fill, stroke="#546e7a", **dashes),
        label(part.name, x + 8, y + 18, font_size=13, font_weight="bold"),
    ]
    if right and part.note:
        items.append(label(part.note, x + width - 10, y + 18, font_size=13, text_anchor="end", fill="#455a64"))
    if right:
        for center in (x + 36, x + 84):
            middle = y + _HEAD + 2 * _PITCH - 6
            items.append(element("circle", cx=center, cy=middle, r=21, fill="#b0bec5", stroke="#546e7a"))
            items.append(element("circle", cx=center, cy=middle, r=14, fill="#78909c"))
    for name, _, row in _rows(part, y):
        anchor = {"x": x + width - 8, "text_anchor": "end"} if right else {"x": x + 8}
        items.append(element("text", name, y=row + 4.5, font_size=13, **anchor))
    if not part.is_used:
        note = {"font_size": 12, "text_anchor": "end", "fill": "#455a64"}
        items.append(label("optional", x + width - 8, y + _HEAD + 1.5 * _PITCH + 4.5, **note))
    return items


def _wire(points: Sequence[tuple[float, float]], kind: str, *, is_used: bool = True) -> list[str]:
    """Draw a wire over a white seam, so that one sees which of two that cross lies above."""
    path = "M" + " L".join(f"{x:g} {y:g}" for x, y in points)
    dashes = {} if is_used else {"stroke_dasharray": "6 4"}
    return [
        element("path", d=path, fill="none", stroke="white", stroke_width=7),
        element("path", d=path, fill="none", stroke=_COLORS[kind], stroke_width=2.6, **dashes),
    ]


def _dot(x: float, y: float, kind: str) -> str:
    return str(element("circle", cx=float(x), cy=float(y), r=4, fill=_COLORS[kind]))


def _connection(part: Part, name: str, pin: str, drawn: Sequence[str]) -> str:
    """Group what connects two pins; its title is shown under the mouse, and the test of the diagrams reads it."""
    return str(element("g", element("title", f"{part.name} {name} to {pin}"), *drawn))


def _sensor_wires(sensor: Part, top: float, *, has_divider: bool) -> list[str]:
    """Draw the wires of a sensor: supply to the rails, signals straight to the board."""
    items = []
    for name, pin, y in _rows(sensor, top):
        if name == "VCC":
            drawn = [*_wire([(_LEFT_EDGE, y), (_LIVE_RAIL, y)], "5V"), _dot(_LIVE_RAIL, y, "5V")]
        elif name == "GND":
            drawn = [*_wire([(_LEFT_EDGE, y), (_GROUND_RAIL, y)], "GND"), _dot(_GROUND_RAIL, y, "GND")]
        else:
            drawn = [*_wire([(_LEFT_EDGE, y), (_BOARD, y)], name), *_board_pin(pin, y, is_left=True)]
            if name == "ECHO" and has_divider:
                drawn += _divider(y)
        items.append(_connection(sensor, name, pin, drawn))
    return items


def _divider(y: float) -> list[str]:
    """Draw 1 kOhm in an echo wire, and 2 kOhm from behind it to the wire of the ground below."""
    node, ground = 336.0, y + _PITCH
    box = {"fill": "#fff3e0", "stroke": "#5d4037", "stroke_width": 1.6}
    return [
        *_wire([(_GROUND_RAIL + 4, ground), (node, ground), (node, y)], "GND"),
        _dot(node, y, "ECHO"),
        element("rect", x=252.0, y=y - 7, width=58.0, height=14.0, rx=2, **box),
        label("1 kΩ", 281, y + 4.5, font_size=12, text_anchor="middle"),
        element("rect", x=node - 6, y=y + 4, width=12.0, height=14.0, rx=2, **box),
        label("2 kΩ", node + 10, y + 16, font_size=12),
    ]


def _supply_of_sensors(wiring: Wiring, y: float) -> list[str]:
    """Draw the rails that join the supply pins of all sensors to those of the board."""
    first = _TOP + _HEAD + 0.5 * _PITCH
    ground, live = y, y + _PITCH
    rails = [
        *_wire([(_GROUND_RAIL, first + 3 * _PITCH), (_GROUND_RAIL, ground), (_BOARD, ground)], "GND"),
        *_board_pin("GND", ground, is_left=True),
        *_wire([(_LIVE_RAIL, first), (_LIVE_RAIL, live), (_BOARD, live)], "5V"),
        *_board_pin("5V", live, is_left=True),
    ]
    return rails if wiring.sensors else []


def _board_pin(pin: str, y: float, *, is_left: bool) -> list[str]:
    """Draw a pin of the board with its name."""
    edge = _BOARD if is_left else _BOARD_EDGE
    place = {"x": edge + 8} if is_left else {"x": edge - 8, "text_anchor": "end"}
    name = element("text", pin, y=y + 4.5, font_size=13, font_weight="bold", fill="white", **place)
    return [element("rect", x=edge - 4, y=y - 4, width=8, height=8, fill="#ffd54f", stroke="#5d4037"), name]


def _board(wiring: Wiring, bottom: float) -> list[str]:
    """Draw the board and its USB plug."""
    middle = (_BOARD + _BOARD_EDGE) / 2
    return [
        element("rect", x=middle - 20, y=_TOP - 18, width=40, height=20, rx=2, fill="#b0bec5", stroke="#546e7a"),
        label("USB", middle, _TOP - 4, font_size=12, text_anchor="middle"),
        element("rect", x=_BOARD, y=_TOP, width=_BOARD_EDGE - _BOARD, height=bottom - _TOP, rx=6, fill="#00695c"),
        label(
            wiring.board.removeprefix("Arduino "), middle, _TOP + 18, font_size=13, text_anchor="middle", fill="white"
        ),
    ]


def _servo(pin: str) -> tuple[list[str], float]:
    """Draw the servo, its supply and the capacitor; return the height below them, too."""
    servo = Part(name="servo", pins={"signal": pin, "+": "5V", "\N{MINUS SIGN}": "GND"})
    capacitor = Part(name="capacitor", pins={"+ 1000 µF": "5V", "\N{MINUS SIGN}": "GND"})
    supply = Part(name="5 V supply", pins={"+ 2 A": "5V", "\N{MINUS SIGN}": "GND"})
    items, y, ends = list[str](), float(_TOP), {"5V": list[float](), "GND": list[float]()}
    for part in (servo, capacitor, supply):
        items += _module(part, _RIGHT, y, right=False)
        for name, target, row in _rows(part, y):
            if name == "signal":
                drawn = [*_wire([(_BOARD_EDGE, row), (_RIGHT, row)], "signal"), *_board_pin(pin, row, is_left=False)]
                items.append(_connection(part, name, target, drawn))
            else:
                ends[target].append(row)
        y += _height(part) + _GAP
    rails = _wire([(_SERVO_LIVE, ends["5V"][0]), (_SERVO_LIVE, ends["5V"][-1])], "5V")
    ground = ends["GND"][-1]
    rails += _wire([(_SERVO_GROUND, ends["GND"][0]), (_SERVO_GROUND, ground), (_BOARD_EDGE, ground)], "GND")
    rails += _board_pin("GND", ground, is_left=False)
    for kind, rail in (("5V", _SERVO_LIVE), ("GND", _SERVO_GROUND)):
        for row in ends[kind]:
            rails += [*_wire([(rail, row), (_RIGHT, row)], kind), _dot(rail, row, kind)]
    return [*rails, *items], y


def _straight_wires(part: Part, top: float) -> list[str]:
    """Draw the wires of a part beside the board."""
    items = []
    for name, pin, y in _rows(part, top):
        kind = pin if pin in _COLORS else name
        drawn = _wire([(_BOARD_EDGE, y), (_RIGHT, y)], kind, is_used=part.is_used)
        items.append(_connection(part, name, pin, [*drawn, *_board_pin(pin, y, is_left=False)]))
    return items


def _sentences(wiring: Wiring) -> list[str]:
    """Return what is written below the drawing."""
    sentences = ["Wires are joined only at dots. Pins are where their wires are short, not where your board has them."]
    if wiring.servo is not None or wiring.others:
        sentences.append(
            "A pin that is drawn twice (5V, GND) is one: join its wires on a breadboard. Do not join the two red nets."
        )
    if wiring.has_dividers:
        sentences.append("Each divider makes 3.3 V of the 5 V at an ECHO pin: without it, the board may be destroyed.")
    if any(not part.is_used for part in wiring.others):
        switches = dict.fromkeys(part.note for part in wiring.others if not part.is_used)
        sentences.append(f"Dashed parts are optional; {wiring.source} switches them on: {', '.join(switches)}.")
    return sentences


def _notes(wiring: Wiring, y: float) -> list[str]:
    return [
        label(sentence, _LEFT, y + 18 * (row + 1) - 4, font_size=12.5, fill="#37474f")
        for row, sentence in enumerate(_sentences(wiring))
    ]
