"""The check with a box on the left: the robot, the box and the turn of its head, seen from above."""

import math

from svg import element, label, page  # type: ignore[import-not-found]  # beside this file

from echoplan.model import Rig

__all__ = ["draw_mirror_check"]

# The drawing, and where the robot is [px]; pixels for a metre.
_WIDTH, _HEIGHT, _ROBOT, _SCALE = 640, 300, (330.0, 186.0), 800.0
_TURN = "#2e7d32"


def draw_mirror_check(rig: Rig) -> str:
    """Draw the robot of a rig, straight ahead upwards, with a box to its left."""
    x, y = _ROBOT
    items = [
        label("The check with a box, seen from above", 14, 26, font_size=17, font_weight="bold"),
        element("rect", x=x - 74, y=y - 74, width=148, height=160, rx=16, fill="#eceff1", stroke="#546e7a"),
        *_arrow((x, y - 80), (x, y - 128)),
        label("straight ahead", x + 12, y - 112, font_size=14),
        element("rect", x=x - 250, y=y - 50, width=96, height=100, fill="#ffe0b2", stroke="#ef6c00", stroke_width=2),
        label("box, 20 cm", x - 202, y - 2, font_size=14, text_anchor="middle"),
        label("to the left", x - 202, y + 16, font_size=14, text_anchor="middle"),
        *_turn(rig),
        label("The head jumps to the right,", x + 92, y - 6, font_size=14, fill=_TURN),
        label("then turns slowly to the left:", x + 92, y + 14, font_size=14, fill=_TURN),
        label("counter-clockwise.", x + 92, y + 34, font_size=14, fill=_TURN),
    ]
    for number, sensor in enumerate(rig.sensors):
        ahead, left = _SCALE * sensor.x, _SCALE * sensor.y
        turned = f"translate({x - left:g} {y - ahead:g}) rotate({-math.degrees(sensor.yaw):g})"
        items += [
            element("rect", x=-18, y=-5, width=36, height=10, rx=3, fill="#1565c0", transform=turned),
            label(str(number), x - 0.62 * left, y - 0.62 * ahead + 5, font_size=14, text_anchor="middle"),
        ]
    return str(page(items, width=_WIDTH, height=_HEIGHT, title="The check with a box on the left"))


def _turn(rig: Rig) -> list[str]:
    """Draw the way of the servo in its first sweep, with an arrow head where it ends."""
    if rig.servo is None:
        return []
    (x, y), radius = _ROBOT, 58.0
    first, last = (
        (x - radius * math.sin(angle), y - radius * math.cos(angle)) for angle in (rig.servo.start, rig.servo.stop)
    )
    path = f"M{first[0]:.4g} {first[1]:.4g} A{radius:g} {radius:g} 0 0 0 {last[0]:.4g} {last[1]:.4g}"
    tangent = (-math.cos(rig.servo.stop), math.sin(rig.servo.stop))
    tip = (last[0] + 10 * tangent[0], last[1] + 10 * tangent[1])
    return [
        element("path", d=path, fill="none", stroke=_TURN, stroke_width=4),
        _arrow_head(tip, tangent, color=_TURN),
    ]


def _arrow(start: tuple[float, float], end: tuple[float, float]) -> list[str]:
    along = ((end[0] - start[0]) / math.dist(start, end), (end[1] - start[1]) / math.dist(start, end))
    path = f"M{start[0]:g} {start[1]:g} L{end[0]:g} {end[1]:g}"
    return [element("path", d=path, stroke="#222222", stroke_width=2.5), _arrow_head(end, along, color="#222222")]


def _arrow_head(tip: tuple[float, float], along: tuple[float, float], *, color: str) -> str:
    """Draw a triangle of 12 by 12 pixels."""
    base = (tip[0] - 12 * along[0], tip[1] - 12 * along[1])
    sides = [(base[0] + side * along[1], base[1] - side * along[0]) for side in (-6, 6)]
    points = " ".join(f"{x:.1f},{y:.1f}" for x, y in (tip, *sides))
    return str(element("polygon", points=points, fill=color))
