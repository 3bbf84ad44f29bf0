"""Ranges: their unit, and the readings that mean no echo."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.errors import InputError
from echoplan.io.text_logs.columns import Role
from echoplan.io.text_logs.facts import Fact, Origin, stated_fact
from echoplan.io.text_logs.options import MICROSECONDS, LogOptions, length_unit
from echoplan.io.text_logs.plausibility import no_echo_values, plausible_range_units
from echoplan.io.text_logs.records import Records
from echoplan.model import UNITS, Rig

__all__ = ["understood_ranges"]

# In dry air of 20 degrees Celsius; the factor 0.01716 cm per microsecond of many sketches is half of it [m/s].
_SPEED_OF_SOUND = 343.2
# A no-echo value within this share of the reach is as good as at its end: 399 of 400 cm.
_AT_REACH = 0.99


def understood_ranges(
    records: Records, options: LogOptions, *, rig: Rig, between: float | None, source: str
) -> tuple[FloatArray, Rig, tuple[Fact, ...]]:
    """Return the ranges, shape (n, sensors) [m], the rig with the speed of sound that was used, and the facts.

    ``between`` is the distance between successive places [m].
    """
    raw = np.array([reading.ranges for reading in records.readings])
    silent = no_echo_values(raw) if options.no_echo is None else list(options.no_echo)
    ranges = np.where(np.isin(raw, silent), np.inf, raw)
    echoes = ranges[np.isfinite(ranges)]
    _check_echoes(echoes, source)
    speed = rig.speed_of_sound or _SPEED_OF_SOUND
    units = {**{name: UNITS[name] for name in ("cm", "m", "mm", "in")}, MICROSECONDS: 0.5e-6 * speed}
    fact = _understood_unit(records, options, source=source) or _plausible_unit(
        plausible_range_units(echoes, rig.sensors[0], units=units, between=between), echoes, units=units, source=source
    )
    name = fact.value.split()[0]
    unit = units.get(name) or length_unit(name, option="--range-unit")
    used = replace(rig, speed_of_sound=speed) if name == MICROSECONDS else rig
    reach = _AT_REACH * float(rig.max_ranges.max()) / unit
    # Nanometres: 59.7 cm is 0.597 m, not 0.5970000000000001.
    return (
        (unit * ranges).round(9),
        used,
        (fact, *_no_echo_facts(raw, silent, is_given=options.no_echo is not None, reach=reach)),
    )


def _check_echoes(echoes: FloatArray, source: str) -> None:
    """Refuse logs without an echo, and negative distances that are not all the same."""
    if not echoes.size:
        raise InputError(source, "there is not one echo in it", remedy="check the wiring, or --no-echo and --columns")
    if echoes.min() < 0.0:
        problem = f"distances such as {echoes.min():g} are negative"
        raise InputError(source, problem, remedy=f"give --no-echo {echoes.min():g} if that means no echo")


def _understood_unit(records: Records, options: LogOptions, *, source: str) -> Fact | None:
    """Return the unit that is given or written, if any."""
    written = sorted({column.unit for column in records.columns if column.role is Role.RANGE})
    if len(written) > 1 and not options.range_unit:
        names = " and ".join(repr(each) for each in written)
        raise InputError(
            source, f"its distances have different units: {names}", remedy="give one, such as --range-unit cm"
        )
    return stated_fact("unit of distances", given=options.range_unit, written=written[0])


def _plausible_unit(plausible: Sequence[str], echoes: FloatArray, *, units: Mapping[str, float], source: str) -> Fact:
    """Choose the unit in which the numbers can be readings; anything but centimetres alone is a guess."""
    if not plausible:
        problem = f"distances from {echoes.min():g} to {echoes.max():g} fit this sensor in no unit"
        raise InputError(source, problem, remedy=f"give --range-unit ({', '.join(units)}), or another --rig")
    name, *others = plausible
    if plausible == ["cm"]:
        return Fact(subject="unit of distances", value=name, origin=Origin.DEFAULT)
    value = f"{name} (or {' or '.join(others)}?)" if others else name
    return Fact(subject="unit of distances", value=value, origin=Origin.GUESSED, option=f"--range-unit {name}")


def _no_echo_facts(raw: FloatArray, silent: Sequence[float], *, is_given: bool, reach: float) -> list[Fact]:
    """State which readings are no echo; a number within the reach of the sensor is a guess."""
    facts = []
    for value in silent:
        is_certain = value <= 0.0 or value >= reach
        origin = Origin.SEEN if is_certain else Origin.GUESSED
        facts.append(
            Fact(
                subject="no echo",
                value=f"{value:g} ({int((raw == value).sum())} readings)",
                origin=Origin.OPTION if is_given else origin,
                option=f"--no-echo {value:g}",
            )
        )
    missing = int(np.isposinf(raw).sum())
    if missing:
        facts.append(Fact(subject="no echo", value=f"no number ({missing} readings)", origin=Origin.SEEN))
    return facts
