"""Laws of the formats: what is written is read back exactly, and whatever is read, a fault is one line."""

import re
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from decimal import Decimal
from math import isfinite
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from echoplan.arrays import IntArray
from echoplan.errors import InputError
from echoplan.io import (
    read_map,
    read_recording,
    read_rig,
    read_route,
    read_truth,
    read_world,
    write_map,
    write_recording,
    write_rig,
    write_route,
    write_truth,
    write_world,
)
from echoplan.io.kinds import COUNT, NUMBER, READING, SECONDS, WHOLE
from echoplan.io.table import Table
from echoplan.model import (
    Firing,
    Odometry,
    Pillar,
    Polyline,
    Recording,
    Rig,
    Route,
    Sensor,
    Servo,
    Sweep,
    Transducer,
    Truth,
    World,
)
from helpers.any_map import angles, counts, lengths, maps, names, poses, sizes

stamps = st.integers(-(9 * 10**18), 9 * 10**18)


def same(one: object, other: object) -> bool:
    """Return whether two values are equal to the last bit, arrays and all."""
    if isinstance(one, np.ndarray):
        return isinstance(other, np.ndarray) and np.array_equal(one, other, equal_nan=one.dtype.kind == "f")
    if is_dataclass(one):
        pairs = ((getattr(one, field.name), getattr(other, field.name)) for field in fields(one))
        return type(one) is type(other) and all(same(mine, yours) for mine, yours in pairs)
    if isinstance(one, tuple):
        return isinstance(other, tuple) and len(one) == len(other) and all(map(same, one, other))
    return one == other or (one != one and other != other)  # noqa: PLR0124 - nan is no number, and the same


@st.composite
def sensors(draw: st.DrawFn, sensor_id: int) -> Sensor:
    return Sensor(
        sensor_id=sensor_id,
        x=draw(lengths),
        y=draw(lengths),
        yaw=draw(angles),
        half_aperture=draw(st.floats(0.01, 3.0)),
        min_range=draw(st.floats(0.0, 2.0)),
        max_range=draw(st.floats(3.0, 50.0)),
        resolution=draw(st.floats(0.0, 0.1)),
    )


optional_sizes = st.none() | sizes
odometries = st.builds(
    Odometry, along=optional_sizes, lateral=optional_sizes, yaw_per_metre=optional_sizes, yaw_per_radian=optional_sizes
)


@st.composite
def rigs(draw: st.DrawFn) -> Rig:
    ids = draw(st.lists(st.integers(-(2**40), 2**40), min_size=1, max_size=4, unique=True))
    start, sweep, step = draw(st.tuples(angles, sizes, sizes))
    servo = Servo(start=start / 2.0, stop=start / 2.0 + sweep / 2.0, step=step)
    groups = tuple(tuple(draw(st.lists(st.sampled_from(ids), min_size=1, max_size=3))) for _ in ids)
    return Rig(
        name=draw(names),
        sensors=tuple(draw(sensors(sensor_id)) for sensor_id in ids),
        base_from_turret=np.array(draw(poses)),
        servo=draw(st.sampled_from([None, servo])),
        firing=draw(st.sampled_from([None, Firing(period=step, groups=groups)])),
        transducer=draw(st.none() | st.builds(Transducer, frequency=sizes, figure_of_merit=lengths)),
        odometry=draw(st.none() | odometries),
        speed_of_sound=draw(st.none() | st.floats(300.0, 370.0)),
        rays=draw(st.none() | st.booleans()),
    )


@st.composite
def polylines(draw: st.DrawFn) -> Polyline:
    points = draw(st.lists(st.tuples(lengths, lengths), min_size=3, max_size=6, unique=True))
    return Polyline(points_xy=np.array(points), closed=draw(st.booleans()), material=draw(names))


worlds = st.builds(
    World,
    name=names,
    polylines=st.lists(polylines(), max_size=3).map(tuple),
    pillars=st.lists(
        st.builds(Pillar, center_xy=st.tuples(lengths, lengths).map(np.array), radius=sizes, material=names), max_size=3
    ).map(tuple),
)


@st.composite
def routes(draw: st.DrawFn) -> Route:
    times = sorted(draw(st.lists(stamps, min_size=1, max_size=8, unique=True)))
    way = np.array([draw(poses) for _ in times])
    return Route(map_from_base=way, stamps_ns=draw(st.sampled_from([None, np.array(times)])))


