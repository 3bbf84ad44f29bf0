"""Damaged lines: what a reset, a lost character or two lines run together leave looks like a reading or a place."""

import re
from collections import Counter
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.errors import InputError
from echoplan.io.text_logs.columns import Role
from echoplan.io.text_logs.facts import Skipped
from echoplan.io.text_logs.records import Item, PlaceLine, Reading, skipped_line

__all__ = ["check_gaps", "check_lost_places", "without_damage"]

# Where nearly all distances are printed with one number of decimals, this share of others was cut off or run together;
# of fewer distances than so many nothing can be said.
_CUT_OFF, _FEWEST = 0.02, 20
# Share of the steps of the angle that are equal, from which a jump shows a damaged line.
_REGULAR = 0.9
# Part of a step by which rounding changes it.
_ROUNDING = 0.02
# Steps of the angle from which it is a jump, for a few readings may be missing; for wide steps, share of their span.
_JUMP, _WIDE = 5, 0.1
# Share of the span of angles that may be missing within a sweep: from more of them, a place may be missing, too.
_LOST = 0.2
# Lines between one that may have been a place and a new sweep.
_NEAR = 3
# The beginning of a line that may have been a place.
_NUMBERS = re.compile(r"[-+]?\d[\d.]*\s*[,;\t ]")


def without_damage(items: Sequence[Item]) -> list[Item]:
    """Skip what cannot be a reading or a place beside its neighbours."""
    whole = _skip(items, _cut_numbers(items), reason="its distance has not as many decimals as the others")
    whole = _skip(whole, _rare_blanks(whole), reason="its distance is missing, which is rare in this log")
    whole = _skip(whole, _lone_times(whole), reason="its time is not between those around it")
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


def _rare_blanks(items: Sequence[Item]) -> set[int]:
    """Return where there is no distance although nearly all lines have one: then it was cut off."""
    readings = [index for index, item in enumerate(items) if isinstance(item, Reading)]
    blank = {
        index
        for index, item in enumerate(items)
        if isinstance(item, Reading) and any(cell.decimals is None for cell in item.cells)
    }
    is_rare = len(readings) >= _FEWEST and len(blank) <= max(1, _CUT_OFF * len(readings))
    return blank if is_rare else set()


def _lone_times(items: Sequence[Item]) -> set[int]:
    """Return where the time lies off both neighbours, which are in order: a place among lines of as many numbers."""
    places = [index for index, item in enumerate(items) if isinstance(item, Reading) and Role.TIME in item.numbers]
    times = np.array(
        [item.numbers[Role.TIME] for item in items if isinstance(item, Reading) and Role.TIME in item.numbers]
    )
    before, now, after = np.append(-np.inf, times[:-1]), times, np.append(times[1:], np.inf)
    lone = (before <= after) & ((now < before) | (now > after))
    return {places[index] for index in np.flatnonzero(lone)}


def _lone_angles(items: Sequence[Item]) -> set[int]:
    """Return where an angle lies far off both neighbours although all others go in even steps."""
    places = [index for index, item in enumerate(items) if isinstance(item, Reading)]
    angles = _angles(items)
    # Before the first reading anything may have been.
    jumps = np.append(True, np.abs(np.diff(angles)) > _least_jump(angles))
    return {places[index] for index in np.flatnonzero(jumps[:-1] & jumps[1:])}


def _false_places(items: Sequence[Item]) -> set[int]:
    """Return the places in the middle of a sweep that goes on.

    A robot that says where it is before each reading interrupts all its sweeps: then they are places.
    """
    angles, seen, inside, places = _angles(items), 0, set[int](), 0
    jump = _least_jump(angles)
    for index, item in enumerate(items):
        seen += isinstance(item, Reading)
        if isinstance(item, PlaceLine):
            places += 1
            around = np.diff(angles[max(seen - 2, 0) : seen + 1])
            is_inside = len(around) == 2 and around.prod() > 0.0 and abs(around[1]) <= jump < np.inf
            inside |= {index} if is_inside else set()
    return inside if 2 * len(inside) <= places else set()


def check_lost_places(items: Sequence[Item]) -> None:
    """Refuse a log in which a sweep begins after a line that may have been a place: its pings would be misplaced."""
    jump = _least_jump(_angles(items)) if PlaceLine in map(type, items) else np.inf
    run, lost = list[float](), -_NEAR - 1
    for index, item in enumerate(items):
        if isinstance(item, Skipped):
            lost = index if _NUMBERS.match(item.text) else lost
            continue
        run = [*run[-2:], item.angle] if isinstance(item, Reading) else []
        if index - lost <= _NEAR and np.isfinite(jump) and _turns_back(run):
            line = items[lost]
            remedy = "write it as x,y,heading, or delete it if it is none"
            raise InputError(line.place, f"{line.text!r} may be a place that was not written whole", remedy=remedy)


def _turns_back(angles: Sequence[float]) -> bool:
    """Whether the servo turns back at the last of three angles, or flies back: a new sweep begins."""
    if len(angles) < 3:
        return False
    before, now = np.diff(angles)
    return bool(before * now <= 0.0)


def check_gaps(items: Sequence[Item]) -> None:
    """Refuse a log in which a sweep begins in its middle: lines are missing, and perhaps a place among them."""
    used = [item for item in items if not isinstance(item, Skipped)]
    readings = [item for item in used if isinstance(item, Reading)]
    angles, places = _angles(items), len(used) - len(readings)
    jump = _least_jump(angles)
    if np.isinf(jump) or not places:
        return
    moved = [isinstance(before, PlaceLine) for before, item in pairwise(used) if isinstance(item, Reading)]
    gaps = _gaps(angles, np.array(moved[1 - len(readings) :]), jump=jump)
    # Places that are typed while the servo sweeps on interrupt most sweeps.
    if 0 < len(gaps) <= places / 2:
        before, angle = angles[gaps[0] : gaps[0] + 2]
        problem = f"a sweep begins in its middle (the angle goes from {before:g} to {angle:g}): lines are missing"
        remedy = "write the place that is missing before it, or delete the sweep"
        raise InputError(readings[gaps[0] + 1].place, problem, remedy=remedy)


def _gaps(angles: FloatArray, moved: BoolArray, *, jump: float) -> IntArray:
    """Return after which angles a sweep begins in its middle; ``moved``, shape (n - 1,): a place lies between."""
    steps, now = np.diff(angles), angles[1:]
    before, after = np.append(0.0, steps[:-1]), np.append(steps[1:], 0.0)
    # A sweep begins at one end of the angles and goes to the other.
    is_low, is_high = now - angles.min() <= jump, angles.max() - now <= jump
    begins = (is_low & (after >= 0.0)) | (is_high & (after <= 0.0))
    goes_on = (steps * before > 0.0) & (np.abs(steps) <= _LOST * np.ptp(angles))
    is_jump = (np.abs(steps) > jump) & ~goes_on
    return np.flatnonzero((moved | is_jump) & ~begins)


def _angles(items: Sequence[Item]) -> FloatArray:
    return np.array([item.angle for item in items if isinstance(item, Reading)])


def _least_jump(angles: FloatArray) -> float:
    """Return from which size on a step between angles is a jump, if nearly all are of one size; else infinity."""
    steps = np.abs(np.diff(angles))
    step = float(np.median(steps)) if len(steps) else 0.0
    jump = min(_JUMP * step, max(2.5 * step, _WIDE * float(np.ptp(angles)))) if step > 0.0 else np.inf
    is_even = np.mean((np.abs(steps - step) <= _ROUNDING * step) | (steps > jump)) >= _REGULAR if len(steps) else False
    return jump if is_even else np.inf
