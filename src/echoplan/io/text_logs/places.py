"""Places: where the robot was at each reading."""

from collections.abc import Sequence

import numpy as np

from echoplan.arrays import FloatArray, IntArray
from echoplan.errors import InputError
from echoplan.io.text_logs.angles import understood_unit_of_angle
from echoplan.io.text_logs.columns import Role
from echoplan.io.text_logs.facts import Fact, Origin, stated_fact
from echoplan.io.text_logs.layout import POSE_ROLES
from echoplan.io.text_logs.options import LogOptions, Place, length_unit
from echoplan.io.text_logs.plausibility import plausible_position_units, spacing
from echoplan.io.text_logs.records import PlaceLine, Records
from echoplan.model import Conventions, Heading, Rig

__all__ = ["understood_places"]

# A robot that logs x and y alone may never have turned; no option says so but that all guesses are right.
_UNTURNED = Fact(subject="heading", value="always 0", origin=Origin.GUESSED, option="--yes")


def understood_places(
    records: Records, options: LogOptions, *, rig: Rig, passes: IntArray, files: IntArray, source: str
) -> tuple[FloatArray, float | None, tuple[Fact, ...]]:
    """Return the poses of the readings, shape (n, 3) [m, m, rad], the distance between places [m], and the facts.

    ``passes`` and ``files`` are the numbers of pass and file of each reading, shape (n,).
    """
    recorded, origin = _recorded(records, options, passes=passes, files=files, source=source)
    apart = spacing(recorded[:, :2])
    unit, unit_fact = _position_unit(records, options, rig=rig, apart=apart, source=source)
    angle, angle_fact = understood_unit_of_angle(
        recorded[:, 2], subject="unit of headings", given=options.heading_unit, written=records.unit(Role.HEADING)
    )
    heading = options.heading or Heading.COUNTER_CLOCKWISE
    conventions = Conventions(position_unit=unit, heading=heading)
    poses = conventions.poses(recorded * (1.0, 1.0, angle)).round(9) + 0.0
    is_unturned = (
        origin is Origin.STATED and records.column(Role.X) is not None and records.column(Role.HEADING) is None
    )
    facts = (
        Fact(subject="places", value=f"{len(np.unique(recorded, axis=0))}", origin=origin),
        *([_UNTURNED] if is_unturned else []),
        unit_fact,
        angle_fact,
        Fact(subject="headings grow", value=heading, origin=Origin.OPTION if options.heading else Origin.DEFAULT),
    )
    return poses, None if apart is None else apart * unit, facts


def _recorded(
    records: Records, options: LogOptions, *, passes: IntArray, files: IntArray, source: str
) -> tuple[FloatArray, Origin]:
    """Return the poses as they were written, shape (n, 3), and where."""
    recorded = _in_log(records, source=source)
    if options.places and recorded is not None:
        remedy = "leave out --place and --places, or take the places out of the log"
        raise InputError(source, "the log has places of its own", remedy=remedy)
    if options.places:
        return _given(options.places, passes=passes, files=files, source=source), Origin.OPTION
    if recorded is not None:
        return recorded, Origin.STATED
    problem = f"it does not say where the robot stood in its {passes.max() + 1} sweeps"
    remedy = 'give --place "x y heading" once for all or once a sweep, or print x,y,heading before each sweep'
    raise InputError(source, problem, remedy=remedy)


def _in_log(records: Records, *, source: str) -> FloatArray | None:
    """Return the places that the log has in lines before the readings, or in columns beside them, shape (n, 3)."""
    if PlaceLine in map(type, records.items):
        return _from_lines(records)
    poses = records.poses
    if poses is None:
        _check_parts(records, source)
    return poses


def _check_parts(records: Records, source: str) -> None:
    """Refuse a heading, an x or a y that changes where the others are missing: it is not thrown away."""
    for role in filter(records.column, POSE_ROLES):
        if len({reading.numbers[role] for reading in records.readings}) > 1:
            problem = f"its column {role.value!r} changes, and has no use without a column x and a column y"
            remedy = "log all of x, y and heading, or put them into --place, and - for this column into --columns"
            raise InputError(source, problem, remedy=remedy)


def _from_lines(records: Records) -> FloatArray:
    """Take the place before each reading."""
    poses = []
    for items in records.files:
        pose = None
        for item in items:
            if isinstance(item, PlaceLine):
                pose = item.pose
            elif pose is None:
                remedy = "write x,y,heading in a line before it"
                raise InputError(item.place, "there is a reading before any place of its file", remedy=remedy)
            else:
                poses.append((pose.x, pose.y, pose.heading))
        if isinstance(items[-1], PlaceLine) and records.is_standing:
            remedy = "write each place before its readings; delete this line if its readings were not logged"
            raise InputError(items[-1].place, "no reading follows this place", remedy=remedy)
    return np.array(poses)


def _given(places: Sequence[Place], *, passes: IntArray, files: IntArray, source: str) -> FloatArray:
    """Assign the places of the command line: one for all, one a file, or one a sweep of a single file."""
    poses = np.array([(place.x, place.y, place.heading) for place in places])
    file_count, pass_count = len(np.unique(files)), len(np.unique(passes))
    if len(places) == 1:
        return poses[np.zeros_like(files)]
    if len(places) == file_count:
        return poses[files]
    if len(places) == pass_count and file_count == 1:
        return poses[passes]
    counted = f"{pass_count} sweeps" if file_count == 1 else f"{file_count} files"
    problem = f"{len(places)} places are given for {counted}"
    raise InputError(source, problem, remedy="give one for each, in their order, or one for all")


def _position_unit(
    records: Records, options: LogOptions, *, rig: Rig, apart: float | None, source: str
) -> tuple[float, Fact]:
    """Return the metres in the unit of places; centimetres unless the distances between them show another."""
    subject, option = "unit of places", "--position-unit"
    fact = stated_fact(subject, given=options.position_unit, written=records.unit(Role.X))
    if fact is None and records.column(Role.X):
        raise InputError(source, "x and y have no unit", remedy=f"give it: {option} m, cm or mm")
    plausible = ["cm"] if apart is None else plausible_position_units(apart, rig.sensors[0])
    if fact is None and not plausible:
        problem = f"successive places are {apart:g} apart, which is no distance in m, cm or mm"
        raise InputError(source, problem, remedy=f"give their unit, such as {option} cm")
    if fact is None:
        name = plausible[0]
        origin = Origin.DEFAULT if name == "cm" else Origin.GUESSED
        fact = Fact(subject=subject, value=name, origin=origin, option=f"{option} {name}")
    return length_unit(fact.value, option=option), fact
