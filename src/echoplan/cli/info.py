"""``echoplan info``: what is in a recording, and what is wrong with its readings."""

from dataclasses import asdict
from math import isnan
from typing import TYPE_CHECKING, Annotated, Any

import typer

from echoplan.cli.bag_summary import bag_document, put_bag
from echoplan.cli.source_options import (
    SOURCE_HELP,
    FieldOption,
    MountOption,
    OdomOption,
    TopicOption,
    bag_options,
    put_notes,
)
from echoplan.cli.terminal import Progressing, busy, put, show

if TYPE_CHECKING:
    from echoplan.model import Quality, Rig, Table
    from echoplan.preprocessing import Faults, RecordingFault, RecordingStatistics, SensorFault, SensorStatistics

__all__ = ["run"]


def run(
    source: Annotated[str, typer.Argument(help=SOURCE_HELP)],
    as_json: Annotated[bool, typer.Option("--json", help="Print all numbers as JSON.")] = False,
    topic: TopicOption = None,
    odom: OdomOption = None,
    field: FieldOption = None,
    mount: MountOption = None,
) -> None:
    """Show what is in a recording, rig, sweeps, pings and echoes, and what seems to be wrong with it.

    Of a ROS bag it shows the topics and sensors too, and what is missing for a map.

    Example: echoplan info rec/
    """
    from echoplan.diagnosis import examine  # noqa: PLC0415 - --help must not wait for NumPy
    from echoplan.io.text import format_json  # noqa: PLC0415
    from echoplan.preprocessing import find_faults, recording_statistics  # noqa: PLC0415
    from echoplan.sources import (  # noqa: PLC0415
        conventions_of,
        has_rig_file,
        notes_of,
        open_source,
        summary_of_bag,
    )

    bag = bag_options(topic, odom, field, mount)
    summary = summary_of_bag(source, bag)
    document = {"bag": bag_document(summary)} if summary else {}
    if summary is not None and not as_json:
        put_bag(source, summary)
    opened = open_source(source, bag=bag) if summary is None else summary.recording
    if opened is None:
        if as_json:
            put(format_json(document))
        return
    sweeps = tuple(Progressing(opened, "reading"))
    found, faults = recording_statistics(sweeps, opened.rig), find_faults(sweeps, opened.rig)
    with busy("checking the recording"):
        conventions = conventions_of(opened)
        quality = examine(opened.rig, sweeps, conventions=conventions, has_rig_file=has_rig_file(opened))
    if as_json:
        document |= _document(opened.name, opened.rig, found, faults)
        put(format_json({**document, "notes": list(notes_of(opened)), "quality": asdict(quality)}))
        return
    put_notes(opened)
    put(_headline(opened.name, opened.rig, found))
    show(_sensor_table(found))
    _say_what_is_wrong(quality)


def _say_what_is_wrong(quality: "Quality") -> None:
    for reason in quality.reasons or ("No mistake was found in how the recording is written.",):
        put(reason)
    if quality.next_step:
        put(f"Next step: {quality.next_step}")


def _document(name: str, rig: "Rig", found: "RecordingStatistics", faults: "Faults") -> dict[str, Any]:
    return {
        "name": name,
        "rig": rig.name,
        "sweeps": found.sweeps,
        "pings": sum(sensor.pings for sensor in found.sensors),
        "duration": found.duration,
        "way": found.way,
        "within": [found.low_xy.tolist(), found.high_xy.tolist()],
        "temperature": None if isnan(found.temperature) else found.temperature,
        "sensors": [_fields(sensor) for sensor in found.sensors],
        "faults": [*map(_fields, faults.recording), *map(_fields, faults.sensors)],
    }


def _fields(value: "SensorStatistics | SensorFault | RecordingFault") -> dict[str, Any]:
    return {key: None if isinstance(field, float) and isnan(field) else field for key, field in asdict(value).items()}


def _headline(name: str, rig: "Rig", found: "RecordingStatistics") -> str:
    pings = sum(sensor.pings for sensor in found.sensors)
    width, depth = found.high_xy - found.low_xy
    air = "" if isnan(found.temperature) else f", air of {found.temperature:.1f} degrees Celsius"
    counts = f"{_counted(found.sweeps, 'sweep')}, {_counted(pings, 'ping')}"
    return (
        f"{name}: {counts}, {found.duration:.1f} s, made by {rig.name!r} with {_counted(len(rig.sensors), 'sensor')}\n"
        f"path of the robot: {found.way:.2f} m within {width:.2f} x {depth:.2f} m{air}\n"
    )


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def _sensor_table(found: "RecordingStatistics") -> "Table":
    from echoplan.model import Table  # noqa: PLC0415

    return Table(
        title="Readings by sensor",
        columns=("sensor", "pings", "echo (%)", "no echo (%)", "too close (%)", "faulty (%)", "ranges (m)"),
        rows=tuple(
            (
                str(each.sensor_id),
                str(each.pings),
                *(
                    f"{100 * count / max(each.pings, 1):.1f}"
                    for count in (each.valid, each.silent, each.too_close, each.faulty)
                ),
                f"{each.shortest:.3f} to {each.longest:.3f}" if each.valid else "-",
            )
            for each in found.sensors
        ),
    )
