"""The head: four HC-SR04 on a plate that a servo turns, drawn to scale from the rig, for paper (SVG) and CAD (DXF)."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

from ezdxf.document import Drawing
from ezdxf.enums import TextEntityAlignment
from ezdxf.layouts.layout import Modelspace
from svg import element, label, page  # type: ignore[import-not-found]  # beside this file

from echoplan.io.dxf import dxf_bytes
from echoplan.model import Rig

__all__ = ["Circle", "Dimension", "Line", "Note", "draw_head", "head_as_dxf", "head_as_svg"]

# HC-SR04 [mm]: distance and diameter of the two transducers, how far they stand out from their circuit board, and the
# size of that board.
SPACING, DIAMETER, DEPTH, CIRCUIT = 26.0, 16.0, 12.0, (45.0, 20.0)
# Material of plate and panels, and the panels [mm]: width, height, and height of the transducers above the lower edge.
THICKNESS, PANEL, AXIS_HEIGHT = 3.0, (60.0, 32.0), 18.0
# Hole for the screw of the servo horn, slots for the screws of its arms: from, to, width [mm].
HORN, SLOT = 7.0, (8.0, 17.0, 2.0)
# Paper [mm]: A4, where the axis of the servo is, the lower left corners of the panels, and the scale.
PAPER, AXIS, PANELS = (210.0, 297.0), (98.0, 206.0), ((30.0, 92.0), (118.0, 92.0), (30.0, 46.0), (118.0, 46.0))
SCALE, SCALE_AT = 100.0, (55.0, 22.0)
_DIRECTIONS = ("front", "left", "back", "right")
# Code of the unit millimetre (DXF reference, header variable $INSUNITS).
_MILLIMETRES = 4

# Layers: AutoCAD colour, colour and width [mm] on paper, dashes.
LAYERS = {
    "CUT": (7, "#000000", 0.35, ""),
    "SENSORS": (5, "#1565c0", 0.2, ""),
    "FACES": (1, "#d32f2f", 0.5, ""),
    "AXES": (8, "#78909c", 0.15, "4 1 0.6 1"),
    "DIMENSIONS": (8, "#37474f", 0.15, ""),
    "NOTES": (8, "#263238", 0.15, ""),
    "SCALE": (7, "#000000", 0.3, ""),
}

Point = tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """Straight pieces from point to point [mm]."""

    layer: str
    points: tuple[Point, ...]
    is_closed: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Circle:
    """A circle [mm]."""

    layer: str
    center: Point
    radius: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Note:
    """A text, and the height of its letters [mm]."""

    text: str
    position: Point
    height: float = 2.6
    is_centered: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Dimension:
    """The distance of two points, drawn so far to the left of the way from the first to the second [mm]."""

    start: Point
    end: Point
    away: float
    prefix: str = ""

    @property
    def length(self) -> float:
        """What is written [mm]."""
        return math.dist(self.start, self.end)


Item = Line | Circle | Note | Dimension


def draw_head(rig: Rig) -> list[Item]:
    """Return the drawing of the head of a rig, in mm on A4, y upwards."""
    return [
        Note(text=f"Head with {len(rig.sensors)} HC-SR04, seen from above", position=(20.0, 281.0), height=4.5),
        Note(
            text="All lengths in mm. The head turns about the centre; positive angles are counter-clockwise.",
            position=(20.0, 274.5),
        ),
        *_plate(rig),
        *_panels(len(rig.sensors)),
        *_scale(),
    ]


def _plate(rig: Rig) -> Iterator[Item]:
    """Draw the plate with its sensors and panels around the axis of the servo."""
    outline = list[Point]()
    for number, sensor in enumerate(rig.sensors):
        face = 1000 * math.hypot(sensor.x, sensor.y)
        inner = face - DEPTH

        def place(ahead: float, left: float, yaw: float = sensor.yaw) -> Point:
            """Return a point that lies so far ahead and to the left of a sensor's direction; ahead of 0 is up."""
            turn = yaw + math.pi / 2
            x = AXIS[0] + ahead * math.cos(turn) - left * math.sin(turn)
            return x, AXIS[1] + ahead * math.sin(turn) + left * math.cos(turn)

        def box(near: float, far: float, right: float, left: float) -> tuple[Point, ...]:
            return place(near, right), place(far, right), place(far, left), place(near, left)

        half = PANEL[0] / 2
        outline += [place(inner, -half), place(inner, half)]
        yield Line(layer="SENSORS", points=box(inner, inner + THICKNESS, -half, half), is_closed=True)
        yield Line(layer="SENSORS", points=box(inner - 1.6, inner, -CIRCUIT[0] / 2, CIRCUIT[0] / 2), is_closed=True)
        for left in (-SPACING / 2, SPACING / 2):
            can = box(inner, face, left - DIAMETER / 2, left + DIAMETER / 2)
            yield Line(layer="SENSORS", points=can, is_closed=True)
            yield Line(layer="FACES", points=can[1:3])
        start, end = SLOT[0], SLOT[1]
        yield Line(layer="CUT", points=box(start, end, -SLOT[2] / 2, SLOT[2] / 2), is_closed=True)
        yield Note(text=f"{number}: {_DIRECTIONS[number]}", position=place(28.0, 13.0), height=3.0, is_centered=True)
        yield Line(layer="AXES", points=(AXIS, place(face + 4.0, 0.0)))
    yield Line(layer="CUT", points=tuple(outline), is_closed=True)
    yield Circle(layer="CUT", center=AXIS, radius=HORN / 2)
    yield from _plate_dimensions(1000 * math.hypot(rig.sensors[0].x, rig.sensors[0].y))


