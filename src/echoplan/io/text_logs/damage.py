"""Damaged lines: what a reset, a lost character or two lines run together leave looks like a reading or a place."""

import re
from collections import Counter
from collections.abc import Sequence

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.errors import InputError
from echoplan.io.text_logs.facts import Skipped
from echoplan.io.text_logs.records import Item, PlaceLine, Reading, skipped_line

__all__ = ["check_lost_places", "without_damage"]

# Where nearly all distances are printed with one number of decimals, this share of others was cut off or run together;
# of fewer distances than so many nothing can be said.
_CUT_OFF, _FEWEST = 0.02, 20
# Share of the steps of the angle that are equal, from which a jump shows a damaged line.
_REGULAR = 0.95
# Part of a step by which rounding changes it.
_ROUNDING = 0.02
# Steps of the angle from which it is a jump: a few readings may be missing.
_JUMP = 5
# The beginning of a line that may have been a place.
_NUMBERS = re.compile(r"[-+]?\d[\d.]*\s*[,;\t ]\s*[-+\d]")


def without_damage(items: Sequence[Item]) -> list[Item]:
    """Skip what cannot be a reading or a place beside its neighbours."""
    whole = _skip(items, _cut_numbers(items), reason="its distance has not as many decimals as the others")
    whole = _skip(whole, _lone_angles(whole), reason="its angle does not belong between those around it")
    return _skip(whole, _false_places(whole), reason="it interrupts a sweep: two readings that ran together?")


def _skip(items: Sequence[Item], damaged: set[int], *, reason: str) -> list[Item]:
    return [
        skipped_line(item.place, item.text, reason=reason) if index in damaged else item
        for index, item in enumerate(items)
    ]


def _cut_numbers(items: Sequence[Item]) -> set[int]:
    """Return where a distance has not as many decimals as all others: digits are missing, or of two lines."""
    found = {index: item.decimals for index, item in enumerate(items) if isinstance(item, Reading)}
    counts = Counter(each for decimals in found.values() for each in decimals)
    usual, count = counts.most_common(1)[0] if counts else (0, 0)
    others = counts.total() - count
    if counts.total() < _FEWEST or others > max(1, _CUT_OFF * counts.total()):
        return set()
    return {index for index, decimals in found.items() if decimals - {usual}}


def _lone_angles(items: Sequence[Item]) -> set[int]:
    """Return where an angle lies far off both neighbours although all others go in even steps."""
    places = [index for index, item in enumerate(items) if isinstance(item, Reading)]
    angles = _angles(items)
    step = _even_step(angles)
    jumps = np.abs(np.diff(angles)) > _JUMP * step
    return {places[index + 1] for index in np.flatnonzero(jumps[:-1] & jumps[1:])} if step else set()


def _false_places(items: Sequence[Item]) -> set[int]:
    """Return the places in the middle of a sweep that goes on.

    A robot that says where it is before each reading interrupts all its sweeps: then they are places.
    """
    angles, seen, inside, places = _angles(items), 0, set[int](), 0
    step = _even_step(angles)
    for index, item in enumerate(items):
        seen += isinstance(item, Reading)
        if isinstance(item, PlaceLine):
            places += 1
            around = np.diff(angles[max(seen - 2, 0) : seen + 2])
            turn = np.sign(around)
            is_inside = len(around) == 3 and abs(turn.sum()) == 3 and abs(around[1]) <= _JUMP * step
            inside |= {index} if is_inside else set()
    return inside if 2 * len(inside) <= places else set()


def check_lost_places(items: Sequence[Item]) -> None:
    """Refuse a log in which a sweep begins after a line that may have been a place: its pings would be misplaced."""
    step = _even_step(_angles(items)) if PlaceLine in map(type, items) else 0.0
    run, lost = list[float](), None
    for item in items:
        if isinstance(item, Skipped):
            lost = item if _NUMBERS.match(item.text) else lost
            continue
        run = [*run[-2:], item.angle] if isinstance(item, Reading) else []
        if lost and _begins_anew(run, step):
            remedy = "write it as x,y,heading, or delete it if it is none"
            raise InputError(lost.place, f"{lost.text!r} may be a place that was not written whole", remedy=remedy)
        lost = None


def _begins_anew(angles: Sequence[float], step: float) -> bool:
    """Whether the last of three angles begins another sweep: after a jump, or where the servo turns back."""
    if len(angles) < 3 or not step:
        return False
    before, now = np.diff(angles)
    return bool(abs(now) > _JUMP * step or before * now <= 0.0)


def _angles(items: Sequence[Item]) -> FloatArray:
    return np.array([item.angle for item in items if isinstance(item, Reading)])


def _even_step(angles: FloatArray) -> float:
    """Return the step of angles of which nearly all go in steps of one size, else 0."""
    steps = np.abs(np.diff(angles))
    if not len(steps):
        return 0.0
    step = float(np.median(steps))
    return step if np.mean((np.abs(steps - step) <= _ROUNDING * step) | (steps > _JUMP * step)) >= _REGULAR else 0.0