@st.composite
def recordings(draw: st.DrawFn) -> Recording:
    rig = draw(rigs())
    times = sorted(draw(st.lists(stamps, min_size=1, max_size=12)))
    cuts = sorted(draw(st.sets(st.integers(1, max(1, len(times) - 1)), max_size=4)))
    pieces = [piece for piece in np.split(np.array(times), cuts) if len(piece)]
    indices = sorted(draw(st.sets(counts, min_size=len(pieces), max_size=len(pieces))))
    readings = st.floats(0.0, 5.0) | st.sampled_from([np.inf, -np.inf])
    thermometer = st.floats(-30.0, 60.0) if draw(st.booleans()) else st.just(np.nan)
    return Recording(
        name="recording",
        rig=rig,
        sweeps=tuple(
            Sweep(
                index=index,
                stamps_ns=piece,
                sensor_ids=draw(columns(st.sampled_from(rig.sensor_ids.tolist()), piece)),
                servo_angles=draw(columns(angles, piece)),
                ranges=np.append(draw(columns(readings | st.just(np.nan), piece))[1:], draw(readings)),
                map_from_base=draw(columns(poses, piece)),
                temperature=draw(thermometer),
            )
            for index, piece in zip(indices, pieces, strict=True)
        ),
    )


def columns(entries: st.SearchStrategy[Any], like: IntArray) -> st.SearchStrategy[Any]:
    return st.lists(entries, min_size=len(like), max_size=len(like)).map(np.array)


@st.composite
def truths(draw: st.DrawFn) -> Truth:
    walls, cylinders, sweeps = draw(st.tuples(*3 * [st.integers(0, 4)]))
    return Truth(
        walls_xy=np.array([draw(st.lists(lengths, min_size=4, max_size=4)) for _ in range(walls)]).reshape(-1, 2, 2),
        walls_detected_by=np.array([draw(counts) for _ in range(walls)], dtype=np.int64),
        cylinders=np.array([draw(poses) for _ in range(cylinders)]).reshape(-1, 3),
        cylinders_detected_by=np.array([draw(counts) for _ in range(cylinders)], dtype=np.int64),
        poses=np.array([draw(poses) for _ in range(sweeps)]).reshape(-1, 3),
        given=np.array([draw(poses) for _ in range(sweeps)]).reshape(-1, 3),
        temperature=draw(st.none() | lengths),
    )


ROUND_TRIPS: dict[str, tuple[st.SearchStrategy[Any], Callable[..., None], Callable[..., Any]]] = {
    "rig.toml": (rigs(), write_rig, read_rig),
    "world.toml": (worlds, write_world, read_world),
    "route.csv": (routes(), write_route, read_route),
    "truth.json": (truths(), write_truth, read_truth),
    "map.json": (maps(), write_map, read_map),
}


@pytest.mark.parametrize("name", ROUND_TRIPS)
@hypothesis_settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_what_is_written_is_read_back_exactly(
    name: str, data: st.DataObject, tmp_path_factory: pytest.TempPathFactory
) -> None:
    values, write, read = ROUND_TRIPS[name]
    value = data.draw(values)
    path = tmp_path_factory.getbasetemp() / name
    write(path, value)
    assert same(read(path), value)


@hypothesis_settings(max_examples=60, deadline=None)
@given(recording=recordings())
def test_a_recording_is_read_back_exactly(recording: Recording, tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.getbasetemp() / "recording"
    write_recording(path, recording)
    again = read_recording(path)
    assert same(again.rig, recording.rig)
    assert same(tuple(again), recording.sweeps)
    assert len(again) == len(recording)


READERS = {"rig.toml": read_rig, "world.toml": read_world, "route.csv": read_route, "truth.json": read_truth}
encodings = st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "latin-1"])
garbage = st.binary() | st.builds(lambda text, name: text.encode(name, "ignore"), st.text(), encodings)