def _plate_dimensions(face: float) -> Iterator[Item]:
    x, y = AXIS
    inner, half = face - DEPTH, SPACING / 2
    yield Dimension(start=(x + half, y), end=(x + half, y + face), away=-(face + 12.0 - half))
    yield Dimension(start=(x - half, y + face), end=(x + half, y + face), away=9.0)
    yield Dimension(
        start=(x - inner, y - PANEL[0] / 2), end=(x + inner, y - PANEL[0] / 2), away=-(face + 9.0 - PANEL[0] / 2)
    )
    yield Dimension(start=(x + inner, y - PANEL[0] / 2), end=(x + inner, y + PANEL[0] / 2), away=-(face + 24.0 - inner))
    for row, text in enumerate(
        (f"hole Ø {HORN:g}, slots {SLOT[2]:g} wide:", "for the horn of the servo,", "its axis is the centre")
    ):
        yield Note(text=text, position=(x - 78.0, y - face + 4.0 - 4.5 * row))
    for row, text in enumerate(("red: faces of the transducers,", f"{face:g} from the axis")):
        yield Note(text=text, position=(x + 42.0, y - face + 4.0 - 4.5 * row))


def _panels(count: int) -> Iterator[Item]:
    """Draw the panels into which the sensors are put."""
    width, height = PANEL
    x, y = PANELS[0]
    yield Note(
        text=f"{count} panels, {THICKNESS:g} thick: glue them around the plate, flush below (dash-dotted: its top)",
        position=(20.0, y + height + 12.5),
    )
    for left, bottom in PANELS[:count]:
        corners = ((0.0, 0.0), (width, 0.0), (width, height), (0.0, height))
        yield Line(layer="CUT", points=tuple((left + dx, bottom + dy) for dx, dy in corners), is_closed=True)
        middle = (left + width / 2, bottom + AXIS_HEIGHT)
        for side in (-SPACING / 2, SPACING / 2):
            yield Circle(layer="CUT", center=(middle[0] + side, middle[1]), radius=DIAMETER / 2)
        dx, dy = CIRCUIT[0] / 2, CIRCUIT[1] / 2
        circuit = tuple((middle[0] + sx * dx, middle[1] + sy * dy) for sx, sy in ((-1, -1), (1, -1), (1, 1), (-1, 1)))
        yield Line(layer="SENSORS", points=circuit, is_closed=True)
        yield Line(layer="AXES", points=((left, bottom + THICKNESS), (left + width, bottom + THICKNESS)))
    middle = (x + width / 2, y + AXIS_HEIGHT)
    yield Dimension(
        start=(middle[0] - SPACING / 2, middle[1]),
        end=(middle[0] + SPACING / 2, middle[1]),
        away=height - AXIS_HEIGHT + 5.0,
    )
    yield Dimension(start=(x, y), end=(x + width, y), away=-6.0)
    yield Dimension(start=(x, y), end=(x, y + AXIS_HEIGHT), away=5.0)
    x += PANELS[1][0] - PANELS[0][0]
    yield Dimension(start=(x + width, y), end=(x + width, y + height), away=-6.0)
    yield Dimension(
        start=(x + width / 2 - SPACING / 2 - DIAMETER / 2, y + AXIS_HEIGHT),
        end=(x + width / 2 - SPACING / 2 + DIAMETER / 2, y + AXIS_HEIGHT),
        away=height - AXIS_HEIGHT + 5.0,
        prefix="Ø ",
    )


def _scale() -> Iterator[Item]:
    """Draw a line by which a print is checked."""
    x, y = SCALE_AT
    yield Line(layer="SCALE", points=((x, y), (x + SCALE, y)))
    for tick in range(0, int(SCALE) + 1, 10):
        yield Line(layer="SCALE", points=((x + tick, y), (x + tick, y + (5.0 if tick % 50 == 0 else 3.0))))
    text = f"Print at 100 %, not fitted to the page. This line must be {SCALE:g} mm long."
    yield Note(text=text, position=(x + SCALE / 2, y - 5.0), is_centered=True)


def head_as_svg(rig: Rig) -> str:
    """Return the drawing for paper: a unit is a millimetre, and the page an A4."""
    items = [svg for each in draw_head(rig) for svg in _as_svg(each)]
    drawn: str = page(items, width=PAPER[0], height=PAPER[1], title=f"Head of the rig {rig.name}", unit="mm")
    return drawn


