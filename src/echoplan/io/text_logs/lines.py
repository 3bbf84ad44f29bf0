"""Lines to records: time stamps of serial monitors, tuples of Python, and radar sketches that print no line ends."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

__all__ = ["Line", "records_of"]

# After the seconds, a comma begins a fraction only where Python's logging writes one; else it separates. A minus sign
# belongs to the number behind it.
_STAMP = re.compile(
    r"\s*\[?(?:(\d{4})-(\d\d)-(\d\d)[T ,;\t]\s*)?(\d{1,2}):(\d\d):(\d\d)(?:\.(\d{1,9})|,(\d{3})(?=[\s\]]))?"
    r"(?:Z|[-+]\d\d:\d\d)?"
    r"(?:\]\s*|\s*(?:->|>|[;,:|])\s*|\s+-\s+|\s+)"
)
# Their names in a header.
_STAMP_NAMES = re.compile(
    r"\s*(?:\"?(?:date|time|timestamp|datetime|clock|utc|datum|zeit|uhrzeit)\b[^,;|\t]*[,;|\t]\s*)+", re.IGNORECASE
)
# Share of lines with a time stamp from which they are stamps of a monitor, not part of what the robot says.
_STAMPED = 0.5
# The most copied radar sketch of an Arduino prints "angle,distance." again and again.
_RADAR = re.compile(r"(-?\d{1,3}),(\d{1,5}(?:\.\d+)?)\.")
# So many pairs in one line are no table with a stop at its end.
_FEWEST_PAIRS = 8
_HALF_DAY, _DAY = 43_200.0, 86_400.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """One record of a log: a line, or a part of one."""

    number: int
    text: str
    stamp: float | None = None


def records_of(texts: Sequence[str], *, keeps_blank: bool = False) -> tuple[list[Line], list[str]]:
    """Return the records of the lines of a log, and what was removed from them.

    Blank lines are left out. With ``keeps_blank`` those between others stay, unless they double the space of all lines.
    """
    lines = _kept(texts, keeps_blank=keeps_blank)
    found = []
    if sum(bool(_STAMP.match(line.text)) for line in lines) > _STAMPED * len(lines):
        lines = list(_without_stamps(lines))
        found.append("time stamps")
    pieces = [piece for line in lines if line.text.strip() or keeps_blank for piece in _split(line)]
    if len(pieces) > len(lines):
        found.append("several readings a line")
    return pieces, found


def _kept(texts: Sequence[str], *, keeps_blank: bool) -> list[Line]:
    """Return the lines that are not blank, and blank ones between them if these have a meaning."""
    numbers = [number for number, text in enumerate(texts, start=1) if text.strip()]
    is_double_spaced = len(numbers) < 2 or numbers[-1] - numbers[0] >= 2 * (len(numbers) - 1)
    if keeps_blank and not is_double_spaced:
        numbers = [*range(numbers[0], numbers[-1] + 1)]
    return [Line(number=number, text=texts[number - 1]) for number in numbers]


def _without_stamps(lines: Sequence[Line]) -> Iterator[Line]:
    """Take off the time stamps; midnight passes where the clock goes back by more than half a day."""
    midnights, last = 0.0, 0.0
    for line in lines:
        match = _STAMP.match(line.text)
        if match is None:
            yield replace(line, text=_STAMP_NAMES.sub("", line.text, count=1))
            continue
        year, month, day, hours, minutes, seconds, fraction, millis = match.groups()
        stamp = 3600.0 * int(hours) + 60.0 * int(minutes) + int(seconds) + float(f"0.{fraction or millis or 0}")
        if year:
            # Days of 31 a month are enough for times that only have to grow.
            stamp += _DAY * (31 * (12 * int(year) + int(month)) + int(day))
        elif last - stamp > _HALF_DAY:
            midnights += _DAY
        last = stamp
        yield replace(line, text=line.text[match.end() :], stamp=stamp + midnights)


def _split(line: Line) -> list[Line]:
    """Split a line that holds several readings."""
    text = line.text.strip()
    pairs = _RADAR.findall(text)
    if len(pairs) >= _FEWEST_PAIRS and len(_RADAR.sub("", text)) <= len(pairs[-1][0]) + len(pairs[-1][1]):
        return [replace(line, text=f"{angle},{distance}") for angle, distance in pairs]
    if text.startswith(("(", "[", "{")):
        # Python prints tuples, lists of tuples and dictionaries.
        parts = re.split(r"[)\]}]\s*,?\s*[(\[{]", text)
        cleaned = (re.sub(r"[()\[\]{}\"']", " ", part).strip().strip(",") for part in parts)
        return [replace(line, text=part) for part in cleaned if part]
    return [line]