@pytest.mark.parametrize("name", [*READERS, "map.json"])
@hypothesis_settings(max_examples=60, deadline=None)
@given(content=garbage)
def test_any_file_is_read_or_refused_in_one_line(
    name: str, content: bytes, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.getbasetemp() / name
    path.write_bytes(content)
    message = ""
    try:
        READERS.get(name, read_map)(path)
    except InputError as error:
        message = str(error)
    assert len(message.splitlines()) <= 1


HEADER = "t,sweep,sensor,servo,range,x,y,yaw"
KINDS = (SECONDS, COUNT, WHOLE, NUMBER, READING, NUMBER, NUMBER, NUMBER)
cells = st.sampled_from(["0", "1", "0.5", "-2", "inf", "nan", "-inf", "", " ", "1e3", "1e400", "1_0", '"3"', '"']) | (
    lengths.map(repr) | stamps.map(str) | st.text(max_size=3)
)
pings = st.lists(st.lists(cells, min_size=7, max_size=9).map(",".join), max_size=4).map("\n".join)


@hypothesis_settings(max_examples=150, deadline=None)
@given(rows=pings, rig=rigs())
def test_any_pings_file_is_read_or_refused_in_one_line(
    rows: str, rig: Rig, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.getbasetemp() / "anything"
    path.mkdir(exist_ok=True)
    write_rig(path / "rig.toml", rig)
    (path / "pings.csv").write_text(f"{HEADER}\n{rows}", encoding="utf-8")
    message = ""
    try:
        list(read_recording(path))
    except InputError as error:
        message = str(error)
    assert len(message.splitlines()) <= 1


# What the documents say of a cell, written down a second time.
_DECIMAL = r"[-+]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]+)?"
_MEASURED = rf"{_DECIMAL}|[-+]?(?:inf|infinity|nan)|"
_QUOTED_ROW = re.compile(r'(?: *"((?:[^"]|"")*)"|( *[^", ][^,]*| *))(?:,|$)')


def reference_cells(line: str) -> list[str] | None:
    """Split a row, one character group after the other; nothing if a quoted cell has no end or something after it."""
    cells, at = [], 0
    while at <= len(line):
        cell = _QUOTED_ROW.match(line, at)
        if cell is None:
            return None
        cells.append((cell[2] if cell[1] is None else cell[1].replace('""', '"')).strip())
        at = cell.end() + (cell.end() == len(line) and not cell[0].endswith(","))
    return cells


def reference_number(name: str, cell: str) -> float | None:
    """Read one cell; nothing if it may not stand in its column."""
    grammar = _MEASURED if name == "range" else _DECIMAL
    if not re.fullmatch(grammar, cell, re.IGNORECASE):
        return None
    if not re.fullmatch(_DECIMAL, cell):
        return float(cell or "nan")
    if name not in ("t", "sweep", "sensor"):
        number = float(cell)
        return number if isfinite(number) and (name != "range" or number >= 0) else None
    exact = Decimal(cell)
    if exact.copy_abs() > 9 * 10**9 * (1 if name == "t" else 10**9):
        return None
    if name == "t":
        return round(exact * 10**9)
    return int(exact) if exact == exact.to_integral_value() and (name == "sensor" or exact >= 0) else None


@st.composite
def mutated_rows(draw: st.DrawFn) -> str:
    """Draw some rows of plain cells in which characters were put in, deleted or replaced."""
    plain = st.tuples(angles, st.floats(0.0, 5.0), *3 * [lengths])
    rows = [
        [f"{draw(counts) / 1e6:.6f}", str(draw(counts)), str(draw(counts)), *map(repr, draw(plain)), draw(notes)]
        for _ in range(draw(st.integers(1, 5)))
    ]
    text = "\n".join(map(",".join, rows)) + "\n"
    for _ in range(draw(st.integers(0, 3))):
        at, length = draw(st.integers(0, len(text) - 1)), draw(st.integers(0, 2))
        text = text[:at] + draw(st.text(alphabet='"",, \n.-+eE_09x;\u0663\t', max_size=2)) + text[at + length :]
    return text


notes = st.sampled_from(["", "a note", '"one, two"', '"a ""word"""', "\ufffd"])


@hypothesis_settings(max_examples=600, deadline=None)
@given(text=mutated_rows())
def test_a_mutated_table_is_read_as_the_documents_say_or_refused_in_the_line_of_the_fault(
    text: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    names = HEADER.split(",")
    path = tmp_path_factory.getbasetemp() / "mutated.csv"
    path.write_text(f"{HEADER},note\n{text}", encoding="utf-8")
    wanted, faulty = [], set()
    for number, line in enumerate(text.split("\n"), start=2):
        if line.strip():
            cells = reference_cells(line) or []
            row = [reference_number(name, cell) for name, cell in zip(names, cells, strict=False)]
            wanted.append(row)
            if len(cells) != len(names) + 1 or None in row:
                faulty.add(number)
    try:
        rows = [row for chunk in Table.open(path, dict(zip(names, KINDS, strict=True))) for row in chunk.data.tolist()]
    except InputError as error:
        blamed = re.search(r"line (\d+)", error.place)
        assert int(blamed[1]) in faulty if blamed else not wanted
        return
    assert not faulty
    np.testing.assert_array_equal(rows, wanted)