def _as_svg(item: Item) -> Iterator[str]:
    if isinstance(item, Line):
        path = (
            "M"
            + " L".join(f"{round(x, 2):g} {round(PAPER[1] - y, 2):g}" for x, y in item.points)
            + ("Z" if item.is_closed else "")
        )
        yield element("path", d=path, **_pen(item.layer))
    elif isinstance(item, Circle):
        x, y = item.center
        yield element("circle", cx=x, cy=PAPER[1] - y, r=item.radius, **_pen(item.layer))
    elif isinstance(item, Note):
        anchor = {"text_anchor": "middle"} if item.is_centered else {}
        x, y = item.position
        # Letters are about 0.73 of the font size high.
        yield label(item.text, x, PAPER[1] - y, font_size=item.height / 0.73, fill=LAYERS["NOTES"][1], **anchor)
    else:
        yield from _dimension_as_svg(item)


def _pen(layer: str) -> dict[str, object]:
    _, color, width, dashes = LAYERS[layer]
    dashed = {"stroke_dasharray": dashes} if dashes else {}
    return {"class_": layer.lower(), "fill": "none", "stroke": color, "stroke_width": width, **dashed}


def _dimension_as_svg(item: Dimension) -> Iterator[str]:
    """Draw extension lines, the line with its two ticks, and the length in the middle."""
    (x1, y1), (x2, y2) = item.start, item.end
    along = ((x2 - x1) / item.length, (y2 - y1) / item.length)
    left = (-along[1], along[0])
    ends = [(x + item.away * left[0], y + item.away * left[1]) for x, y in (item.start, item.end)]
    beyond = math.copysign(1.5, item.away)
    for (x, y), (far_x, far_y) in zip((item.start, item.end), ends, strict=True):
        yield from _as_svg(
            Line(layer="DIMENSIONS", points=((x, y), (far_x + beyond * left[0], far_y + beyond * left[1])))
        )
        slant = ((along[0] + left[0]) * 0.9, (along[1] + left[1]) * 0.9)
        tick = ((far_x - slant[0], far_y - slant[1]), (far_x + slant[0], far_y + slant[1]))
        yield from _as_svg(Line(layer="DIMENSIONS", points=tick))
    yield from _as_svg(Line(layer="DIMENSIONS", points=tuple(ends)))
    x, y = (ends[0][0] + ends[1][0]) / 2, PAPER[1] - (ends[0][1] + ends[1][1]) / 2
    is_upright = abs(along[1]) > abs(along[0])
    place = {"transform": f"rotate(-90 {x:g} {y:g})"} if is_upright else {}
    yield label(
        f"{item.prefix}{item.length:g}", x, y - 1.0, font_size=3.4, text_anchor="middle", class_="dimension", **place
    )


def head_as_dxf(rig: Rig) -> str:
    """Return the drawing for CAD programs and laser cutters (DXF R2010): a unit is a millimetre."""

    def draw(document: Drawing) -> None:
        document.linetypes.add("AXIS", [6.6, 4.0, -1.0, 0.6, -1.0], description="axis __ . __")
        for name, (color, _, _, dashes) in LAYERS.items():
            document.layers.add(name, color=color, linetype="AXIS" if dashes else "CONTINUOUS")
        style = document.dimstyles.new("HEAD")
        values = {
            "dimtad": 1,
            "dimlunit": 2,
            "dimdec": 1,
            "dimzin": 8,
            "dimdsep": ord("."),
            "dimtxt": 2.5,
            "dimtsz": 1.2,
        }
        for name, value in {**values, "dimasz": 2.0, "dimgap": 0.8, "dimexo": 0.5, "dimexe": 1.5}.items():
            style.dxf.set(name, value)
        space = document.modelspace()
        for item in draw_head(rig):
            _add(space, item)
        space.reset_extents((0.0, 0.0, 0.0), (*PAPER, 0.0))
        document.set_modelspace_vport(PAPER[1], center=(PAPER[0] / 2, PAPER[1] / 2))

    return dxf_bytes(draw, units=_MILLIMETRES).decode()


def _add(space: Modelspace, item: Item) -> None:
    if isinstance(item, Line):
        space.add_lwpolyline(item.points, close=item.is_closed, dxfattribs={"layer": item.layer})
    elif isinstance(item, Circle):
        space.add_circle(item.center, item.radius, dxfattribs={"layer": item.layer})
    elif isinstance(item, Note):
        text = space.add_text(item.text, height=item.height, dxfattribs={"layer": "NOTES"})
        place = TextEntityAlignment.CENTER if item.is_centered else TextEntityAlignment.LEFT
        text.set_placement(item.position, align=place)
    else:
        attributes = {"layer": "DIMENSIONS"}
        text_of_length = f"{item.prefix}<>"
        space.add_aligned_dim(
            item.start, item.end, item.away, text=text_of_length, dimstyle="HEAD", dxfattribs=attributes
        ).render()
