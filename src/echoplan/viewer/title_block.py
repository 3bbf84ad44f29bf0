"""The foot of a floor plan: what its signs mean, its scale and axes, and the title block; in millimetres."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from echoplan.model import FeatureClass, FeatureMap
from echoplan.viewer.floor_sheet import MARGIN, FloorSheet
from echoplan.viewer.palette import COLORS, INK, MUTED
from echoplan.viewer.quality import headline, warning_of
from echoplan.viewer.sheet import round_up
from echoplan.viewer.style import FONT, printable

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.patches import Rectangle

__all__ = ["FILL", "SIGNS", "STROKES", "TitleBlock", "draw_foot", "foot_height"]

# Left, lower, right and upper edge of a box.
_Edges: TypeAlias = tuple[float, float, float, float]

# Heights of the warning, of the strip with the scale bar, and of the two rows of the title block [mm].
_WARNING, _STRIP, _ROW = 8.0, 16.0, 9.0
# The scale bar is at least so long, in this many parts; arrows of the axes, and a sample in the legend [mm].
_BAR, _PARTS, _ARROW, _SAMPLE = 30.0, 4, 7.0, 8.0
# Letters [pt] and lines [pt].
_TITLE, _TEXT, _SMALL, _THIN = 11.0, 7.5, 5.5, 0.5
# Rows of the legend: all signs in two columns, which fit on A4.
_ROWS = 5

# The look of the strokes of a floor plan: lines of 0.5 mm for what was detected, thinner ones for the rest.
FILL = "#c3c9d2"
STROKES: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "wall": {"color": INK, "linewidth": 1.4, "solid_capstyle": "projecting"},
        "inferred": {"color": INK, "linewidth": 0.8, "linestyle": (0, (4, 2.5))},
        "unobserved": {"color": INK, "linewidth": 1.6, "linestyle": (0, (0.01, 2.2)), "dash_capstyle": "round"},
        "opening": {"color": MUTED, "linewidth": 0.5},
    }
)
# What each sign of the legend means, and the samples that are words.
SIGNS: Mapping[str, str] = MappingProxyType(
    {
        "wall": "wall: the face that was detected",
        "thickness": "grey without a back: thickness unknown",
        "number": "number as in the tables",
        "opening": "opening, such as a door",
        "inferred": "inferred, not detected",
        "unobserved": "unobserved: wall or opening",
        "cylinder": "cylinder",
        "corner": "corner detected by itself",
        "brackets": "length partly inferred",
        "at least": "length up to an unobserved end",
    }
)
_SAMPLES: Mapping[str, str] = MappingProxyType(
    {"number": "0 O0 C0", "brackets": "(2.10)", "at least": "\N{GREATER-THAN OR EQUAL TO} 2.10"}
)


@dataclass(frozen=True, slots=True, kw_only=True)
class TitleBlock:
    """What a floor plan says about itself.

    Parameters
    ----------
    name : str
        What it shows.
    date : str
        When it was made, or empty.
    signs : tuple of str
        What is explained: names of ``SIGNS``.
    """

    name: str
    date: str
    signs: tuple[str, ...]


def foot_height(feature_map: FeatureMap) -> float:
    """Height of the foot [mm]: higher if it must warn of the map."""
    return 2 * _ROW + _STRIP + (_WARNING if warning_of(feature_map.quality) else 0.0)


def draw_foot(axes: Axes, sheet: FloorSheet, *, feature_map: FeatureMap, block: TitleBlock) -> None:
    """Draw the foot of a floor plan."""
    left, right = MARGIN, float(sheet.size[0]) - MARGIN
    low = MARGIN
    quality = feature_map.quality
    verdict = headline(quality) if quality else "Not assessed"
    middle = left + 0.55 * (right - left)
    _cell(axes, (left, low + _ROW, middle, low + 2 * _ROW), name="floor plan", text=block.name, size=_TITLE)
    _cell(axes, (middle, low + _ROW, right, low + 2 * _ROW), name="quality", text=verdict, size=_TEXT)
    cells = {
        "scale": f"1:{sheet.scale:.0f} on {sheet.paper}",
        "dimensions": "metres",
        "method": feature_map.method,
        "frame": feature_map.frame,
        **({"date": block.date} if block.date else {}),
        "made with": "echoplan",
    }
    edges = np.linspace(left, right, len(cells) + 1).tolist()
    for (name, text), start, end in zip(cells.items(), edges, edges[1:], strict=False):
        _cell(axes, (start, low, end, low + _ROW), name=name, text=text, size=_TEXT)
    top = low + 2 * _ROW
    if warning := warning_of(quality):
        reason = f" {quality.reasons[0]}" if quality is not None and quality.reasons else ""
        _warn(axes, (left, top, right, top + _WARNING), text=warning + reason)
        top += _WARNING
    _box(axes, (left, top, right, top + _STRIP))
    _draw_axes(axes, (left + 4.0, top + 3.0))
    _draw_bar(axes, (left + 24.0, top + 5.0), sheet=sheet)
    _draw_signs(axes, (left + 92.0, top, right, top + _STRIP), signs=block.signs)


def _cell(axes: Axes, box: _Edges, *, name: str, text: str, size: float) -> None:
    """Draw a box with a small name above its text, which ends at its edge."""
    frame = _box(axes, box)
    left, low, _, high = box
    words: dict[str, Any] = {"fontfamily": FONT, "clip_on": True, "parse_math": False}
    small = axes.text(left + 1.0, high - 0.8, name, fontsize=_SMALL, va="top", color=MUTED, **words)
    main = axes.text(left + 1.0, low + 1.6, printable(text), fontsize=size, color=INK, **words)
    for each in (small, main):
        each.set_clip_path(frame)


def _warn(axes: Axes, box: _Edges, *, text: str) -> None:
    """Draw a band with a warning: as much of it as two lines hold."""
    _box(axes, box, facecolor=COLORS[FeatureClass.CORNER])
    left, low, right, high = box
    # Bold letters of DejaVu Sans are 0.7 of their size wide in the mean.
    letters = int((right - left - 4.0) / (0.7 * _TEXT * 25.4 / 72.0))
    lines = textwrap.wrap(printable(text), width=letters, max_lines=2, placeholder=" \N{HORIZONTAL ELLIPSIS}")
    axes.text(
        left + 2.0,
        (low + high) / 2,
        "\n".join(lines),
        fontsize=_TEXT,
        fontweight="bold",
        va="center",
        color="white",
        fontfamily=FONT,
        parse_math=False,
    )


def _draw_axes(axes: Axes, corner: tuple[float, float]) -> None:
    """Draw the axes of the map as arrows from their corner."""
    style = {"arrowstyle": "-|>", "linewidth": 0.8, "color": INK, "shrinkA": 0.0, "shrinkB": 0.0}
    for name, way in (("x", np.array([_ARROW, 0.0])), ("y", np.array([0.0, _ARROW]))):
        axes.annotate("", tuple(corner + way), xytext=corner, arrowprops=style)
        x, y = corner + way * (1.0 + 1.5 / _ARROW)
        axes.text(x, y, name, fontsize=_TEXT, ha="center", va="center_baseline", color=INK, fontfamily=FONT)


def _draw_bar(axes: Axes, corner: tuple[float, float], *, sheet: FloorSheet) -> None:
    """Draw a scale bar of parts that take turns in black and white, with its lengths in metres."""
    from matplotlib.patches import Rectangle  # noqa: PLC0415 - half a second of import

    x, y = corner
    length = round_up(_BAR / sheet.millimetres, (1.0, 2.0, 5.0))
    part = length * sheet.millimetres / _PARTS
    for number in range(_PARTS):
        face = "white" if number % 2 else INK
        axes.add_patch(Rectangle((x + number * part, y), part, 1.5, facecolor=face, edgecolor=INK, linewidth=_THIN))
    for share, unit in ((0.0, ""), (0.5, ""), (1.0, " m")):
        words = f"{share * length:g}{unit}"
        place = x + share * _PARTS * part
        axes.text(place, y + 2.4, words, fontsize=_TEXT, ha="center", color=INK, fontfamily=FONT)


def _draw_signs(axes: Axes, box: _Edges, *, signs: Sequence[str]) -> None:
    """Explain the signs of the drawing, in columns from the left."""
    left, low, right, high = box
    columns = max(-(-len(signs) // _ROWS), 2)
    for number, sign in enumerate(signs):
        column, row = divmod(number, _ROWS)
        x = left + column * (right - left) / columns
        y = high - (row + 0.5) * (high - low) / _ROWS
        _draw_sample(axes, (x, y), sign=sign)
        words: dict[str, Any] = {"fontsize": _SMALL, "va": "center_baseline", "color": INK, "fontfamily": FONT}
        axes.text(x + _SAMPLE + 1.5, y, SIGNS[sign], **words)


def _draw_sample(axes: Axes, place: tuple[float, float], *, sign: str) -> None:
    """Draw a sample of a sign, as long as the samples are, beside its explanation."""
    x, y = place
    if sign == "thickness":
        axes.fill([x, x + _SAMPLE, x + _SAMPLE, x], [y, y, y - 1.2, y - 1.2], facecolor=FILL, edgecolor="none")
        axes.plot([x, x + _SAMPLE], [y, y], **STROKES["wall"])
    elif sign in STROKES:
        axes.plot([x, x + _SAMPLE], [y, y], **STROKES[sign])
    elif sign in ("cylinder", "corner"):
        marker, size = ("o", 6.0) if sign == "cylinder" else ("x", 4.0)
        axes.plot([x + _SAMPLE / 2], [y], marker=marker, markersize=size, color=INK, mfc=FILL, mew=0.6)
    else:
        words: dict[str, Any] = {
            "fontsize": _SMALL,
            "ha": "center",
            "va": "center_baseline",
            "color": INK,
            "fontfamily": FONT,
        }
        axes.text(x + _SAMPLE / 2, y, _SAMPLES[sign], **words)


def _box(axes: Axes, box: _Edges, *, facecolor: str = "white") -> Rectangle:
    """Draw a box: left, lower, right and upper edge."""
    from matplotlib.patches import Rectangle  # noqa: PLC0415 - half a second of import

    left, low, right, high = box
    frame = Rectangle((left, low), right - left, high - low, facecolor=facecolor, edgecolor=INK, linewidth=_THIN)
    axes.add_patch(frame)
    return frame
