"""Driving: poses by dead reckoning from the counts of wheel encoders in each line."""

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.errors import InputError
from echoplan.geometry import wrap
from echoplan.io.text_logs.angles import understood_unit_of_angle
from echoplan.io.text_logs.columns import Role
from echoplan.io.text_logs.facts import Fact, Origin
from echoplan.io.text_logs.options import LogOptions
from echoplan.io.text_logs.records import Records
from echoplan.model import Conventions, Heading

__all__ = ["check_wheels", "has_wheels", "understood_drive"]

# Counts since the row before go up and down with the speed: their mean change is a large part of all they reach.
_ANEW = 0.15
# Correlation of turns by the wheels with turns by the compass from which the direction of headings is certain: without
# any relation, one of 0.3 in 100 rows has a probability of 0.2 %.
_CERTAIN, _FEWEST_ROWS = 0.3, 100


def has_wheels(records: Records) -> bool:
    """Whether the poses follow from counts of both wheels, for the log has no positions beside them."""
    pairs = ((Role.LEFT, Role.RIGHT), (Role.LEFT_STEP, Role.RIGHT_STEP))
    return any(all(map(records.column, pair)) for pair in pairs) and not all(map(records.column, (Role.X, Role.Y)))


def check_wheels(records: Records, options: LogOptions, *, source: str) -> None:
    """Refuse options about wheels where none are read, and places where the wheels give them."""
    if not has_wheels(records) and (options.tick is not None or options.wheel_base is not None):
        problem = "--tick and --wheel-base have no effect, for its poses do not come from counts of both wheels"
        raise InputError(source, problem, remedy="leave them out, or name left,right or dleft,dright in --columns")
    if has_wheels(records) and options.places:
        remedy = "leave out --place and --places, or write - for the counts in --columns"
        raise InputError(source, "its wheels give the places", remedy=remedy)


def understood_drive(records: Records, options: LogOptions, *, source: str) -> tuple[FloatArray, tuple[Fact, ...]]:
    """Return the poses of the readings, shape (n, 3) [m, m, rad], from a start at the origin, and the facts."""
    if options.tick is None:
        problem = "the way of a wheel from one count of its encoder to the next is unknown"
        raise InputError(source, problem, remedy="give --tick with its unit, such as --tick 5mm")
    ways = options.tick * _counts(records, source=source)
    value = f"by dead reckoning, {1000.0 * options.tick:g} mm a count"
    fact = Fact(subject="places", value=value, origin=Origin.OPTION)
    if records.column(Role.HEADING) is None:
        if options.wheel_base is None:
            remedy = "name a heading in --columns, or give --wheel-base with its unit, such as --wheel-base 15cm"
            raise InputError(source, "nothing says how the robot turned", remedy=remedy)
        return _poses(ways, np.cumsum((ways[:, 1] - ways[:, 0]) / options.wheel_base)), (fact,)
    raw = np.array([reading.numbers[Role.HEADING] for reading in records.readings])
    unit, unit_fact = understood_unit_of_angle(
        raw, subject="unit of headings", given=options.heading_unit, written=records.unit(Role.HEADING)
    )
    heading_fact = _direction(ways, unit * raw, given=options.heading, source=source)
    recorded = np.column_stack([np.zeros_like(raw), np.zeros_like(raw), unit * raw])
    yaws = Conventions(heading=Heading(heading_fact.value)).poses(recorded)[:, 2]
    return _poses(ways, yaws), (fact, unit_fact, heading_fact)


def _counts(records: Records, *, source: str) -> FloatArray:
    """Return the counts of both wheels since the row before, shape (n, 2)."""
    if records.column(Role.LEFT) is None:
        return np.array([[each.numbers[Role.LEFT_STEP], each.numbers[Role.RIGHT_STEP]] for each in records.readings])
    running = np.array([[each.numbers[Role.LEFT], each.numbers[Role.RIGHT]] for each in records.readings])
    steps: FloatArray = np.diff(running, axis=0, prepend=running[:1])
    if np.abs(steps).mean() > _ANEW * max(float(np.ptp(running, axis=0).max()), 1.0):
        problem = "the counts of left and right go up and down from row to row, as counts since the row before do"
        raise InputError(source, problem, remedy="name the columns dleft,dright in --columns")
    return steps


def _direction(ways: FloatArray, headings: FloatArray, *, given: Heading | None, source: str) -> Fact:
    """Return how headings grow; refuse what the wheels contradict, and guess what they show."""
    shown, subject = _shown_direction(ways, headings), "headings grow"
    # A compass counts clockwise, too.
    said = Heading.CLOCKWISE if given is Heading.COMPASS else given
    if None not in (said, shown) and said is not shown:
        problem = f"headings are said to grow {given}, but by the wheels they grow {shown}"
        raise InputError(source, problem, remedy="correct --heading, or swap left and right in --columns")
    if given is not None:
        return Fact(subject=subject, value=given, origin=Origin.OPTION)
    if shown is Heading.CLOCKWISE:
        return Fact(subject=subject, value=shown, origin=Origin.GUESSED, option=f"--heading {shown}")
    return Fact(subject=subject, value=Heading.COUNTER_CLOCKWISE, origin=Origin.SEEN if shown else Origin.DEFAULT)


def _shown_direction(ways: FloatArray, headings: FloatArray) -> Heading | None:
    """Return how headings grow by the wheels, if it is certain."""
    turns, seen = ways[1:, 1] - ways[1:, 0], wrap(np.diff(headings))
    if len(turns) < _FEWEST_ROWS or not np.std(turns) * np.std(seen):
        return None
    correlation = float(np.corrcoef(turns, seen)[0, 1])
    if abs(correlation) <= _CERTAIN:
        return None
    return Heading.COUNTER_CLOCKWISE if correlation > 0.0 else Heading.CLOCKWISE


def _poses(ways: FloatArray, headings: FloatArray) -> FloatArray:
    """Add up the ways of both wheels [m], each along the heading halfway [rad]; the way of a row leads to its pose."""
    yaws = np.unwrap(headings)
    middle = yaws - 0.5 * np.diff(yaws, prepend=yaws[:1])
    forward = ways.mean(axis=1)
    forward[0] = 0.0
    return np.column_stack([np.cumsum(forward * np.cos(middle)), np.cumsum(forward * np.sin(middle)), yaws])
