"""Text logs: the recording that one or several files make, and what was understood of them."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from echoplan.errors import InputError, InvalidValueError
from echoplan.io.text_logs.angles import understood_angles
from echoplan.io.text_logs.damage import check_gaps, check_lost_places, without_damage
from echoplan.io.text_logs.decoding import read_lines
from echoplan.io.text_logs.dialect import check_thousands, recognise_dialect, rows_of
from echoplan.io.text_logs.driving import check_wheels, has_wheels, understood_drive
from echoplan.io.text_logs.facts import Fact, Origin, Skipped
from echoplan.io.text_logs.layout import recognise_layout
from echoplan.io.text_logs.lines import records_of
from echoplan.io.text_logs.options import LogOptions
from echoplan.io.text_logs.passes import pass_numbers, times_of_rows
from echoplan.io.text_logs.places import understood_places
from echoplan.io.text_logs.ranges import understood_ranges
from echoplan.io.text_logs.records import Grammar, Records, items_of, with_units
from echoplan.io.text_logs.sensors import understood_sensors
from echoplan.model import Recording, Sweep

__all__ = ["MOST_SKIPPED", "TextLog", "read_text_log"]

# Share of lines that may be skipped: in a log with more of them something else is wrong.
MOST_SKIPPED = 0.2


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class TextLog:
    """What was read of a text log.

    Parameters
    ----------
    recording : Recording
        The pings, in SI and REP 103.
    facts : tuple of Fact
        How the log was understood.
    skipped : tuple of Skipped
        Lines of which nothing was used.
    lines : int
        Number of lines that are not blank.
    """

    recording: Recording
    facts: tuple[Fact, ...]
    skipped: tuple[Skipped, ...]
    lines: int

    @property
    def guesses(self) -> tuple[Fact, ...]:
        """What must be confirmed before the recording is used."""
        return tuple(fact for fact in self.facts if fact.origin is Origin.GUESSED)


def read_text_log(paths: Sequence[Path], options: LogOptions | None = None) -> TextLog:
    r"""Read what a hobby robot printed: readings of ultrasonic sensors, and where they were taken.

    Parameters
    ----------
    paths : sequence of Path
        One file, or one for each place.
    options : LogOptions, optional
        What the log does not say, or says differently.

    Returns
    -------
    TextLog
        The recording and how the log was understood. A guess among its facts must be confirmed.

    Raises
    ------
    InputError
        If a file cannot be read, or does not say enough; the message names the option that does.

    Examples
    --------
    >>> path = getfixture("tmp_path") / "log.csv"
    >>> _ = path.write_text("angle,distance_cm,x_cm,y_cm,heading\n-90,59.7,60,60,30\n-88,0,60,60,30\n")
    >>> (sweep,) = read_text_log([path]).recording
    >>> sweep.ranges.tolist()
    [0.597, inf]
    """
    using, source = options or LogOptions(), str(paths[0])
    records, facts = _read_files(paths, using)
    rig, sensor_fact = understood_sensors(records.columns, using, source=source)
    angles, angle_facts = understood_angles(records, using, source=source)
    passes, files = pass_numbers(records, angles)
    check_wheels(records, using, source=source)
    if has_wheels(records):
        poses, place_facts = understood_drive(records, using, source=source)
        between = None
    else:
        poses, between, place_facts = understood_places(
            records, using, rig=rig, passes=passes, files=files, source=source
        )
    ranges, rig, range_facts = understood_ranges(records, using, rig=rig, between=between, source=source)
    times, time_fact = times_of_rows(records, sensors=len(rig.sensors), period=using.period, source=source)
    try:
        sweeps = tuple(
            Sweep(
                index=number,
                stamps_ns=np.rint(times[rows] * 1e9).astype(np.int64).ravel(),
                sensor_ids=np.tile(rig.sensor_ids, len(rows)),
                servo_angles=np.repeat(angles[rows], len(rig.sensors)),
                ranges=ranges[rows].ravel(),
                map_from_base=np.repeat(poses[rows], len(rig.sensors), axis=0),
            )
            for number, rows in enumerate(np.split(np.arange(len(passes)), np.flatnonzero(np.diff(passes)) + 1))
        )
    except InvalidValueError as error:
        raise InputError(source, str(error), remedy="check --columns and the units") from error
    name = paths[0].stem if len(paths) == 1 else paths[0].resolve().parent.name
    return TextLog(
        recording=Recording(name=name, rig=rig, sweeps=sweeps),
        facts=(*facts, *angle_facts, *range_facts, *place_facts, sensor_fact, time_fact),
        skipped=records.skipped,
        lines=records.lines,
    )


def _read_files(paths: Sequence[Path], options: LogOptions) -> tuple[Records, tuple[Fact, ...]]:
    """Read all files; they must be understood alike."""
    (first, facts), *others = [_read_file(path, options) for path in paths]
    joined = first
    for path, (records, _) in zip(paths[1:], others, strict=True):
        if records.columns != first.columns:
            problem = f"its columns are not those of {paths[0]}"
            raise InputError(path, problem, remedy="convert it by itself, or state --columns")
        joined = joined.joined(records)
    return joined, facts


def _read_file(path: Path, options: LogOptions) -> tuple[Records, tuple[Fact, ...]]:
    """Read one file: bytes, lines, cells, roles, readings and places."""
    source = str(path)
    texts, encoding = read_lines(path)
    lines, removed = records_of(texts, keeps_blank=options.angles is not None)
    if not lines:
        raise InputError(path, "it is empty", remedy="save what the serial monitor shows")
    dialect = recognise_dialect(lines, decimal_comma=options.decimal_comma)
    rows = rows_of(lines, dialect)
    if not options.decimal_comma:
        check_thousands(rows, dialect, source=source)
    layout = recognise_layout(rows, dialect, options=options, source=source)
    grammar = with_units(rows, Grammar(dialect=dialect, layout=layout, source=source))
    items = without_damage(items_of(rows, grammar))
    check_lost_places(items)
    check_gaps(items)
    kept = tuple(item for item in items if not isinstance(item, Skipped))
    records = Records(
        items=kept,
        columns=grammar.layout.readings,
        skipped=tuple(item for item in items if isinstance(item, Skipped)),
        lines=len(lines),
        counts=(len(kept),),
    )
    _check_skipped(records, source)
    return records, _facts(grammar, encoding=encoding, removed=removed)


def _facts(grammar: Grammar, *, encoding: str, removed: Sequence[str]) -> tuple[Fact, ...]:
    """State how the lines of a file are read."""
    are_labelled = any(isinstance(key, tuple) for key in grammar.layout.columns)
    separator = "labels" if are_labelled else grammar.dialect.name
    return (
        Fact(subject="encoding", value=encoding, origin=Origin.SEEN),
        Fact(subject="separator", value=separator, origin=Origin.SEEN),
        *(Fact(subject="removed", value=each, origin=Origin.SEEN) for each in removed),
        grammar.layout.fact,
    )


def _check_skipped(records: Records, source: str) -> None:
    """Refuse a log of which too much cannot be read."""
    if not (records.skipped or records.readings):
        raise InputError(source, "there is no reading in it", remedy='print lines such as "angle,distance"')
    lost, read = (sum(len(line.text) for line in lines) for lines in (records.skipped, records.readings))
    shares = (len(records.skipped) / records.lines, lost / (lost + read), float(not records.readings))
    if max(shares) > MOST_SKIPPED:
        reasons = [line.reason for line in records.skipped]
        reason = max(reasons, key=reasons.count)
        first = records.skipped[reasons.index(reason)]
        counted = f"{len(reasons)} of {records.lines} lines cannot be read"
        problem = f"{counted}, more than {100.0 * MOST_SKIPPED:.0f} % of the text; this one: {reason}"
        remedy = "print them otherwise, state --columns, or delete the lines that are no readings"
        raise InputError(source, problem, place=first.place.removeprefix(f"{source}, "), remedy=remedy)
